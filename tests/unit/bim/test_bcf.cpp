// BCF 2.1 and 3.0: a topic for every failing or undecided anchor and panel, valid against buildingSMART's schemas.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "artifacts/as_built_changes.hpp"
#include "artifacts/surface_judgement.hpp"
#include "artifacts/surfaces.hpp"
#include "building/ifc/bcf.hpp"
#include "building/ifc/bcf_surroundings.hpp"
#include "building/ifc/ifc_guid.hpp"
#include "building/judgement/worst_first.hpp"
#include "building/step/zip_writer.hpp"
#include "measured.hpp"
#include "small_building.hpp"
#include "test_support.hpp"
#include "unzipped.hpp"

namespace plumbline::ifc {
namespace test_bcf {

using test::unzipped;

std::map<std::string, std::string> example(bool version_3 = false, const AsBuiltChangesT* changes = nullptr) {
  const Design design = read_design(step::File(test::small_building("IFC4"), "t.ifc"), {});
  std::map<std::string, Eigen::Vector3d> deviations;
  for (const Element& element : design.elements)
    if (element.is_anchor)
      deviations[element.guid] = Eigen::Vector3d(0.001, 0, element.name == "F2-C1" ? 0.009 : 0.001);
  DeviationT deviation = test::judged(design, deviations, Eigen::Vector3d::Constant(1e-4), {1, 0, 0});
  deviation.anchors[0]->id = "A & <B>";
  BcfOptions options;
  options.project_guid = design.project_guid, options.date = "2026-05-12T10:00:00", options.epoch = "2026-05";
  options.version_3 = version_3, options.changes = changes;
  const std::string bytes =
      write_bcf(deviation, judgement::worst_first(deviation), judgement::worst_panels_first(deviation), options);
  EXPECT_EQ(write_bcf(deviation, judgement::worst_first(deviation), judgement::worst_panels_first(deviation), options),
            bytes);
  return unzipped(bytes);
}

TEST(Bcf, HasATopicForEveryIssueWithViewpointAndSnapshot) {
  const auto files = example();
  EXPECT_EQ(files.count("bcf.version"), 1u);
  EXPECT_EQ(files.size(), 1 + 3 * 2u);  // the anchor and the panel that fail
  for (const auto& [name, content] : files) {
    if (name.ends_with("snapshot.png")) {
      EXPECT_EQ(content.substr(1, 3), "PNG");
    }
    if (name.ends_with("markup.bcf")) {
      EXPECT_NE(content.find("<CreationDate>2026-05-12T10:00:00</CreationDate>"), std::string::npos);
      EXPECT_TRUE(uuid_from_text(name.substr(0, name.find('/')))) << name;
    }
  }
}

/// Of all panels and anchors, those that reach into a sphere are found, in their order.
TEST(Bcf, WhatIsAroundATopicIsFoundByItsPlace) {
  DeviationT deviation;
  const auto panel_at = [&](const Eigen::Vector3d& centre, double half) {
    auto panel = std::make_unique<PanelDeviationT>();
    for (const double x : {-half, half})
      for (const double z : {-half, half}) {
        panel->corners.push_back(std::make_unique<PanelCornerT>());
        panel->corners.back()->design = centre + Eigen::Vector3d(x, 0, z);
      }
    deviation.panels.push_back(std::move(panel));
  };
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d place(3.1 * (i % 20) - 20, i % 3 ? 0 : -14, 2.9 * (i / 20) - 9);
    panel_at(place, i == 77 ? 9 : 1.4);  // one is a whole wall
    deviation.anchors.push_back(std::make_unique<AnchorDeviationT>());
    deviation.anchors.back()->design = place;
  }
  const BcfSurroundings all(deviation);
  for (const Eigen::Vector3d& centre : {Eigen::Vector3d(-20, 0, -9), Eigen::Vector3d(3, -2, 20)}) {
    const auto around = all.around(centre, 6);
    EXPECT_LT(around.panels.size(), 250u);
    std::size_t found = 0;
    for (const auto& panel : deviation.panels) {
      double nearest = 1e300;
      for (const auto& corner : panel->corners) nearest = std::min(nearest, (corner->design - centre).norm());
      const auto at = std::find(around.panels.begin(), around.panels.end(), panel.get());
      if (nearest <= 6) {
        EXPECT_NE(at, around.panels.end());
      }
      if (at == around.panels.end()) continue;
      EXPECT_EQ(at - around.panels.begin(), static_cast<std::ptrdiff_t>(found++)) << "their order";
    }
    for (const auto& anchor : deviation.anchors)
      if ((anchor->design - centre).norm() <= 6) {
        EXPECT_NE(std::find(around.anchors.begin(), around.anchors.end(), anchor.get()), around.anchors.end());
      }
    EXPECT_NE(std::find(around.panels.begin(), around.panels.end(), deviation.panels[77].get()), around.panels.end());
  }
}

/// The count of entries in a ZIP has sixteen bits: more would be written as fewer.
TEST(Bcf, AZipWithMoreEntriesThanItCanCountIsRefused) {
  step::ZipWriter zip;
  for (std::size_t i = 0; i < step::ZipWriter::kMostEntries; ++i) zip.add(std::to_string(i), "");
  step::ZipWriter more = zip;
  EXPECT_FALSE(zip.finish().empty());
  more.add("one more", "");
  EXPECT_THROW(more.finish(), std::runtime_error);
}

/// The same topics and views in both versions, and of 3.0 what its schemas ask for.
TEST(Bcf, OfVersion3SaysTheSame) {
  const auto older = example(), newer = example(true);
  EXPECT_EQ(newer.size(), older.size() + 1);
  EXPECT_NE(newer.at("bcf.version").find("VersionId=\"3.0\""), std::string::npos);
  for (const char* label : {"FAIL", "2026-05"})
    EXPECT_NE(newer.at("extensions.xml").find("<TopicLabel>" + std::string(label) + "</TopicLabel>"),
              std::string::npos);
  for (const auto& [name, content] : older) {
    if (name == "bcf.version") continue;
    ASSERT_EQ(newer.count(name), 1u) << name;
    const std::string& other = newer.at(name);
    if (name.ends_with(".png")) {
      EXPECT_EQ(other, content);
    }
    for (const char* part :
         {"Title", "Description", "CameraViewPoint", "CameraDirection", "Selection", "CreationDate"}) {
      const auto of = [&](const std::string& text) {
        const std::size_t begin = text.find("<" + std::string(part) + ">");
        return begin == std::string::npos ? "" : text.substr(begin, text.find("</" + std::string(part)) - begin);
      };
      EXPECT_EQ(of(other), of(content)) << name;
    }
    if (!name.ends_with("markup.bcf")) continue;
    EXPECT_NE(other.find("<Header><Files><File IfcProject="), std::string::npos);
    EXPECT_NE(other.find("<Labels><Label>"), std::string::npos);
    EXPECT_NE(other.find("</ViewPoint></Viewpoints></Topic></Markup>"), std::string::npos);
  }
}

/// The camera of the topic of F2-C1 with what stands before it, and what its topic says.
struct Seen {
  Eigen::Vector3d camera, direction;
  std::string view, markup;
  /// Whether a point on the way from the anchor to the plane that cuts lies in the box, by many steps.
  bool free(const Eigen::Vector3d& anchor, const Element& box) const {
    for (int i = 0; i <= 4000; ++i) {
      const Eigen::Vector3d at = box.project_from_element.inverse() * Eigen::Vector3d(anchor - i / 4000.0 * direction);
      if ((at.array() > box.box_low.array()).all() && (at.array() < box.box_high.array()).all()) return false;
    }
    return true;
  }
};

Seen seen(const DeviationT& deviation, BcfOptions options, const std::vector<Element>& elements) {
  options.elements = &elements;
  Seen out;
  for (const auto& [name, content] : unzipped(write_bcf(deviation, judgement::worst_first(deviation), {}, options))) {
    if (name.ends_with("markup.bcf")) out.markup = content;
    if (name.ends_with("viewpoint.bcfv")) out.view = content;
  }
  const auto vector = [&](const std::string& name) {
    Eigen::Vector3d v;
    std::size_t at = out.view.find("<" + name + ">");
    for (int k = 0; k < 3; ++k) {
      at = out.view.find(std::string("<") + "XYZ"[k] + ">", at) + 3;
      v[k] = std::stod(out.view.substr(at));
    }
    return v;
  };
  out.camera = vector("CameraViewPoint"), out.direction = vector("CameraDirection");
  return out;
}

/// A wall before an anchor: it is looked at from beside it. A box around it: that is left out, and the topic says so.
TEST(Bcf, ACameraStandsWhereNothingOfTheDesignIsInTheWay) {
  const Design design = read_design(step::File(test::small_building("IFC4"), "t.ifc"), {});
  std::map<std::string, Eigen::Vector3d> deviations;
  Eigen::Vector3d anchor;
  for (const Element& element : design.elements)
    if (element.name == "F2-C1") deviations[element.guid] = Eigen::Vector3d(0, 0, 0.02), anchor = element.position;
  const DeviationT deviation = test::judged(design, deviations, Eigen::Vector3d::Constant(1e-4), {1, 0, 0});
  BcfOptions options;
  options.project_guid = design.project_guid;
  std::vector<Element> elements(1);
  Element& wall = elements[0];
  wall.guid = "4avctVUKr0kugbFTf53O9L", wall.ifc_class = "IfcWall", wall.name = "parapet", wall.has_box = true;
  // Far away it changes nothing.
  wall.box_low = Eigen::Vector3d(500, 0, 0), wall.box_high = Eigen::Vector3d(501, 1, 1);
  const Seen before = seen(deviation, options, elements);
  EXPECT_EQ(before.markup.find("parapet"), std::string::npos);
  EXPECT_TRUE(before.direction.isApprox(-(before.camera - anchor).normalized(), 1e-4));
  const auto place = [&](double near, double far, double wide) {  // along the view from before
    wall.project_from_element = RigidTransform(Eigen::Quaterniond::Identity(), anchor);
    const Eigen::Vector3d out = -before.direction;
    ASSERT_NEAR(out.cwiseAbs().maxCoeff(), 1, 1e-6) << "the building stands along the axes";
    const Eigen::Vector3d side = Eigen::Vector3d::Ones() - out.cwiseAbs();
    wall.box_low = (near * out).cwiseMin(far * out) - wide * side;
    wall.box_high = (near * out).cwiseMax(far * out) + wide * side;
  };
  place(0.4, 0.6, 0.2);
  EXPECT_FALSE(before.free(anchor, wall));
  const Seen beside = seen(deviation, options, elements);
  EXPECT_TRUE(beside.free(anchor, wall)) << beside.direction.transpose();
  EXPECT_NEAR((beside.camera - anchor).normalized().dot(-beside.direction), 1, 1e-4);
  EXPECT_NE(beside.markup.find("Seen from the right: before it stands IfcWall &#39;parapet&#39;. Only the boxes around "
                               "shapes were looked at."),
            std::string::npos)
      << beside.markup;
  EXPECT_EQ(beside.view.find(wall.guid), std::string::npos) << "it need not be hidden";
  place(0.0, 0.6, 50);
  const Seen behind = seen(deviation, options, elements);
  EXPECT_TRUE(behind.free(anchor, wall));
  EXPECT_NE(behind.markup.find("Seen from behind"), std::string::npos) << behind.markup;
  place(-0.6, 0.6, 0.6);
  const Seen inside = seen(deviation, options, elements);
  EXPECT_TRUE(inside.direction.isApprox(before.direction, 1e-6));
  const std::size_t hidden = inside.view.find("<Component IfcGuid=\"" + wall.guid + "\"/>");
  EXPECT_GT(hidden, inside.view.find("<Exceptions>"));
  EXPECT_LT(hidden, inside.view.find("</Exceptions>"));
  EXPECT_NE(inside.markup.find("No view of it is free: this one leaves out IfcWall &#39;parapet&#39;."),
            std::string::npos)
      << inside.markup;
  // An opening is nothing that stands there, and a panel is hidden without a word.
  wall.ifc_class = "IfcOpeningElement";
  EXPECT_EQ(seen(deviation, options, elements).view, before.view);
  wall.ifc_class = "IfcPlate", wall.is_panel = true;
  const Seen panel = seen(deviation, options, elements);
  EXPECT_NE(panel.view.find(wall.guid), std::string::npos);
  EXPECT_EQ(panel.markup, before.markup);
}

TEST(Bcf, SurfacesThatFailAndJointsHaveTopicsBesideThePanels) {
  const Design design = read_design(step::File(test::small_building("IFC4"), "t.ifc"), {});
  std::map<std::string, Eigen::Vector3d> deviations;
  std::string panel;
  for (const Element& element : design.elements) {
    if (element.is_anchor)
      deviations[element.guid] = Eigen::Vector3d(0.001, 0, element.name == "F2-C1" ? 0.009 : 0.001);
    if (element.name == "Panel 1") panel = element.guid;
  }
  const DeviationT deviation = test::judged(design, deviations, Eigen::Vector3d::Constant(1e-4), {1, 0, 0});
  SurfacesT surfaces;
  for (const char* name : {"Panel 1", "Panel 2"}) {
    surfaces.panels.push_back(std::make_unique<PanelSurfaceFiguresT>());
    auto& face = surfaces.panels.back()->face = std::make_unique<SurfaceFaceT>();
    face->id = name, face->guid = std::string(name) == "Panel 1" ? panel : "0000000000000000000002";
    face->origin = {5, 0, 3}, face->right = {1, 0, 0}, face->up = {0, 0, 1}, face->out = {0, -1, 0}, face->width = 1.5,
    face->height = 3;
  }
  surfaces.joints.push_back(std::make_unique<JointFiguresT>());
  surfaces.joints[0]->first = "Panel 1", surfaces.joints[0]->second = "Panel 2", surfaces.joints[0]->length = 3;
  surfaces.joints[0]->origin = {5.8, 0, 3};
  SurfaceJudgementT judgement;
  for (const char* second : {"", "Panel 2"}) {
    auto verdict = std::make_unique<SurfaceVerdictT>();
    verdict->panel = "Panel 1", verdict->second = second, verdict->guid = *second ? "" : panel;
    verdict->quantity = *second ? "joint" : "flatness", verdict->length = *second ? std::nan("") : 1;
    verdict->value = *second ? -0.0031 : 0.0042, verdict->sigma = 3e-4, verdict->upper = 0.003, verdict->lower = -0.003,
    verdict->probability = 0.01;
    verdict->verdict = *second ? ToleranceVerdict::undecided : ToleranceVerdict::fail,
    verdict->rule = "*: flatness(1m)=3mm";
    judgement.verdicts.push_back(std::move(verdict));
  }
  BcfOptions options;
  options.project_guid = design.project_guid;
  const auto topics = [&] {
    std::string all;
    for (const auto& [name, content] :
         unzipped(write_bcf(deviation, {}, judgement::worst_panels_first(deviation), options)))
      if (name.ends_with("markup.bcf")) all += content;
    return all;
  };
  EXPECT_EQ(topics().find("Surface of panel"), std::string::npos);
  options.surfaces = &surfaces, options.surface_judgement = &judgement;
  const std::string all = topics();
  EXPECT_NE(all.find("<Title>Panel Panel 1"), std::string::npos) << "the panel's own topic stays";
  EXPECT_NE(all.find("Surface of panel Panel 1: flatness(1m) 4.2 mm (limit 3.0)"), std::string::npos) << all;
  EXPECT_NE(all.find("Joint Panel 1 | Panel 2: joint -3.1 mm (limit -3.0)"), std::string::npos) << all;
}

TEST(Bcf, AJointOfPanelsThatShareANameSelectsItsOwn) {
  const Design design = read_design(step::File(test::small_building("IFC4"), "t.ifc"), {});
  const DeviationT deviation = test::judged(design, {}, Eigen::Vector3d::Constant(1e-4), {1, 0, 0});
  SurfacesT surfaces;
  SurfaceJudgementT judgement;
  for (int i : {0, 1, 2}) {
    surfaces.panels.push_back(std::make_unique<PanelSurfaceFiguresT>());
    auto& face = surfaces.panels.back()->face = std::make_unique<SurfaceFaceT>();
    face->id = "Panel", face->guid = "000000000000000000000" + std::to_string(i);
    face->right = {1, 0, 0}, face->up = {0, 0, 1}, face->out = {0, -1, 0}, face->width = 1.5, face->height = 3;
  }
  for (int j : {0, 1}) {
    surfaces.joints.push_back(std::make_unique<JointFiguresT>());
    JointFiguresT& joint = *surfaces.joints.back();
    joint.first = joint.second = "Panel", joint.length = 3, joint.first_panel = j, joint.second_panel = j + 1;
    auto verdict = std::make_unique<SurfaceVerdictT>();
    verdict->panel = verdict->second = "Panel", verdict->quantity = "joint", verdict->item = j;
    verdict->value = 0.0042, verdict->sigma = 3e-4, verdict->upper = 0.003, verdict->lower = -0.003,
    verdict->probability = 0.01;
    verdict->verdict = j == 1 ? ToleranceVerdict::fail : ToleranceVerdict::pass, verdict->rule = "*: joint=3mm";
    judgement.verdicts.push_back(std::move(verdict));
  }
  BcfOptions options;
  options.project_guid = design.project_guid, options.surfaces = &surfaces, options.surface_judgement = &judgement;
  std::string views;
  for (const auto& [name, content] : unzipped(write_bcf(deviation, {}, {}, options)))
    if (name.ends_with("viewpoint.bcfv")) views += content;
  EXPECT_NE(views.find("<Selection><Component IfcGuid=\"0000000000000000000001\"/>"), std::string::npos) << views;
  EXPECT_EQ(views.find("<Selection><Component IfcGuid=\"0000000000000000000000\"/>"), std::string::npos)
      << "the joint that passes has no topic";
  EXPECT_EQ(views.find("<Selection><Component IfcGuid=\"0000000000000000000002\"/>"), std::string::npos);
}

/// Of the anchors of small_building: F1-C1 was mended, F2-C1 fails again, F1-C2 was open and nobody measured it, F2-C2
/// is in order as it was.
AsBuiltChangesT changes_of_example() {
  AsBuiltChangesT changes;
  changes.compared = true, changes.before = "2026-04", changes.after = "2026-05";
  const auto add = [&](const char* guid, ToleranceVerdict before, ToleranceVerdict after, ChangeKind kind) {
    auto change = std::make_unique<AsBuiltChangeT>();
    change->kind = "anchor", change->id = change->guid = guid;
    change->before = before, change->after = after, change->change = kind;
    changes.changes.push_back(std::move(change));
  };
  using enum ToleranceVerdict;
  add("11vctVUKr0kugbFTf53O9L", fail, pass, ChangeKind::mended);
  add("21vctVUKr0kugbFTf53O9L", pass, fail, ChangeKind::opened_again);
  add("12vctVUKr0kugbFTf53O9L", fail, not_measured, ChangeKind::unseen);
  add("22vctVUKr0kugbFTf53O9L", pass, pass, ChangeKind::in_order);
  add("00vctVUKr0kugbFTf53O9L", undecided, not_measured, ChangeKind::left_out);
  return changes;
}

TEST(Bcf, WhatWasMendedIsClosedAndWhatNobodyMeasuredAgainStaysOpen) {
  // The topics of the campaign before, by element.
  const Design design = read_design(step::File(test::small_building("IFC4"), "t.ifc"), {});
  std::map<std::string, Eigen::Vector3d> deviations;
  for (const Element& element : design.elements)
    if (element.is_anchor) deviations[element.guid] = Eigen::Vector3d(0.02, 0, 0);
  const DeviationT before = test::judged(design, deviations, Eigen::Vector3d::Constant(1e-4), {1, 0, 0});
  BcfOptions options;
  options.project_guid = design.project_guid, options.epoch = "2026-04";
  std::map<std::string, std::string> topic_of;  // by GlobalId
  const auto topics = unzipped(write_bcf(before, judgement::worst_first(before), {}, options));
  for (const auto& [name, content] : topics)  // but that of what all of them have in common
    if (name.ends_with("viewpoint.bcfv") &&
        topics.at(name.substr(0, name.find('/')) + "/markup.bcf").find("<Title>Anchor ") != std::string::npos) {
      const std::size_t at = content.find("<Selection><Component IfcGuid=\"") + 31;
      topic_of[content.substr(at, 22)] = name.substr(0, name.find('/'));
    }
  const AsBuiltChangesT changes = changes_of_example();
  const auto files = example(false, &changes);
  const auto markup = [&](const std::string& guid) {
    const auto file = files.find(topic_of.at(guid) + "/markup.bcf");
    return file == files.end() ? std::string("no topic") : file->second;
  };
  const std::string mended = markup("11vctVUKr0kugbFTf53O9L"), again = markup("21vctVUKr0kugbFTf53O9L"),
                    unseen = markup("12vctVUKr0kugbFTf53O9L");
  EXPECT_NE(mended.find("TopicStatus=\"Closed\""), std::string::npos) << mended;
  EXPECT_NE(mended.find("<Comment>2026-04: fail; 2026-05: pass.</Comment>"), std::string::npos) << mended;
  EXPECT_NE(mended.find("viewpoint.bcfv"), std::string::npos) << "it is still seen where it is";
  EXPECT_NE(again.find("TopicStatus=\"Open\""), std::string::npos) << again;
  EXPECT_NE(again.find("<Comment>2026-04: pass; 2026-05: fail.</Comment>"), std::string::npos) << again;
  EXPECT_NE(unseen.find("TopicStatus=\"Open\""), std::string::npos) << unseen;
  EXPECT_NE(unseen.find("was open, and was not measured again"), std::string::npos) << unseen;
  EXPECT_EQ(markup("22vctVUKr0kugbFTf53O9L"), "no topic");
  std::string all;
  for (const auto& [name, content] : files) all += name.ends_with("markup.bcf") ? content : "";
  EXPECT_NE(all.find("no longer in the design or the plate table"), std::string::npos) << "and never silently dropped";
  // What the next campaign says of the same topic is another comment.
  const auto comment = [](const std::string& text) { return text.substr(text.find("<Comment Guid=") + 15, 36); };
  AsBuiltChangesT later = changes_of_example();
  later.before = "2026-05", later.after = "2026-06";
  const auto next = example(false, &later);
  EXPECT_NE(comment(next.at(topic_of.at("11vctVUKr0kugbFTf53O9L") + "/markup.bcf")), comment(mended));
}

/// What is no element's own: a doubt of this campaign, and a shift that the one before had.
TEST(Bcf, FindingsKeepTheirTopicsAndAreClosedWhenTheyAreGone) {
  const Design design = read_design(step::File(test::small_building("IFC4"), "t.ifc"), {});
  std::map<std::string, Eigen::Vector3d> deviations;
  for (const Element& element : design.elements)
    if (element.is_anchor) deviations[element.guid] = Eigen::Vector3d(0.001, 0, 0.009);
  auto doubt = test::doubt("known points contradict it: P1 E +5.0 mm");
  doubt.about = "known points";
  DeviationT deviation = test::judged(design, deviations, Eigen::Vector3d::Constant(1e-4), {1, 0, 0}, {}, {doubt});
  deviation.common_shift.reset(), deviation.group_shifts.clear();
  auto shift = std::make_unique<GroupShiftT>();
  shift->kind = "axis", shift->name = "Axis 3", shift->significant = true, shift->members = {0, 2};
  shift->shift.setZero(), shift->u.setZero(), shift->spread.setZero();
  shift->finding = "Axis 3 stands 9.0 mm ± 0.1 mm high", shift->words = shift->finding + " (2 of its 2 share it).";
  deviation.group_shifts.push_back(std::move(shift));
  BcfOptions options;
  options.project_guid = design.project_guid;
  const auto topics = [&](const DeviationT& judged) {  // topic and markup, by the first words of its title
    std::map<std::string, std::pair<std::string, std::string>> found;
    const auto files = unzipped(write_bcf(judged, judgement::worst_first(judged), {}, options));
    for (const auto& [name, content] : files) {
      if (!name.ends_with("markup.bcf")) continue;
      const std::string title = content.substr(content.find("<Title>") + 7, 6), id = name.substr(0, name.find('/'));
      const auto view = files.find(id + "/viewpoint.bcfv");
      found[title] = {id, content + (view != files.end() ? view->second : "")};
    }
    return found;
  };
  auto before = topics(deviation);
  for (const std::size_t member : {0, 2})
    EXPECT_NE(before["Axis 3"].second.find("IfcGuid=\"" + deviation.anchors[member]->guid), std::string::npos)
        << "the anchors of a grid axis are selected";
  EXPECT_EQ(before["Axis 3"].second.find("IfcGuid=\"" + deviation.anchors[1]->guid), std::string::npos);
  deviation.doubts[0]->reason = "known points contradict it: P1 E +6.5 mm";
  EXPECT_EQ(topics(deviation)["Measur"].first, before["Measur"].first) << "its figures are others";
  AsBuiltChangesT changes;
  changes.compared = true, changes.before = "May", changes.after = "June", changes.together.setZero();
  auto gone = std::make_unique<FindingChangeT>();
  gone->topic = "shift of Axis 3", gone->kind = "shift", gone->title = deviation.group_shifts[0]->finding;
  gone->change = ChangeKind::settled, gone->anchors = {deviation.anchors[0]->guid, deviation.anchors[2]->guid};
  changes.findings.push_back(std::move(gone));
  options.changes = &changes, deviation.group_shifts.clear();
  auto after = topics(deviation);
  EXPECT_EQ(after["Axis 3"].first, before["Axis 3"].first);
  EXPECT_NE(after["Axis 3"].second.find("TopicStatus=\"Closed\""), std::string::npos) << after["Axis 3"].second;
  EXPECT_NE(after["Axis 3"].second.find("<Comment>May: found; June: not found any more.</Comment>"), std::string::npos);
  changes.findings.back()->note = "now: Axis 3 stands 3.1 mm low; none of its anchors is out by it";
  const std::string there = topics(deviation)["Axis 3"].second;
  EXPECT_NE(there.find("TopicStatus=\"Closed\""), std::string::npos) << there;
  EXPECT_NE(
      there.find(
          "<Comment>May: found; June: now: Axis 3 stands 3.1 mm low; none of its anchors is out by it.</Comment>"),
      std::string::npos);
  EXPECT_EQ(there.find("not found any more"), std::string::npos) << "neither the comment nor the title";
}

/// A topic of a surface is closed when all that was open of it was measured again and keeps its limits.
TEST(Bcf, TopicsOfSurfacesAndJointsAreClosedByMeasuringAgain) {
  const std::string panel = "3avctVUKr0kugbFTf53O9L";
  const auto files_after = [&](ChangeKind flatness, ChangeKind twist, ChangeKind step) {
    AsBuiltChangesT changes;
    changes.before = "2026-04", changes.after = "2026-05", changes.compared = true;
    const auto add = [&](const std::string& topic, const std::string& id, ChangeKind change) {
      changes.changes.push_back(std::make_unique<AsBuiltChangeT>());
      AsBuiltChangeT& one = *changes.changes.back();
      one.kind = topic == "surface" ? "surface" : "joint", one.topic = topic, one.id = id, one.guid = panel;
      one.before = ToleranceVerdict::fail, one.change = change;
      one.after = change == ChangeKind::unseen ? ToleranceVerdict::not_measured : ToleranceVerdict::pass;
    };
    add("surface", "Panel 1, flatness(1m)", flatness), add("surface", "Panel 1, twist", twist);
    add("joint/Panel 2", "Panel 1 | Panel 2, step", step);
    std::map<std::string, std::string> by_title;
    for (const auto& [name, content] : example(false, &changes))
      if (name.ends_with("markup.bcf")) {
        const std::size_t at = content.find("<Title>") + 7;
        by_title[content.substr(at, content.find("</Title>") - at)] = content;
      }
    return by_title;
  };
  auto both = files_after(ChangeKind::mended, ChangeKind::mended, ChangeKind::unseen);
  const std::string& closed = both["Surface of panel Panel 1, flatness(1m): mended"];
  EXPECT_NE(closed.find("TopicStatus=\"Closed\""), std::string::npos) << closed;
  EXPECT_NE(closed.find("Panel 1, twist: 2026-04: fail; 2026-05: pass."), std::string::npos) << closed;
  EXPECT_NE(both["Joint Panel 1 | Panel 2, step: was open, and was not measured again"].find("TopicStatus=\"Open\""),
            std::string::npos);
  EXPECT_NE(both.begin()->first.find("Anchor"), std::string::npos) << "what fails now has its topics as before";
  auto half = files_after(ChangeKind::mended, ChangeKind::unseen, ChangeKind::settled);
  const std::string& open = half["Surface of panel Panel 1, twist: was open, and was not measured again"];
  EXPECT_NE(open.find("TopicStatus=\"Open\""), std::string::npos) << "half of it is no reason to close it";
  EXPECT_NE(half["Joint Panel 1 | Panel 2, step: in order, was undecided"].find("TopicStatus=\"Closed\""),
            std::string::npos);
}

TEST(Bcf, ADoubtHasATopicAndItsAnchorsSayWhy) {
  const Design design = read_design(step::File(test::small_building("IFC4"), "t.ifc"), {});
  std::map<std::string, Eigen::Vector3d> deviations;
  for (const Element& element : design.elements)
    if (element.is_anchor) deviations[element.guid] = Eigen::Vector3d(0.001, 0, 0.009);
  const std::string doubt = "the survey: station 3 contradicts itself";
  const DeviationT deviation = test::judged(design, deviations, Eigen::Vector3d::Constant(1e-4), {1, 0, 0}, {},
                                            {test::doubt("station 3 contradicts itself")});
  BcfOptions options;
  options.project_guid = design.project_guid;
  const auto files = unzipped(
      write_bcf(deviation, judgement::worst_first(deviation), judgement::worst_panels_first(deviation), options));
  int of_doubt = 0, of_anchors = 0;
  for (const auto& [name, content] : files) {
    if (!name.ends_with("markup.bcf")) continue;
    of_doubt += content.find("<Title>Measurement not to be trusted") != std::string::npos;
    if (content.find("<Title>Anchor") == std::string::npos) continue;
    ++of_anchors;
    EXPECT_NE(content.find("not decided: " + doubt), std::string::npos) << content;
  }
  EXPECT_EQ(of_doubt, 1);
  EXPECT_GT(of_anchors, 1);
}

TEST(Bcf, IsValidAgainstItsSchemas) {
  PLUMBLINE_REQUIRE_DATA("bcf/markup.xsd");
  if (std::system("xmllint --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "xmllint is not installed";
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("plumbline_bcf_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  int number = 0;
  const AsBuiltChangesT changes = changes_of_example();
  for (const auto& [name, content] : example(false, &changes)) {
    const std::string schema = name == "bcf.version"     ? "version"
                               : name.ends_with(".bcf")  ? "markup"
                               : name.ends_with(".bcfv") ? "visinfo"
                                                         : "";
    if (schema.empty()) continue;
    const std::filesystem::path file = folder / std::to_string(number++);
    std::ofstream(file, std::ios::binary) << content;
    const std::string command = "xmllint --noout --schema '" + test::data_file("bcf/" + schema + ".xsd").string() +
                                "' '" + file.string() + "' 2>&1";
    EXPECT_EQ(std::system(command.c_str()), 0) << name << "\n" << content;
  }
  std::filesystem::remove_all(folder);
}

}  // namespace test_bcf
}  // namespace plumbline::ifc

// Buildings of thirteen shapes, whole, cut to one trade and behind a podium, in the cases that once were silent: nobody
// is sent the wrong way, nothing passes that is out, nothing that was asked for is dropped, and all outputs say so.
// PLUMBLINE_LONG=1 runs every shape with every cut and case.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

#include "../bim/building_shapes.hpp"
#include "agreement.hpp"
#include "artifacts.hpp"
#include "build/evaluate/design_input.hpp"
#include "building/ifc/as_built_ifc.hpp"
#include "building/ifc/bcf.hpp"
#include "building/ifc/ifc_guid.hpp"
#include "building/ifc/match_elements.hpp"
#include "building/judgement/worst_first.hpp"

namespace plumbline::judgement {
namespace test_shapes_agreement {

using plumbline::test::Cut;
using plumbline::test::kDegree;
using plumbline::test::Shape;
using test::mm;
using test::Normal;

std::string shape_guid(const std::string& key) { return ifc::derived_ifc_guid("0YvctVUKr0kugbFTf53O9L", key); }

/// Lines of an IFC4 file whose numbers ascend.
class Lines {
 public:
  std::string add(const std::string& text) {
    out_ += "#" + std::to_string(++number_) + "=" + text + ";\n";
    return "#" + std::to_string(number_);
  }
  std::string file() const {
    return "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('s.ifc','2024-01-01T00:00:00',(''),(''),"
           "'','','');\nFILE_SCHEMA(('IFC4'));\nENDSEC;\nDATA;\n" +
           out_ + "ENDSEC;\nEND-ISO-10303-21;\n";
  }

 private:
  std::string out_;
  int number_ = 0;
};

std::string real(double value) { return std::to_string(value); }

/// The shape as a design: two storeys of anchors, cladding before them, slabs.
std::string ifc_of(const Shape& shape, Cut cut) {
  Lines l;
  const std::string history = "$", origin = l.add("IFCCARTESIANPOINT((0.,0.,0.))"),
                    axes = l.add("IFCAXIS2PLACEMENT3D(" + origin + ",$,$)"), up = l.add("IFCDIRECTION((0.,0.,1.))");
  const std::string context = l.add("IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-05," + axes + ",$)");
  const std::string units = l.add("IFCUNITASSIGNMENT((" + l.add("IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.)") + "," +
                                  l.add("IFCSIUNIT(*,.PLANEANGLEUNIT.,$,.RADIAN.)") + "))");
  const std::string project =
      l.add("IFCPROJECT('0YvctVUKr0kugbFTf53O9L',$,'P',$,$,$,$,(" + context + ")," + units + ")");
  const std::string world = l.add("IFCLOCALPLACEMENT($," + axes + ")"),
                    building =
                        l.add("IFCBUILDING('" + shape_guid("b") + "',$,'B',$,$," + world + ",$,$,.ELEMENT.,$,$,$)");
  l.add("IFCRELAGGREGATES('" + shape_guid("r") + "',$,$,$," + project + ",(" + building + "))");
  const std::string plane = l.add("IFCAXIS2PLACEMENT2D(" + l.add("IFCCARTESIANPOINT((0.,0.))") + ",$)");
  const auto box = [&](double x, double y, double z) {
    const std::string profile = l.add("IFCRECTANGLEPROFILEDEF(.AREA.,$," + plane + "," + real(x) + "," + real(y) + ")");
    const std::string solid = l.add("IFCEXTRUDEDAREASOLID(" + profile + "," + axes + "," + up + "," + real(z) + ")");
    const std::string body = l.add("IFCSHAPEREPRESENTATION(" + context + ",'Body','SweptSolid',(" + solid + "))");
    return l.add("IFCPRODUCTDEFINITIONSHAPE($,$,(" + body + "))");
  };
  const auto at = [&](const Eigen::Vector3d& place, const Eigen::Vector3d& right) {
    const std::string point = l.add("IFCCARTESIANPOINT((" + real(place.x()) + "," + real(place.y()) + "," +
                                    real(place.z()) + "))"),
                      direction = l.add("IFCDIRECTION((" + real(right.x()) + "," + real(right.y()) + ",0.))");
    return l.add("IFCLOCALPLACEMENT(" + world + "," +
                 l.add("IFCAXIS2PLACEMENT3D(" + point + "," + up + "," + direction + ")") + ")");
  };
  const std::string bolt = box(0.04, 0.04, 0.08), panel = box(1.96, 0.05, 3);
  std::string storeys[2], held[2];
  for (int row = 0; row < 2; ++row)
    storeys[row] = l.add("IFCBUILDINGSTOREY('" + shape_guid("s" + std::to_string(row)) + "',$,'Level " +
                         std::to_string(row + 1) + "',$,$," + world + ",$,$,.ELEMENT.," + real(3.0 * row) + ")");
  const auto hold = [&](int row, const std::string& element) { held[row] += (held[row].empty() ? "" : ",") + element; };
  for (std::size_t w = 0; w < shape.wings.size(); ++w) {
    const auto& wing = shape.wings[w];
    const Eigen::Vector3d out = ifc::facing(wing.azimuth * kDegree), right = Eigen::Vector3d::UnitZ().cross(out);
    for (int row = 0; row < 2; ++row)
      for (int column = 0; column < wing.columns; ++column) {
        const std::string id = std::to_string(w) + "-" + std::to_string(row) + "-" + std::to_string(column);
        const Eigen::Vector3d place = Eigen::Vector3d(wing.start.x(), wing.start.y(), 0) + right * (1 + 2.0 * column) +
                                      Eigen::Vector3d(0, 0, 1 + 3.0 * row);
        hold(row, l.add("IFCMECHANICALFASTENER('" + shape_guid(id) + "',$,'" + id + "',$,$," + at(place, right) + "," +
                        bolt + ",$,$,$,$)"));
        if (row > 0 || column + 1 == wing.columns) continue;
        hold(row, l.add("IFCPLATE('" + shape_guid("P" + id) + "',$,'P" + id + "',$,$," +
                        at(place + right + 0.2 * out, right) + "," + panel + ",$,.CURTAIN_PANEL.)"));
      }
  }
  const auto slab = [&](const std::string& name, const Eigen::Vector3d& centre, const Eigen::Vector3d& half) {
    hold(0, l.add("IFCSLAB('" + shape_guid(name) + "',$,'" + name + "',$,$," +
                  at(centre - Eigen::Vector3d(0, 0, half.z()), Eigen::Vector3d::UnitX()) + "," +
                  box(2 * half.x(), 2 * half.y(), 2 * half.z()) + ",$,.FLOOR.)"));
  };
  if (cut != plumbline::test::no_slabs) slab("slab", shape.building, {3, 2, 0.15});
  if (cut == plumbline::test::podium) slab("podium", {4, -60, -3}, {80, 40, 3});
  for (int row = 0; row < 2; ++row)
    l.add("IFCRELCONTAINEDINSPATIALSTRUCTURE('" + shape_guid("c" + std::to_string(row)) + "',$,$,$,(" + held[row] +
          ")," + storeys[row] + ")");
  l.add("IFCRELAGGREGATES('" + shape_guid("f") + "',$,$,$," + building + ",(" + storeys[0] + "," + storeys[1] + "))");
  return l.file();
}

struct Case {
  const char* name;
  std::vector<std::string> rules;
  double sigma;  ///< of the measurement, each axis [m]
};
const std::vector<Case> kCases = {
    {"scattered", {}, 0.3 * mm},
    {"some 30 mm out", {"*: out_of_plane=4mm, vertical=4mm, horizontal=0mm"}, 0.3 * mm},
    {"the upper floor 12 mm low", {}, 0.3 * mm},
    {"hardly measured", {"*: space=5mm"}, 3 * mm},
    {"a rule that selects nothing", {"class=IfcMechanicalFastenr: vertical=1mm"}, 0.3 * mm},
};

bool is_far_out(const Case& what, std::size_t i) { return what.name == kCases[1].name && i % 3 == 0; }

Campaign campaign_of(const Shape& shape, Cut cut, const Case& what, std::uint64_t seed) {
  Normal normal(seed);
  Campaign c;
  c.bytes = ifc_of(shape, cut);
  c.design = ifc::read_design(step::File(c.bytes, "s.ifc"), {});
  Inputs inputs;
  PlatesT plates;
  std::vector<std::string> ids;
  for (const ifc::Element& element : c.design.elements) {
    if (!element.is_anchor) continue;
    const int wing = std::stoi(element.name), floor = element.name[element.name.find('-') + 1] - '0' + 1;
    const Eigen::Vector3d out = ifc::facing(shape.wings[wing].azimuth * kDegree);
    Eigen::Vector3d off = mm * Eigen::Vector3d(normal(), normal(), normal());
    if (is_far_out(what, ids.size())) off += 30 * mm * out;
    if (what.name == kCases[2].name && floor == 2) off.z() -= 12 * mm;
    ids.push_back(element.name);
    auto plate = std::make_unique<PlateT>();
    plate->nominal_rotation.setIdentity();
    plate->anchor = element.name, plate->floor = floor, plate->column = 1, plate->role = "check";
    plates.plates.push_back(std::move(plate));
    inputs.anchors.push_back({element.name, floor, 1, 1, AnchorUse::check});
    inputs.survey.ids.push_back(element.name), inputs.survey.positions.push_back(element.position + off);
    inputs.model.ids.push_back(element.name), inputs.model.positions.push_back(element.position + off);
  }
  inputs.model.covariance = test::isotropic(ids.size(), what.sigma);
  inputs.survey.covariance = test::isotropic(ids.size(), 0.5 * mm);
  std::vector<std::string> warnings;
  ElementMatchesT matches;
  for (const ifc::MatchedElement& match : ifc::match_elements(c.design, ids, {}, warnings)) {
    auto entry = std::make_unique<ElementMatchT>();
    entry->anchor = match.anchor, entry->found_by = match.found_by, entry->note = match.note;
    entry->guid = match.element ? match.element->guid : "";
    entry->position = match.reference, entry->target_offset.setZero();
    matches.matches.push_back(std::move(entry));
  }
  ToleranceTable table;
  for (const std::string& rule : what.rules) table.rules.push_back(parse_rule(rule));
  auto cases = deviation_inputs(ifc::to_artifact(c.design), matches, plates, table, 0.3);
  cases.model = inputs.model;
  c.deviation = judge_deviations(cases, {});
  c.accuracy = evaluate_accuracy(inputs, {});
  return c;
}

/// Orders lead back to the design, whichever way the wing faces. How many there are.
int expect_orders(const Campaign& c, const Shape& shape) {
  int orders = 0;
  std::map<std::string, Eigen::Vector3d> deviations;
  for (const auto& anchor : c.deviation.anchors) deviations[anchor->id] = anchor->deviation;
  for (const auto& panel : c.deviation.panels)
    for (const auto& fixing : panel->fixings) {
      const auto wing = static_cast<std::size_t>(std::stoi(fixing->anchor));
      const Eigen::Vector3d out = ifc::facing(shape.wings[wing].azimuth * kDegree);
      if (std::isnan(fixing->shim)) continue;
      EXPECT_NEAR(fixing->shim, -out.dot(deviations.at(fixing->anchor)), 1e-6) << fixing->anchor;
      ++orders;
    }
  return orders;
}

/// The three coordinates in an element of a viewpoint.
Eigen::Vector3d vector_in(const std::string& view, const std::string& element, std::size_t from = 0) {
  Eigen::Vector3d v;
  std::size_t at = view.find("<" + element + ">", from);
  for (int k = 0; k < 3; ++k) {
    const std::string open = std::string("<") + "XYZ"[k] + ">";
    at = view.find(open, at) + open.size();
    v[k] = std::stod(view.substr(at));
  }
  return v;
}

std::vector<std::string> guids_in(const std::string& view, const std::string& element) {
  std::vector<std::string> guids;
  const std::size_t begin = view.find("<" + element), end = view.find("</" + element + ">", begin);
  const std::string key = "IfcGuid=\"";
  for (std::size_t at = begin; (at = view.find(key, at)) < end;)
    at += key.size(), guids.push_back(view.substr(at, view.find('"', at) - at));
  return guids;
}

/// Whether the way from a to b goes through the element's box.
bool in_the_way(const ifc::Element& element, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const RigidTransform own = element.project_from_element.inverse();
  const Eigen::Vector3d from = own * a, way = own * b - from;
  double enters = 0, leaves = 1;
  for (int k = 0; k < 3; ++k) {
    const double first = (element.box_low[k] - from[k]) / way[k], second = (element.box_high[k] - from[k]) / way[k];
    if (std::abs(way[k]) < 1e-12) {
      if (from[k] < element.box_low[k] || from[k] > element.box_high[k]) return false;
      continue;
    }
    enters = std::max(enters, std::min(first, second)), leaves = std::min(leaves, std::max(first, second));
  }
  return enters < leaves;
}

/// The elements of the as-built file, with the solids that stand for anchors and panels as they were built.
ifc::Design as_built_of(const Campaign& c, const std::string& epoch) {
  const step::File design(c.bytes, "s.ifc");
  ifc::AsBuiltIfcOptions options;
  options.epoch = epoch;
  const std::string bytes =
      ifc::enriched(design, ifc::write_as_built(design, c.design, c.deviation, c.accuracy, options));
  ifc::AnchorRule all;
  all.all_shapes = true;
  return ifc::read_design(step::File(bytes, "as_built.ifc"), all);
}

/// The BCF read back: every camera sees its anchor or panel, past what is hidden and what is clipped, in the design or
/// in the as-built file, whose solids lie over the elements. How many there are.
int expect_seen(const Campaign& c, const ifc::Design& seen_in, const std::string& epoch) {
  ifc::BcfOptions options;
  options.project_guid = "0YvctVUKr0kugbFTf53O9L", options.epoch = epoch;
  const std::string bcf =
      ifc::write_bcf(c.deviation, worst_first(c.deviation), worst_panels_first(c.deviation), options);
  std::map<std::string, const ifc::Element*> elements;
  for (const ifc::Element& element : seen_in.elements) elements[element.guid] = &element;
  int views = 0;
  for (std::size_t at = 0; (at = bcf.find("<VisualizationInfo ", at)) != std::string::npos; ++at) {
    const std::string view = bcf.substr(at, bcf.find("</VisualizationInfo>", at) - at);
    const std::vector<std::string> coloured = guids_in(view, "Selection");
    const std::string selected = coloured.at(0);
    if (!elements.contains(selected)) continue;  // of the whole
    const ifc::Element& target = *elements.at(selected);
    const Eigen::Vector3d place =
        target.project_from_element * Eigen::Vector3d(0.5 * (target.box_low + target.box_high));
    const Eigen::Vector3d camera = vector_in(view, "CameraViewPoint"), direction = vector_in(view, "CameraDirection");
    EXPECT_GT(direction.dot((place - camera).normalized()), std::cos(25 * kDegree)) << selected << " is in the picture";
    const std::size_t planes = view.find("<ClippingPlane>");
    const Eigen::Vector3d clip = vector_in(view, "Location", planes), clipped = vector_in(view, "Direction", planes);
    EXPECT_LT(clipped.dot(place - clip), 0) << selected << " is not cut away itself";
    // From where the half-space that is shown begins.
    const double share = clipped.dot(camera - clip) / clipped.dot(camera - place);
    const Eigen::Vector3d from = share > 0 ? Eigen::Vector3d(camera + share * (place - camera)) : camera;
    const std::vector<std::string> hidden = guids_in(view, "Visibility");
    for (const ifc::Element& other : seen_in.elements) {
      if (other.is_anchor || !other.has_box) continue;
      if (std::find(coloured.begin(), coloured.end(), other.guid) != coloured.end()) continue;
      if (std::find(hidden.begin(), hidden.end(), other.guid) != hidden.end()) continue;
      EXPECT_FALSE(in_the_way(other, from, place)) << other.name << " is before " << target.name;
    }
    ++views;
  }
  return views;
}

void expect_case(const Campaign& c, const Case& what) {
  const DeviationT& d = c.deviation;
  for (std::size_t i = 0; i < d.anchors.size(); ++i) {
    const AnchorDeviationT& a = *d.anchors[i];
    if (is_far_out(what, i)) {
      EXPECT_NE(a.verdict, ToleranceVerdict::pass) << a.id << " is 30 mm out";
      if (a.facade && a.facade->confirmed) {
        EXPECT_EQ(a.verdict, ToleranceVerdict::fail) << a.id;
      }
    }
    if (what.name == kCases[3].name) {
      EXPECT_NE(a.verdict, ToleranceVerdict::pass) << a.id << ": nothing is in order at 57 %";
    }
  }
  if (what.name == kCases[2].name && d.anchors.size() >= 8) {
    // Half of the anchors hang low: the floor is named, or, of four columns, nothing else is said of it.
    EXPECT_TRUE(std::any_of(d.group_shifts.begin(), d.group_shifts.end(), [](const auto& shift) {
      return shift->significant && shift->words.find("hangs") != std::string::npos;
    })) << "the low floor is not named";
  }
  if (what.name == kCases[4].name) {
    EXPECT_EQ(d.not_judged, 1);
    EXPECT_NE(d.verdict, ToleranceVerdict::pass) << "not judged is not ready to install";
  }
}

TEST(Agreement, OfEveryShapeInEveryCaseThatWasOnceSilent) {
  const bool all = std::getenv("PLUMBLINE_LONG") != nullptr;
  std::array<int, 4> seen{};
  std::uint64_t number = 0;
  int orders = 0, views = 0;
  for (const Shape& shape : plumbline::test::shapes())
    for (std::size_t k = 0; k < kCases.size(); ++k) {
      const Cut cuts[] = {plumbline::test::everything, plumbline::test::no_slabs, plumbline::test::podium};
      for (std::size_t cut = 0; cut < std::size(cuts); ++cut) {
        ++number;
        if (!all && cut != (number / 3 + k) % std::size(cuts)) continue;  // one each, by turns
        SCOPED_TRACE(std::string(shape.name) + ", " + kCases[k].name + ", cut " + std::to_string(cut));
        const Campaign c = campaign_of(shape, cuts[cut], kCases[k], number);
        orders += expect_orders(c, shape);
        if (k == 1) {
          const std::string epoch = number % 2 ? "" : "2026-05";
          const int seen_in_design = expect_seen(c, c.design, epoch);
          EXPECT_EQ(expect_seen(c, as_built_of(c, epoch), epoch), seen_in_design);
          views += seen_in_design;
        }
        expect_case(c, kCases[k]);
        expect_agreement(c, number % 2 ? "" : "2026-05", seen);
      }
    }
  EXPECT_GT(orders, 500);
  EXPECT_GT(views, 100);
  for (const int verdict : {1, 2, 3}) EXPECT_GT(seen[verdict], 0);
}

}  // namespace test_shapes_agreement
}  // namespace plumbline::judgement

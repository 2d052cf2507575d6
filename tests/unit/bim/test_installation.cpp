// The state of an execution loop in IFC and BCF: valid against the schemas, and what it says is what the state says.
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>

#include "building/ifc/check.hpp"
#include "building/ifc/ifc_model.hpp"
#include "building/ifc/installation_bcf.hpp"
#include "building/ifc/installation_ifc.hpp"
#include "express_schema.hpp"
#include "loop_state.hpp"
#include "small_building.hpp"
#include "test_support.hpp"
#include "unzipped.hpp"

namespace plumbline::ifc {
namespace test_installation {

struct Site {
  explicit Site(const char* schema) : file(test::small_building(schema), "t.ifc"), design(read_design(file, {})) {
    auto [planned, reached] = test::loop_of(design);
    plan = std::move(planned), state = std::move(reached);
  }
  std::string written(const std::string& epoch = "") const {
    return enriched(file, write_installation(file, design, plan, state, {epoch, 0}));
  }
  step::File file;
  Design design;
  InstallationPlanT plan;
  LoopStateT state;
};

class InstallationFile : public testing::TestWithParam<const char*> {};

TEST_P(InstallationFile, IsValidAndBreaksNoRule) {
  const Site site(GetParam());
  const std::string bytes = site.written();
  EXPECT_EQ(bytes, site.written());
  const step::File file(bytes, "t.ifc");
  for (const Violation& violation : check_ifc(file))
    ADD_FAILURE() << violation.rule << " #" << violation.instance << " " << violation.words;
  const std::string path = std::string("ifc/express/") + GetParam() + ".exp";
  PLUMBLINE_REQUIRE_DATA(path);
  const test::ExpressSchema schema(test::read_file(test::data_file(path)));
  std::set<std::string> guids;
  for (const step::Instance& instance : file.instances()) {
    for (const std::string& wrong : schema.check(file, instance)) ADD_FAILURE() << wrong;
    if (schema.is_a(file.type_name(instance), "IFCROOT")) {
      EXPECT_TRUE(guids.insert(file.arguments(instance).at(0).text).second) << "GlobalId twice: #" << instance.id;
    }
  }
}

/// Name of each task and the GlobalId of the element that it is about.
std::map<std::string, std::string> tasks_of(const step::File& file) {
  std::map<std::string, std::string> found;
  for (const std::uint32_t index : file.of_type("IFCRELASSIGNSTOPROCESS")) {
    const auto relation = file.arguments(file.instances()[index]);
    found[file.arguments(*file.find(relation.at(6).id)).at(2).text] =
        file.arguments(*file.find(relation.at(4).items.at(0).id)).at(0).text;
  }
  return found;
}

TEST_P(InstallationFile, EachItemHasItsStateItsTaskAndItsPlaceInTheOrder) {
  const Site site(GetParam());
  const step::File file(site.written(), "t.ifc");
  const auto tasks = tasks_of(file);
  ASSERT_EQ(tasks.size(), site.state.items.size());
  for (const auto& item : site.state.items)
    EXPECT_EQ(tasks.at((item->kind == "bracket" ? "Set bracket " : "Hang panel ") + item->id), item->guid);
  std::size_t order = 0;
  for (const auto& panel : site.plan.panels) order += panel->brackets.size() + panel->depends_on.size();
  EXPECT_EQ(file.of_type("IFCRELSEQUENCE").size(), order);
  EXPECT_EQ(file.of_type("IFCRELNESTS").size(), 1u);
  const auto nested = file.arguments(file.instances()[file.of_type("IFCRELNESTS")[0]]);
  EXPECT_EQ(nested.at(5).items.size(), site.state.items.size());
  const Model model(file);
  std::map<std::string, std::string> status;  // by GlobalId
  for (const std::uint32_t index : file.of_type("IFCRELDEFINESBYPROPERTIES")) {
    const auto relation = file.arguments(file.instances()[index]);
    const Entity set = model.entity(relation.at(5).id);
    if (set.text("Name") != "ASB_InstallationState") continue;
    for (const std::uint64_t id : set.references("HasProperties")) {
      const auto property = file.arguments(*file.find(id));
      if (property.at(0).text == "Status")
        status[file.arguments(*file.find(relation.at(4).items.at(0).id)).at(0).text] =
            property.at(2).items.at(0).items.at(0).text;
    }
  }
  for (const auto& item : site.state.items) EXPECT_EQ(status[item->guid], label_of(item->status)) << item->id;
}

TEST_P(InstallationFile, RoundsOfDifferentNamesStandInOneFile) {
  const Site site(GetParam());
  const step::File once(site.written("1"), "t.ifc");
  const std::string twice = enriched(once, write_installation(once, site.design, site.plan, site.state, {"2", 0}));
  EXPECT_EQ(check_ifc(step::File(twice, "t.ifc")).size(), 0u);
  EXPECT_THROW(write_installation(once, site.design, site.plan, site.state, {"1", 0}), std::runtime_error);
}

INSTANTIATE_TEST_SUITE_P(Schemas, InstallationFile, testing::Values("IFC2X3", "IFC4", "IFC4X3"));

/// An anchor beside the panels has a state, and no task that would stay open for ever.
TEST(Installation, ABracketThatNoPanelHangsOnIsNoTask) {
  Site site("IFC4");
  const auto idle = std::find_if(site.state.items.begin(), site.state.items.end(),
                                 [](const auto& item) { return item->kind == "bracket"; });
  (*idle)->status = ItemStatus::planned;
  for (const auto& bracket : site.plan.brackets)
    bracket->use = bracket->id == (*idle)->id ? BracketUse::nothing : BracketUse::panel;
  const std::string bytes = site.written();
  const step::File file(bytes, "t.ifc");
  EXPECT_EQ(tasks_of(file).count("Set bracket " + (*idle)->id), 0u);
  EXPECT_EQ(tasks_of(file).size(), site.state.items.size() - 1);
  EXPECT_NE(bytes.find("(IFCLABEL('NOT_NEEDED'))"), std::string::npos);
  EXPECT_EQ(check_ifc(file).size(), 0u);
  (*idle)->status = ItemStatus::verified;  // somebody set it all the same
  EXPECT_EQ(site.written().find("(IFCLABEL('NOT_NEEDED'))"), std::string::npos);
}

TEST(Installation, WhatIsNotInTheFileIsNamed) {
  Site site("IFC4");
  site.state.items[0]->guid = "0000000000000000000000";
  const AsBuiltIfc result = write_installation(site.file, site.design, site.plan, site.state, {});
  ASSERT_EQ(result.warnings.size(), 1u);
  EXPECT_NE(result.warnings[0].find("1 items are not in the file and have no state there: anchor 0"),
            std::string::npos);
}

std::map<std::string, std::string> topics_of(const Site& site) {
  BcfOptions options;
  options.project_guid = site.design.project_guid, options.date = "2026-05-12T10:00:00";
  return test::unzipped(write_installation_bcf(site.plan, site.state, options));
}

std::string markup_about(const std::map<std::string, std::string>& files, const std::string& title) {
  for (const auto& [name, content] : files)
    if (name.ends_with("markup.bcf") && content.find("<Title>" + title) != std::string::npos) return name + content;
  return "none";
}

/// What is rejected has an open topic; once it is verified the same topic is closed.
TEST(InstallationBcf, ATopicOpensAndIsClosed) {
  Site site("IFC4");
  LoopItemT& item = *site.state.items[0];
  item.status = ItemStatus::rejected, item.why = "its plate was knocked";
  site.state.journal = {test::journal_words(item, "RELOCALISED", "REWORK", "moved by 5.0 mm"),
                        test::journal_words(item, "REWORK", "REJECTED", "moved by 5.0 mm")};
  const std::string open = markup_about(topics_of(site), "Bracket anchor 0: look at it: its plate was knocked");
  EXPECT_NE(open.find("TopicStatus=\"Open\""), std::string::npos) << open;
  EXPECT_NE(open.find("<Comment>round 1: REWORK to REJECTED: moved by 5.0 mm</Comment>"), std::string::npos) << open;
  item.status = ItemStatus::verified, item.why = "within 3.0 mm";
  site.state.journal.push_back(test::journal_words(item, "RELOCALISED", "VERIFIED", "within 3.0 mm"));
  const std::string closed = markup_about(topics_of(site), "Bracket anchor 0: mended: within 3.0 mm");
  EXPECT_NE(closed.find("TopicStatus=\"Closed\""), std::string::npos) << closed;
  EXPECT_EQ(closed.substr(0, 36), open.substr(0, 36)) << "the topic keeps its id";
  // What never was wrong has no topic.
  site.state.journal.clear();
  EXPECT_EQ(markup_about(topics_of(site), "Bracket anchor 0"), "none");
}

/// Nobody reads of it elsewhere who works with the model.
TEST(InstallationBcf, APanelThatIsToBeTakenDownHasATopic) {
  Site site("IFC4");
  LoopItemT& panel = *site.state.items.back();
  panel.status = ItemStatus::rework, panel.hangs = true, panel.why = "hangs outside its limits: p 0.002";
  const std::string title = "Panel " + panel.id + ": take it down: hangs outside its limits: p 0.002";
  EXPECT_NE(markup_about(topics_of(site), title).find("TopicStatus=\"Open\""), std::string::npos);
  for (auto& item : site.state.items) item->status = ItemStatus::verified;
  panel.gone = true, panel.guid.clear(), panel.id = "panel of before";
  EXPECT_NE(markup_about(topics_of(site), "1 item is open that no viewer can show"), "none");
}

TEST(InstallationBcf, ControlThatMovedAndWorkByHandHaveTopics) {
  Site site("IFC4");
  site.state.moved_control = {"control of floor 1"};
  site.plan.relaxations = {"bracket anchor 1 would have to move 31.0 mm up, it has 25.0: re-drill"};
  const auto files = topics_of(site);
  EXPECT_NE(markup_about(files, "control of floor 1 moved"), "none");
  EXPECT_NE(markup_about(files, "By hand: bracket anchor 1 would have to move"), "none");
}

/// What a viewer was told to be wrong it is told to be over, under the same id.
TEST(InstallationBcf, APanelThatMightNotBeHungIsClosedWhenItHangs) {
  Site site("IFC4");
  LoopItemT& item = *site.state.items.back();
  PlannedPanelT& panel = *site.plan.panels.back();
  ASSERT_EQ(item.id, panel.id);
  const std::string by_hand = "bracket anchor 1 would have to move 31.0 mm up, it has 25.0: re-drill";
  site.plan.relaxations = {by_hand};
  item.status = ItemStatus::planned, panel.gate = GateDecision::hold, panel.reason = "p 0.100; " + by_hand;
  panel.by_hand = {0};
  const auto files = topics_of(site);
  EXPECT_EQ(markup_about(files, "By hand: "), "none") << "its panel has it";
  const std::string open = markup_about(files, "Panel " + item.id + ": by hand first: p 0.100; " + by_hand);
  EXPECT_NE(open.find("TopicStatus=\"Open\""), std::string::npos) << open;
  site.state.journal.push_back(test::journal_words(item, "PLANNED", "PLANNED", "may not be hung so", "may_not_hang"));
  site.plan.relaxations.clear(), panel.by_hand.clear(), panel.gate = GateDecision::go,
                                                        item.status = ItemStatus::released;
  EXPECT_NE(markup_about(topics_of(site), "Panel " + item.id + ": may be hung").find("TopicStatus=\"Open\""),
            std::string::npos);
  item.status = ItemStatus::verified, item.why = "p 0.990", item.hangs = item.seen = true;
  const std::string closed = markup_about(topics_of(site), "Panel " + item.id + ": mended: p 0.990");
  EXPECT_NE(closed.find("TopicStatus=\"Closed\""), std::string::npos) << closed;
  EXPECT_EQ(closed.substr(0, 36), open.substr(0, 36)) << "the topic keeps its id";
}

/// Words may be another's, or of another version: what is to be done of which panel the plan says by number.
TEST(InstallationBcf, NoTopicRestsOnTheWordsOfAReason) {
  Site site("IFC4");
  LoopItemT& item = *site.state.items.back();
  PlannedPanelT& panel = *site.plan.panels.back();
  site.plan.relaxations = {"re-drill"};
  item.status = ItemStatus::planned, panel.gate = GateDecision::hold, panel.reason = "p 0.100; nothing to re-drill";
  EXPECT_NE(markup_about(topics_of(site), "By hand: re-drill"), "none") << "that panel does not say it";
  panel.by_hand = {0}, panel.reason = "p 0.100";
  EXPECT_EQ(markup_about(topics_of(site), "By hand: "), "none");
  EXPECT_NE(markup_about(topics_of(site), "Panel " + item.id + ": by hand first: p 0.100"), "none");
  // A word in the journal that begins as the program's own does is no reason.
  item.status = ItemStatus::released, panel.by_hand.clear(), panel.gate = GateDecision::go;
  site.state.journal = {test::journal_words(item, "PLANNED", "PLANNED", "may not be hung so: said somebody")};
  EXPECT_EQ(markup_about(topics_of(site), "Panel " + item.id), "none");
}

/// The same thing in another campaign, by other millimetres.
TEST(InstallationBcf, WorkByHandKeepsItsIdFromCampaignToCampaign) {
  Site site("IFC4");
  std::set<std::string> ids;
  for (const char* needed : {"31.0", "30.2"}) {
    site.plan.relaxations = {std::string("bracket anchor 1 would have to move ") + needed +
                             " mm up, it has 25.0: re-drill"};
    ids.insert(markup_about(topics_of(site), "By hand: bracket anchor 1").substr(0, 36));
  }
  EXPECT_EQ(ids.size(), 1u);
}

/// Its words name other panels beside it and other points; two brackets whose names differ by a figure were one topic.
TEST(InstallationBcf, WorkByHandAndDoubtsAreKnownByWhatTheyAreAbout) {
  Site site("IFC4");
  std::set<std::string> ids;
  for (const char* rest : {"", "; at the end of their ranges beside it: F1.3 with 25.0 mm up"}) {
    site.plan.relaxations = {"bracket F1.2 would have to move 31.0 mm up, it has 25.0: re-drill" + std::string(rest)};
    site.plan.relaxation_topics = {"bracket F1.2, up"};
    site.plan.doubts = {"the survey: known points contradict it: P1" + std::string(rest)};
    site.plan.doubt_topics = {"survey/known_points"};
    const auto files = topics_of(site);
    ids.insert(markup_about(files, "By hand: bracket F1.2").substr(0, 36));
    ids.insert(markup_about(files, "The measurement is in doubt: the survey").substr(0, 36));
  }
  EXPECT_EQ(ids.size(), 2u);
  site.plan.relaxations = {"bracket F1.2 would have to move", "bracket F1.3 would have to move"};
  site.plan.relaxation_topics = {"bracket F1.2, up", "bracket F1.3, up"};
  const auto files = topics_of(site);
  EXPECT_NE(markup_about(files, "By hand: bracket F1.2").substr(0, 36),
            markup_about(files, "By hand: bracket F1.3").substr(0, 36));
}

TEST(InstallationBcf, WhatHoldsEverythingAndWhatHasNoPlaceHaveTopics) {
  Site site("IFC4");
  site.plan.doubts = {"the image block: group tags contradicts the rest"};
  LoopItemT& item = *site.state.items[0];
  item.status = ItemStatus::rejected, item.id = "drawn by hand", item.guid.clear();
  const auto files = topics_of(site);
  EXPECT_NE(markup_about(files, "The measurement is in doubt: the image block: group tags contradicts"), "none");
  const std::string nowhere = markup_about(files, "1 item is open that no viewer can show");
  EXPECT_NE(nowhere.find("drawn by hand"), std::string::npos) << nowhere;
}

TEST(InstallationBcf, IsValidAgainstItsSchemas) {
  PLUMBLINE_REQUIRE_DATA("bcf/markup.xsd");
  if (std::system("xmllint --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "xmllint is not installed";
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("plumbline_loop_bcf_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  Site site("IFC4");
  site.state.moved_control = {"CP3"};
  for (const auto& item : site.state.items)
    site.state.journal.push_back(test::journal_words(*item, "PLANNED", "REWORK", "a & <b>"));
  int number = 0;
  for (const auto& [name, content] : topics_of(site)) {
    const std::string schema = name.ends_with(".bcf") ? "markup" : name.ends_with(".bcfv") ? "visinfo" : "";
    if (schema.empty()) continue;
    const std::filesystem::path file = folder / std::to_string(number++);
    std::ofstream(file, std::ios::binary) << content;
    const std::string command = "xmllint --noout --schema '" + test::data_file("bcf/" + schema + ".xsd").string() +
                                "' '" + file.string() + "' 2>&1";
    EXPECT_EQ(std::system(command.c_str()), 0) << name << "\n" << content;
  }
  EXPECT_GT(number, 4);
  std::filesystem::remove_all(folder);
}

}  // namespace test_installation
}  // namespace plumbline::ifc

// One identity: names of the survey to elements of the design, or the reason why not.
#include <gtest/gtest.h>

#include "building/ifc/facades.hpp"
#include "building/ifc/match_elements.hpp"

namespace plumbline::ifc {
namespace test_match_elements {

Element element_of(const std::string& name, const std::string& tag, const Eigen::Vector3d& position) {
  Element element;
  element.name = name, element.tag = tag, element.ifc_class = "IfcMechanicalFastener";
  element.guid = "guid" + std::string(18 - std::min<std::size_t>(18, tag.size()), '0') + tag;
  element.position = element.project_from_element.translation = position;
  element.is_anchor = true;
  return element;
}

/// 55 anchors on a facade along x, all named 'ANKER', as exported from Tekla: the id is in the Tag.
Design tekla() {
  Design design;
  design.file_name = "tekla.ifc";
  for (int i = 0; i < 55; ++i) {
    char tag[16];
    std::snprintf(tag, sizeof tag, "A-%04d", i);
    design.elements.push_back(element_of("ANKER", tag, {0.5 * (i % 11), 0, 3.0 * (i / 11)}));
  }
  Element slab;
  slab.name = "Slab", slab.guid = "slab", slab.position = {2, 5, 0};
  design.elements.push_back(slab);
  return design;
}

std::vector<MatchedElement> match(const Design& design, const std::vector<std::string>& ids,
                                  const MatchOptions& options = {}) {
  std::vector<std::string> warnings;
  return match_elements(design, ids, options, warnings);
}

TEST(MatchElements, FiftyFiveAnchorsOfOneNameAreFoundByTheirTags) {
  const Design design = tekla();
  std::vector<std::string> ids;
  for (int i = 0; i < 55; ++i) ids.push_back(design.elements[i].tag);
  const auto matches = match(design, ids);
  for (std::size_t i = 0; i < 55; ++i) {
    ASSERT_EQ(matches[i].element, &design.elements[i]) << matches[i].note;
    EXPECT_EQ(matches[i].found_by, "tag");
  }
}

/// macOS writes "ü" as two characters, a CAD program as one, and both print alike.
TEST(MatchElements, AccentsMayBeWrittenEitherWay) {
  Design design = tekla();
  design.elements[3].name = "T\xC3\xBCr 3", design.elements[4].name = "To\xCC\x88r 4";
  const auto matches = match(design, {"Tu\xCC\x88r 3", "T\xC3\xB6r 4"});
  EXPECT_EQ(matches[0].element, &design.elements[3]) << matches[0].note;
  EXPECT_EQ(matches[1].element, &design.elements[4]) << matches[1].note;
}

/// Of rules the last one counts: one that a later, wider one replaces everywhere was dropped without a word.
TEST(MatchElements, ARuleThatALaterWiderOneReplacesIsNotApplied) {
  const Design design = tekla();
  const auto not_applied = [&](const std::vector<std::string>& offsets) {
    MatchOptions options;
    for (const std::string& text : offsets) options.offsets.push_back(parse_offset(text));
    std::vector<std::string> warnings;
    std::vector<NotApplied> idle;
    match_elements(design, {"A-0003", "A-0004"}, options, warnings, &idle);
    return idle;
  };
  const std::string narrow = "tag=A-0003: x=1mm", wide = "*: x=2mm";
  const auto replaced = not_applied({narrow, wide});
  ASSERT_EQ(replaced.size(), 1u);
  EXPECT_EQ(replaced[0].asked, narrow);
  EXPECT_EQ(replaced[0].reason, "it holds nowhere: '" + wide +
                                    "' stands after it and selects its anchors and others; put the narrower rule last, "
                                    "or take it out");
  EXPECT_TRUE(not_applied({wide, narrow}).empty()) << "from the general to the special";
  EXPECT_EQ(not_applied({"tag=none: x=1mm"}).at(0).reason, "it selects no anchor of the plate table");
}

TEST(MatchElements, ANameThatManyBearSaysNothingAndTheNoteNamesThem) {
  const auto matches = match(tekla(), {"A-0003", "ANKER"});
  EXPECT_EQ(matches[1].element, nullptr);
  EXPECT_NE(matches[1].note.find("55 elements have this name"), std::string::npos) << matches[1].note;
  EXPECT_NE(matches[1].note.find("Tag 'A-0000'"), std::string::npos) << matches[1].note;
}

TEST(MatchElements, TheMappingTableLeadsShortNamesOfTheInstrumentToGlobalIds) {
  const Design design = tekla();
  MatchOptions options;
  options.mapping = {{"P0000007", design.elements[7].guid, 2},
                     {"PUNKT00000000008", design.elements[8].guid, 3},
                     {"P0000009", "nobody", 4}};
  const auto matches = match(design, {"P0000007", "PUNKT00000000008", "P0000009"}, options);
  EXPECT_EQ(matches[0].element, &design.elements[7]);
  EXPECT_EQ(matches[1].element, &design.elements[8]);
  EXPECT_EQ(matches[0].found_by, "mapping");
  EXPECT_NE(matches[2].note.find("line 4 of the mapping table leads to 'nobody'"), std::string::npos);
}

TEST(MatchElements, NearMissesAreNamedAndNotTaken) {
  Design design = tekla();
  design.elements[0].name = "FACADE-ANCHOR-EAST-0001";
  const auto matches = match(design, {"A-0002", "a.12", "EAST-0001", "AST-0001"});
  EXPECT_EQ(matches[1].element, nullptr);
  EXPECT_NE(matches[1].note.find("but for case, separators or leading zeros it is"), std::string::npos)
      << matches[1].note;
  EXPECT_NE(matches[1].note.find("A-0012"), std::string::npos);
  EXPECT_NE(matches[3].note.find("the 8 characters of a GSI file, cut off from"), std::string::npos) << matches[3].note;
}

TEST(MatchElements, TwoAnchorsOfOneElementAndKeysThatDisagreeAreRefused) {
  Design design = tekla();
  auto matches = match(design, {"A-0001", design.elements[1].guid, "A-0002"});
  EXPECT_EQ(matches[0].element, nullptr);
  EXPECT_EQ(matches[1].element, nullptr);
  EXPECT_NE(matches[0].note.find("are both"), std::string::npos);
  EXPECT_NE(matches[2].element, nullptr);
  design.elements[4].name = "A-0003";
  matches = match(design, {"A-0003", "A-0002"});
  EXPECT_EQ(matches[0].element, nullptr);
  EXPECT_NE(matches[0].note.find("say in a mapping table which is meant"), std::string::npos) << matches[0].note;
}

TEST(MatchElements, NothingAtAllIsAnErrorThatNamesTheFirst) {
  try {
    match(tekla(), {"X1", "X2"});
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("none of the 2 anchors"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("'X1': no element has this guid, tag or name"), std::string::npos)
        << error.what();
  }
}

TEST(MatchElements, PropertiesIdentifyToo) {
  Design design = tekla();
  design.elements[5].properties = {{"Tekla", "Mark", "M5", 0}};
  MatchOptions options;
  options.by = {"Tekla.Mark", "tag"};
  const auto matches = match(design, {"M5"}, options);
  EXPECT_EQ(matches[0].element, &design.elements[5]);
  EXPECT_EQ(matches[0].found_by, "Tekla.Mark");
}

TEST(MatchElements, OffsetsAndReferencePointsPerClass) {
  Design design = tekla();
  Element& anchor = design.elements[3];
  anchor.has_box = true, anchor.box_low = {-0.01, -0.05, -0.01}, anchor.box_high = {0.01, 0.15, 0.01};
  anchor.project_from_element.rotation = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX());
  MatchOptions options;
  options.offsets = {parse_offset("class=IfcMechanicalFastener: out=40mm, up=-5mm"),
                     parse_offset("tag=A-0003: x=1mm, y=0.002m")};
  EXPECT_THROW(match(design, {"A-0002"}, options), std::runtime_error) << "nothing says where outward is";
  assign_facades(design, {parse_facade_rule("*: azimuth=180deg")});
  auto matches = match(design, {"A-0002", "A-0003"}, options);
  EXPECT_NEAR((matches[0].target_offset - Eigen::Vector3d(0, -0.04, -0.005)).norm(), 0, 1e-12);  // outward is -y
  EXPECT_NEAR((matches[1].target_offset - Eigen::Vector3d(0.001, 0, 0.002)).norm(), 0, 1e-12);   // its y axis points up
  options.references = {parse_reference("tag=A-0003: head")};
  matches = match(design, {"A-0003"}, options);
  // The box reaches from -5 cm to 15 cm in height and 1 cm to both sides: its head towards -y is 1 cm out.
  EXPECT_NEAR((matches[0].reference - (anchor.position + Eigen::Vector3d(0, -0.01, 0.05))).norm(), 0, 1e-12);
  EXPECT_EQ(matches[0].reference_rule, "head");
  EXPECT_THROW(parse_offset("class=X: out=40"), std::runtime_error);
  EXPECT_THROW(parse_offset("class=X out=40mm"), std::runtime_error);
  EXPECT_THROW(parse_reference("class=X: tail"), std::runtime_error);
}

TEST(SelectionLanguage, SelectsAndRefusesInWords) {
  const std::vector<Property> properties = {{"Pset_X", "Kind", "anchor", 0}};
  const ElementFacts facts{"IfcPlate", "g", "F01-P3", "T", "", "Panel type", "Level 2", &properties};
  for (const char* yes :
       {"*", "class=IfcPlate", "class=IfcPlate & storey=Level 2", "name~^F01-", "Pset_X.Kind=anchor", "type~Panel"})
    EXPECT_TRUE(Selection(yes).matches(facts)) << yes;
  for (const char* no :
       {"class=IfcWall", "class=IfcPlate & storey=Level 1", "name~^F02", "Pset_X.Kind=panel", "Pset_Y.Kind=anchor"})
    EXPECT_FALSE(Selection(no).matches(facts)) << no;
  for (const char* wrong : {"", "IfcPlate", "colour=red", "name~(", "=x"})
    EXPECT_THROW(Selection{wrong}, std::runtime_error) << wrong;
}

}  // namespace test_match_elements
}  // namespace plumbline::ifc

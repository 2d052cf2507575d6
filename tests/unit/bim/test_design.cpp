// The design read from a building that can be worked out by hand, its variants, and damage.
#include <algorithm>
#include <cmath>

#include "building/ifc/design.hpp"
#include "design_reading.hpp"
#include "design_variants.hpp"
#include "small_building.hpp"
#include "test_support.hpp"

namespace plumbline::ifc {
namespace test_design {

using test::small_building;
using test::with_anchor;

std::string message_of(const std::string& bytes, const AnchorRule& rule = {}) {
  try {
    read(bytes, rule);
  } catch (const step::Error& error) {
    return error.what();
  }
  return "no error";
}

void expect_point(const Eigen::Vector3d& found, double x, double y, double z) {
  EXPECT_NEAR((found - Eigen::Vector3d(x, y, z)).norm(), 0, 1e-9) << found.transpose();
}

class SmallBuilding : public testing::TestWithParam<const char*> {};

TEST_P(SmallBuilding, IsReadAsWorkedOutByHand) {
  const Design design = read(small_building(GetParam()));
  EXPECT_EQ(design.project_guid, "0YvctVUKr0kugbFTf53O9L");
  EXPECT_EQ(design.length_unit, 0.001);
  ASSERT_EQ(design.storeys.size(), 2u);
  EXPECT_EQ(design.storeys[0].name, "Level 1");  // by elevation, not by place in the file
  EXPECT_EQ(design.storeys[1].elevation, 3.5);
  EXPECT_NEAR(design.storeys[1].placement_height, 3.6, 1e-12);
  ASSERT_EQ(design.elements.size(), 6u);
  // The site turns x to y and y to −x, and moves by (10, 20, 0.1).
  expect_point(named(design, "F1-C1").position, 10, 22, 0.6);
  expect_point(named(design, "F2-C2").position, 10, 24, 4.1);
  EXPECT_EQ(named(design, "F2-C2").ifc_class, "IfcMechanicalFastener");
  EXPECT_EQ(named(design, "F2-C2").storey, "Level 2");
  EXPECT_EQ(named(design, "F2-C2").storey_guid, "3YvctVUKr0kugbFTf53O9L");
  EXPECT_EQ(named(design, "F2-C2").rule, ReferencePointRule::placement);
  EXPECT_TRUE(named(design, "F2-C2").is_anchor);
  // The plate's origin lies on its lower edge, hence within its box; the wall's lies 1.9 m from its only part.
  EXPECT_EQ(named(design, "Panel 1").storey, "Level 2");
  EXPECT_EQ(named(design, "Panel 1").parent_guid, named(design, "Facade").guid);
  EXPECT_TRUE(named(design, "Panel 1").is_panel);
  expect_point(named(design, "Panel 1").position, 10.1, 23, 3.6);
  EXPECT_EQ(named(design, "Facade").rule, ReferencePointRule::parts_centre);
  expect_point(named(design, "Facade").position, 10.1, 23, 4.1);
  EXPECT_TRUE(design.warnings.empty()) << design.warnings[0];
}

INSTANTIATE_TEST_SUITE_P(Schemas, SmallBuilding, testing::Values("IFC2X3", "IFC4", "IFC4X3_ADD2"));

TEST(ReferencePoint, ComesFromTheShapeIfThePlacementIsElsewhere) {
  // An extrusion of 100 mm along x whose profile is centred 5 m up: axis middle at (0.05, 0, 5) of a storey at (10, 20,
  // 0.1).
  const Design extrusion =
      read(with_anchor("#520=IFCEXTRUDEDAREASOLID(#50,#521,#24,100.);#521=IFCAXIS2PLACEMENT3D(#522,#523,#25);#522="
                       "IFCCARTESIANPOINT((0.,0.,5000.));"
                       "#523=IFCDIRECTION((1.,0.,0.));"));
  EXPECT_EQ(named(extrusion, "Odd").rule, ReferencePointRule::axis_middle);
  expect_point(named(extrusion, "Odd").position, 10, 20.05, 5.1);
  // A mesh says nothing of axes: the centre of its box, (1.5, 1, 2).
  const Design mesh =
      read(with_anchor("#520=IFCTRIANGULATEDFACESET(#521,$,.T.,((1,2,3)),$);#521=IFCCARTESIANPOINTLIST3D(((1000.,0.,"
                       "1000.),(2000.,2000.,1000.),(2000.,0.,3000.)));"));
  EXPECT_EQ(named(mesh, "Odd").rule, ReferencePointRule::bounding_box_centre);
  expect_point(named(mesh, "Odd").position, 9, 21.5, 2.1);
  // Up to 5 mm beyond the shape the placement still counts.
  const auto offset = [](const char* z) {
    return named(read(with_anchor("#520=IFCEXTRUDEDAREASOLID(#50,#521,#24,100.);#521=IFCAXIS2PLACEMENT3D(#522,$,$);"
                                  "#522=IFCCARTESIANPOINT((0.,0.," +
                                  std::string(z) + "));")),
                 "Odd")
        .rule;
  };
  EXPECT_EQ(offset("4.9"), ReferencePointRule::placement);
  EXPECT_EQ(offset("5.1"), ReferencePointRule::axis_middle);
}

TEST(ReferencePoint, MappedItemsCarryTheirOperator) {
  // Shown twice as large, turned by 90° about z, moved by (0, 0, 4000); the mapping origin takes 1000 off x first.
  const Design design = read(with_anchor(
      "#520=IFCMAPPEDITEM(#530,#531);#530=IFCREPRESENTATIONMAP(#532,#534);#532=IFCAXIS2PLACEMENT3D(#533,$,$);"
      "#533=IFCCARTESIANPOINT((1000.,0.,0.));#534=IFCSHAPEREPRESENTATION(#22,'Body','CSG',(#535));#535=IFCSPHERE(#536,"
      "100.);"
      "#536=IFCAXIS2PLACEMENT3D(#537,$,$);#537=IFCCARTESIANPOINT((1500.,0.,0.));"
      "#531=IFCCARTESIANTRANSFORMATIONOPERATOR3D(#25,$,#538,2.,$);#538=IFCCARTESIANPOINT((0.,0.,4000.));"));
  // (500, 0, 0) · 2 turned = (0, 1000, 4000) in the storey = (−1, 0, 4) in the site's axes
  expect_point(named(design, "Odd").position, 9, 20, 4.1);
}

TEST(ReferencePoint, ManyBoltsInOneFastenerAreTold) {
  const Design design =
      read(with_anchor("#520=IFCSPHERE(#522,10.);#521=IFCSPHERE(#523,10.);#522=IFCAXIS2PLACEMENT3D(#20,$,$);#523="
                       "IFCAXIS2PLACEMENT3D(#524,$,$);"
                       "#524=IFCCARTESIANPOINT((300.,0.,0.));",
                       "#520,#521"));
  ASSERT_EQ(named(design, "Odd").item_positions.size(), 2u);
  expect_point(named(design, "Odd").item_positions[1], 10, 20.3, 0.1);
}

TEST(ReferencePoint, UnreadGeometryKeepsThePlacementAndWarns) {
  const Design design = read(with_anchor("#520=IFCSECTIONEDSPINE($,$,$);"));
  expect_point(named(design, "Odd").position, 10, 20, 0.1);
  ASSERT_EQ(design.warnings.size(), 1u);
  EXPECT_NE(design.warnings[0].find("IFCSECTIONEDSPINE"), std::string::npos);
}

TEST(ReferencePoint, CurvesReachAsFarAsTheyShould) {
  const auto box = [](const std::string& curve) {
    const Design design = read(
        with_anchor("#520=IFCEXTRUDEDAREASOLID(#540,$,#24,1.);#540=IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,#541);"
                    "#550=IFCCIRCLE(#551,1000.);#551=IFCAXIS2PLACEMENT2D(#552,$);#552=IFCCARTESIANPOINT((0.,0.));" +
                    curve));
    const Element& e = named(design, "Odd");
    return Eigen::Vector4d(e.box_low.x(), e.box_low.y(), e.box_high.x(), e.box_high.y());
  };
  const double s = std::sqrt(0.5);
  EXPECT_NEAR((box("#541=IFCCIRCLE(#551,1000.);") - Eigen::Vector4d(-1, -1, 1, 1)).norm(), 0, 1e-9);
  // once round with the rounding of an exporter (743--segfault-on-geometry.ifc of IfcOpenShell's files)
  EXPECT_NEAR((box("#541=IFCTRIMMEDCURVE(#550,(IFCPARAMETERVALUE(0.)),(IFCPARAMETERVALUE(6.28318977355957)),.T.,"
                   ".PARAMETER.);") -
               Eigen::Vector4d(-1, -1, 1, 1))
                  .norm(),
              0, 1e-9);
  // from −45° to 45°, by angles in radians, and the other way round by points
  EXPECT_NEAR((box("#541=IFCTRIMMEDCURVE(#550,(IFCPARAMETERVALUE(-0.785398163397448)),(IFCPARAMETERVALUE(0."
                   "785398163397448)),.T.,.PARAMETER.);") -
               Eigen::Vector4d(s, -s, 1, s))
                  .norm(),
              0, 1e-9);
  EXPECT_NEAR((box("#541=IFCTRIMMEDCURVE(#550,(#560),(#561),.F.,.CARTESIAN.);#560=IFCCARTESIANPOINT((0.,1000.));#561="
                   "IFCCARTESIANPOINT((0.,-1000.));") -
               Eigen::Vector4d(0, -1, 1, 1))
                  .norm(),
              0, 1e-9);
  EXPECT_NEAR((box("#541=IFCINDEXEDPOLYCURVE(#560,(IFCARCINDEX((1,2,3)),IFCLINEINDEX((3,1))),.F.);"
                   "#560=IFCCARTESIANPOINTLIST2D(((0.,-1000.),(1000.,0.),(0.,1000.)));") -
               Eigen::Vector4d(0, -1, 1, 1))
                  .norm(),
              0, 1e-9);
}

/// Every kind of profile, each with another width than height, at (100, 200) mm where it has a position.
TEST(ReferencePoint, ProfilesReachAsFarAsTheyShould) {
  const auto box = [](const std::string& profile) {
    const Design design = read(with_anchor(
        "#520=IFCEXTRUDEDAREASOLID(#540,$,#24,1.);#540=" + profile +
        ";#550=IFCAXIS2PLACEMENT2D(#551,$);#551=IFCCARTESIANPOINT((100.,200.));#552=IFCAXIS2PLACEMENT2D(#553,$);"
        "#553=IFCCARTESIANPOINT((0.,0.));#554=IFCCARTESIANPOINT((-300.,0.));#555=IFCCARTESIANPOINT((500.,40.));"
        "#556=IFCDIRECTION((0.,1.));#557=IFCVECTOR(#556,10.);#558=IFCLINE(#555,#557);"));
    EXPECT_TRUE(design.warnings.empty()) << profile << ": " << design.warnings[0];
    const Element& e = named(design, "Odd");
    return Eigen::Vector4d(1e3 * e.box_low.x(), 1e3 * e.box_low.y(), 1e3 * e.box_high.x(), 1e3 * e.box_high.y());
  };
  const std::vector<std::pair<std::string, Eigen::Vector4d>> profiles = {
      {"IFCRECTANGLEPROFILEDEF(.AREA.,$,#550,60.,80.)", {70, 160, 130, 240}},
      {"IFCRECTANGLEHOLLOWPROFILEDEF(.AREA.,$,$,60.,80.,5.,$,$)", {-30, -40, 30, 40}},
      {"IFCCIRCLEPROFILEDEF(.AREA.,$,#550,50.)", {50, 150, 150, 250}},
      {"IFCELLIPSEPROFILEDEF(.AREA.,$,$,60.,20.)", {-60, -20, 60, 20}},
      {"IFCISHAPEPROFILEDEF(.AREA.,$,$,60.,80.,5.,6.,$,$,$)", {-30, -40, 30, 40}},
      {"IFCTSHAPEPROFILEDEF(.AREA.,$,$,80.,60.,5.,6.,$,$,$,$,$)", {-30, -40, 30, 40}},
      {"IFCUSHAPEPROFILEDEF(.AREA.,$,$,80.,60.,5.,6.,$,$,$)", {-30, -40, 30, 40}},
      {"IFCCSHAPEPROFILEDEF(.AREA.,$,$,80.,60.,5.,6.,$)", {-30, -40, 30, 40}},
      {"IFCLSHAPEPROFILEDEF(.AREA.,$,$,80.,60.,5.,$,$,$)", {-30, -40, 30, 40}},
      {"IFCLSHAPEPROFILEDEF(.AREA.,$,$,80.,$,5.,$,$,$)", {-40, -40, 40, 40}},
      // the flanges of a Z share its web
      {"IFCZSHAPEPROFILEDEF(.AREA.,$,$,80.,60.,10.,6.,$,$)", {-55, -40, 55, 40}},
      {"IFCTRAPEZIUMPROFILEDEF(.AREA.,$,$,100.,60.,80.,70.)", {-50, -40, 80, 40}},
      {"IFCTRAPEZIUMPROFILEDEF(.AREA.,$,$,100.,60.,80.,-30.)", {-80, -40, 50, 40}},
      {"IFCCOMPOSITEPROFILEDEF(.AREA.,$,(#541,#542),$);#541=IFCCIRCLEPROFILEDEF(.AREA.,$,#550,50.);"
       "#542=IFCRECTANGLEPROFILEDEF(.AREA.,$,$,60.,80.)",
       {-30, -40, 150, 250}},
      {"IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,#541);#541=IFCELLIPSE(#550,60.,20.)", {40, 180, 160, 220}},
      // a quarter of an ellipse from its left to its bottom, and a line of 3 to 8 times 10 mm
      {"IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,#541);#541=IFCTRIMMEDCURVE(#542,(#554),(IFCPARAMETERVALUE("
       "4.71238898038469)),.T.,.PARAMETER.);#542=IFCELLIPSE(#552,300.,20.)",
       {-300, -20, 0, 0}},
      {"IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,#541);#541=IFCTRIMMEDCURVE(#558,(IFCPARAMETERVALUE(3.)),"
       "(IFCPARAMETERVALUE(8.)),.T.,.PARAMETER.)",
       {500, 70, 500, 120}},
      {"IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,#541);#541=IFCTRIMMEDCURVE(#558,(#555),(IFCPARAMETERVALUE(8.)),.T.,"
       ".PARAMETER.)",
       {500, 40, 500, 120}},
      {"IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,#541);#541=IFCCOMPOSITECURVE((#542,#543),.F.);"
       "#542=IFCCOMPOSITECURVESEGMENT(.CONTINUOUS.,.T.,#544);#543=IFCCOMPOSITECURVESEGMENT(.CONTINUOUS.,.T.,#545);"
       "#544=IFCPOLYLINE((#551,#554));#545=IFCCIRCLE(#552,50.)",
       {-300, -50, 100, 200}},
      {"IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,#541);#541=IFCINDEXEDPOLYCURVE(#542,$,.F.);"
       "#542=IFCCARTESIANPOINTLIST2D(((0.,-10.),(70.,0.),(0.,30.)))",
       {0, -10, 70, 30}},
      // the arc from the left over the bottom to the right
      {"IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,#541);#541=IFCINDEXEDPOLYCURVE(#542,(IFCARCINDEX((1,2,3))),.F.);"
       "#542=IFCCARTESIANPOINTLIST2D(((-50.,0.),(-30.,-40.),(50.,0.)))",
       {-50, -50, 50, 0}}};
  for (const auto& [profile, expected] : profiles)
    EXPECT_NEAR((box(profile) - expected).norm(), 0, 1e-6) << profile << ": " << box(profile).transpose();
}

TEST(Placement, GridIntersectionsWithOffsets) {
  const Design design = read(
      small_building("IFC4",
                     "#500=IFCGRID('0dvctVUKr0kugbFTf53O9L',#5,'G',$,$,#28,$,(#501),(#502),$,$);#501=IFCGRIDAXIS('A',#"
                     "503,.T.);#502=IFCGRIDAXIS('1',#504,.T.);"
                     "#503=IFCPOLYLINE((#505,#506));#504=IFCPOLYLINE((#507,#508));#505=IFCCARTESIANPOINT((0.,2000.));#"
                     "506=IFCCARTESIANPOINT((9000.,2000.));"
                     "#507=IFCCARTESIANPOINT((4000.,0.));#508=IFCCARTESIANPOINT((4000.,9000.));#509="
                     "IFCVIRTUALGRIDINTERSECTION((#501,#502),(100.,0.,50.));"
                     "#510=IFCGRIDPLACEMENT(#509,$);#511=IFCCOLUMN('1dvctVUKr0kugbFTf53O9L',#5,'K',$,$,#510,$,$,$);"));
  // (4, 2.1, 0.05) in the grid, whose placement is the site's
  expect_point(named(design, "K").position, 10 - 2.1, 24, 0.15);
}

/// Axes had no ends: what lies in one wing was named by those of another one, 60 m behind and 0.3 m to the side.
TEST(Grid, AxesOfAnotherWingAreNotThoseOfThisOne) {
  const auto axis = [](const char* tag, const char* family, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    return GridAxis{tag, family, from, (to - from).normalized(), 0, (to - from).norm()};
  };
  std::vector<GridAxis> grid;
  for (int wing = 0; wing < 2; ++wing) {
    const double y = 60.0 * wing, beside = 0.3 * wing;
    grid.push_back(axis(wing ? "C" : "A", "u", {0, y, 0}, {20, y, 0}));
    for (int i = 1; i <= 4; ++i)
      grid.push_back(
          axis(std::to_string(10 * wing + i).c_str(), "v", {5.0 * i + beside, y - 1, 0}, {5.0 * i + beside, y + 9, 0}));
  }
  const Eigen::Vector3d place(10.25, -0.4, 3);
  EXPECT_EQ(grid_place(grid, place), "A/2");
  EXPECT_EQ(axis_across(grid, place, {0, -1, 0})->tag, "2");
  EXPECT_EQ(grid_place(grid, {10.25, 59, 3}), "C/12");
  EXPECT_NEAR(distance_to(grid[0], {10, -2, 0}), 2, 1e-12);
  EXPECT_NEAR(distance_to(grid[0], {24, -2, 0}), 2, 1e-12) << "a facade stands out beyond the drawn axes";
  EXPECT_NEAR(distance_to(grid[0], {28, -4, 0}), 5, 1e-12);
}

/// A site that is turned by 90°: lengthwise axes of the grid run along y of the project.
TEST(Grid, AxesAreReadWhereTheyLieAndNameAPlace) {
  const auto line = [](int id, const std::string& tag, const std::string& from, const std::string& to) {
    const std::string a = "#" + std::to_string(id);
    return a + "0=IFCCARTESIANPOINT((" + from + "));" + a + "1=IFCCARTESIANPOINT((" + to + "));" + a +
           "2=IFCPOLYLINE((" + a + "0," + a + "1));" + a + "3=IFCGRIDAXIS(" + tag + "," + a + "2,.T.);";
  };
  const std::string axes = line(50, "'A'", "0.,0.", "9000.,0.") + line(51, "'B'", "0.,4000.", "9000.,4000.") +
                           line(52, "'1'", "2000.,-1000.", "2000.,9000.") +
                           line(53, "'2'", "4000.,-1000.", "4000.,9000.") + line(54, "$", "0.,0.", "1.,1.");
  const auto grid = [](int id, const std::string& guid, const std::string& placement, const std::string& v) {
    return "#" + std::to_string(id) + "=IFCGRID('" + guid + "',#5,$,$,$," + placement + ",$,(#503,#513),(" + v +
           "),$,$);";
  };
  const Design design =
      read(small_building("IFC4", axes + grid(590, "0gvctVUKr0kugbFTf53O9L", "#35", "#523,#533,#543") +
                                      grid(591, "0hvctVUKr0kugbFTf53O9L", "#34", "#523,#533")));  // the same above
  std::string tags;
  for (const GridAxis& axis : design.grid) tags += axis.family + axis.tag + " ";
  EXPECT_EQ(tags, "uA uB v1 v2 ");
  const Element& anchor = named(design, "F1-C2");  // (4000, 0, 500) in the storey
  EXPECT_NEAR(distance_to(design.grid[0], anchor.position), 0, 1e-9);
  EXPECT_NEAR(distance_to(design.grid[1], anchor.position), 4, 1e-9);
  EXPECT_NEAR(distance_to(design.grid[3], anchor.position), 0, 1e-9);
  EXPECT_EQ(grid_place(design.grid, anchor.position), "A/2");
  // A facade along A looks along −y of the site, which is x of the project: 1 and 2 cross it.
  const Eigen::Vector3d out = design.grid[2].direction;
  ASSERT_TRUE(axis_across(design.grid, anchor.position, out));
  EXPECT_EQ(axis_across(design.grid, anchor.position, out)->tag, "2");
  EXPECT_EQ(axis_across(design.grid, anchor.position, design.grid[0].direction)->tag, "A");
  EXPECT_EQ(axis_across(design.grid, anchor.position, Eigen::Vector3d::UnitZ()), nullptr) << "a soffit";
  bool told = false;
  for (const std::string& warning : design.warnings)
    told = told || warning.find("1 axes or grids (IfcGrid) were left out") != std::string::npos;
  EXPECT_TRUE(told) << "the one without a tag";
}

TEST(Units, FollowTheAssignment) {
  const Design foot = read(small_building(
      "IFC4", "#500=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);",
      "#11=IFCCONVERSIONBASEDUNIT(#14,.LENGTHUNIT.,'FOOT',#17);#17=IFCMEASUREWITHUNIT(IFCRATIOMEASURE(0.3048),#500);"));
  EXPECT_DOUBLE_EQ(foot.length_unit, 0.3048);
  EXPECT_EQ(foot.length_unit_name, "FOOT");
  EXPECT_NEAR(named(foot, "F1-C1").position.y(), 22000 * 0.3048, 1e-6);
  EXPECT_NE(message_of(small_building("IFC4", "", "#11=IFCCONVERSIONBASEDUNIT(#14,.LENGTHUNIT.,'X',#15);"))
                .find("leads to an SI unit"),
            std::string::npos);
  // Areas that call themselves lengths are passed over; two lengths that differ are not chosen from.
  const auto with_third = [](const std::string& unit) {
    std::string bytes = small_building("IFC4", "#17=" + unit);
    return bytes.replace(bytes.find("((#11,#12))"), 11, "((#11,#12,#17))");
  };
  const Design named_wrongly = read(with_third("IFCSIUNIT(*,.LENGTHUNIT.,$,.SQUARE_METRE.);"));
  EXPECT_DOUBLE_EQ(named_wrongly.length_unit, 0.001);
  ASSERT_FALSE(named_wrongly.warnings.empty());
  EXPECT_NE(named_wrongly.warnings[0].find("#17 calls itself a unit of length and is SQUARE_METRE"), std::string::npos);
  const Design feet = read(with_third(
      "IFCCONVERSIONBASEDUNIT(#14,.LENGTHUNIT.,'ft2',#18);#18=IFCMEASUREWITHUNIT(IFCRATIOMEASURE(0.0929),#19);"
      "#19=IFCSIUNIT(*,.AREAUNIT.,$,.SQUARE_METRE.);"));
  EXPECT_DOUBLE_EQ(feet.length_unit, 0.001);
  ASSERT_FALSE(feet.warnings.empty());
  EXPECT_NE(feet.warnings[0].find("#17 calls itself a unit of length and is SQUARE_METRE"), std::string::npos);
  EXPECT_NE(message_of(small_building("IFC4", "", "#11=IFCSIUNIT(*,.LENGTHUNIT.,$,.SQUARE_METRE.);"))
                .find("#11 is a unit of SQUARE_METRE, expected METRE"),
            std::string::npos);
  EXPECT_DOUBLE_EQ(read(small_building("IFC4", "", "#11=IFCSIUNIT(,.LENGTHUNIT.,.MILLI.,.METRE.);")).length_unit,
                   0.001);
  EXPECT_NE(message_of(with_third("IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);")).find("expected one length unit"),
            std::string::npos);
}

TEST(Anchors, AreFoundByClassPatternNameAndGuid) {
  const auto anchors = [](const AnchorRule& rule) {
    std::string found;
    for (const Element& element : read(small_building("IFC4"), rule).elements)
      found += element.is_anchor ? element.name + " " : "";
    return found;
  };
  EXPECT_EQ(anchors({}), "F1-C1 F1-C2 F2-C1 F2-C2 ");
  EXPECT_EQ(anchors({{}, "", {}, {}}), "");
  EXPECT_EQ(anchors({{"IfcPlate"}, "", {}, {}}), "Panel 1 ");
  EXPECT_EQ(anchors({{}, "^F[0-9]+-C2$", {}, {}}), "F1-C2 F2-C2 ");
  EXPECT_EQ(anchors({{}, "", {"3avctVUKr0kugbFTf53O9L"}, {"F1-C1", "T110"}}), "F1-C1 F1-C2 Panel 1 ");
  EXPECT_NE(message_of(small_building("IFC4"), {{}, "(", {}, {}}).find("no regular expression"), std::string::npos);
}

TEST(Anchors, TheFileMayTieThemToAPanel) {
  const Design design = read(small_building("IFC4",
                                            "#500=IFCRELCONNECTSWITHREALIZINGELEMENTS('0dvctVUKr0kugbFTf53O9L',#5,$,$,$"
                                            ",#220,#228,(#123,#228),'FacadeFixing');"));
  EXPECT_EQ(named(design, "Panel 1").anchor_guids, std::vector<std::string>{"21vctVUKr0kugbFTf53O9L"});
}

TEST(Georeference, IsHandedOnAndDoubtfulScalesAreNamed) {
  const std::string crs = "#500=IFCPROJECTEDCRS('EPSG:25832',$,$,$,$,$,#501);#501=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);";
  const Design good =
      read(small_building("IFC4", crs + "#502=IFCMAPCONVERSION(#22,#500,691000.5,5335000.25,520.,0.,1.,0.001);"));
  ASSERT_TRUE(good.map_conversion);
  EXPECT_EQ(good.map_conversion->eastings, 691000.5);
  EXPECT_EQ(good.map_conversion->crs_name, "EPSG:25832");
  EXPECT_TRUE(good.warnings.empty());
  const Design doubtful =
      read(small_building("IFC4", crs + "#502=IFCMAPCONVERSION(#22,#500,691000.5,5335000.25,520.,$,$,1000.);"));
  ASSERT_EQ(doubtful.warnings.size(), 1u);
  EXPECT_NE(doubtful.warnings[0].find("scale 1000"), std::string::npos);
  const Design old =
      read(small_building("IFC2X3",
                          "#500=IFCPROPERTYSET('0evctVUKr0kugbFTf53O9L',#5,'ePset_MapConversion',$,(#501,#502));"
                          "#501=IFCPROPERTYSINGLEVALUE('Eastings',$,IFCLENGTHMEASURE(5.),$);#502="
                          "IFCPROPERTYSINGLEVALUE('Scale',$,IFCREAL(0.001),$);"));
  ASSERT_TRUE(old.map_conversion);
  EXPECT_EQ(old.map_conversion->eastings, 5);
}

TEST(Georeference, WhatIsNoPlaneOfAMapIsNotTakenForOne) {
  const auto with = [](const std::string& conversion) {
    return read(small_building("IFC4X3",
                               "#500=IFCPROJECTEDCRS('EPSG:25832',$,$,$,$,$,$);"
                               "#501=IFCGEOGRAPHICCRS('EPSG:4258',$,$,$,$,$);" +
                                   conversion));
  };
  // As in buildingSMART's sample of a rigid operation: 14.09 degrees east are not 14.09 m.
  for (const char* degrees :
       {"#502=IFCRIGIDOPERATION(#22,#501,IFCPLANEANGLEMEASURE(14.0902217),IFCPLANEANGLEMEASURE(46.3623297),475.);",
        "#502=IFCRIGIDOPERATION(#22,#500,IFCPLANEANGLEMEASURE(14.0902217),IFCPLANEANGLEMEASURE(46.3623297),475.);",
        "#502=IFCMAPCONVERSION(#22,#501,14.0902217,46.3623297,475.,$,$,1.);"}) {
    const Design design = with(degrees);
    EXPECT_FALSE(design.map_conversion) << degrees;
    ASSERT_EQ(design.warnings.size(), 1u) << degrees;
    EXPECT_NE(design.warnings[0].find("#502 gives longitude and latitude"), std::string::npos);
  }
  const Design metres = with("#502=IFCRIGIDOPERATION(#22,#500,IFCLENGTHMEASURE(35010.),IFCLENGTHMEASURE(1560.),$);");
  ASSERT_TRUE(metres.map_conversion);
  EXPECT_EQ(metres.map_conversion->eastings, 35010);
  // Without MapUnit the map counts in the project's unit, here millimetres, or in metres as many write it: either
  // scale.
  for (const char* scale : {"1.", "0.9996", "0.001"})
    EXPECT_TRUE(
        with(std::string("#502=IFCMAPCONVERSION(#22,#500,691000.,5335000.,520.,$,$,") + scale + ");").warnings.empty())
        << scale;
  EXPECT_EQ(with("#502=IFCMAPCONVERSION(#22,#500,691000.,5335000.,520.,$,$,1000.);").warnings.size(), 1u);
  // A factor of the plan counts like a scale; heights or one axis stretched alone are more than a map does.
  const std::string scaled = "#502=IFCMAPCONVERSIONSCALED(#22,#500,691000.,5335000.,520.,$,$,0.001,";
  ASSERT_TRUE(with(scaled + "0.9996,0.9996,1.);").map_conversion);
  EXPECT_DOUBLE_EQ(with(scaled + "0.9996,0.9996,1.);").map_conversion->scale, 0.0009996);
  for (const char* factors : {"0.9996,0.9996,0.9996);", "1.,0.9996,1.);"}) {
    const Design design = with(scaled + factors);
    EXPECT_FALSE(design.map_conversion) << factors;
    ASSERT_EQ(design.warnings.size(), 1u) << factors;
    EXPECT_NE(design.warnings[0].find("stretches"), std::string::npos);
  }
}

TEST(Georeference, AWorldCoordinateSystemOffItsOriginIsNamed) {
  std::string bytes = small_building("IFC4",
                                     "#500=IFCPROJECTEDCRS('EPSG:25832',$,$,$,$,$,$);#503=IFCCARTESIANPOINT((5.,"
                                     "0.,0.));#504=IFCAXIS2PLACEMENT3D(#503,$,$);#502=IFCMAPCONVERSION(#22,#"
                                     "500,691000.,5335000.,520.,$,$,0.001);");
  EXPECT_TRUE(read(bytes).warnings.empty());
  const std::size_t at = bytes.find(",#21,$);", bytes.find("IFCGEOMETRICREPRESENTATIONCONTEXT"));
  ASSERT_NE(at, std::string::npos);
  bytes.replace(at, 8, ",#504,$);");
  ASSERT_EQ(read(bytes).warnings.size(), 1u);
  EXPECT_NE(read(bytes).warnings[0].find("off its origin"), std::string::npos);
}

TEST(RealDesigns, HaveTheStoreysAndElementsThatTheirFilesList) {
  struct Expected {
    const char* file;
    std::size_t storeys, elements, off_placement;
  };
  for (const Expected& expected :
       {Expected{"510--curtainWall.ifc", 1, 3, 1}, Expected{"Ifc4_SampleHouse.ifc", 2, 67, 20},
        Expected{"TallBuilding.ifc", 5, 82, 0}, Expected{"tested_sample_project_2x3.ifc", 2, 104, 1}}) {
    PLUMBLINE_REQUIRE_DATA(std::string("ifc/") + expected.file);
    const Design design =
        read_design(step::File::read(test::data_file(std::string("ifc/") + expected.file).string()), {});
    EXPECT_EQ(design.storeys.size(), expected.storeys) << expected.file;
    EXPECT_EQ(design.elements.size(), expected.elements) << expected.file;
    const auto off = std::count_if(design.elements.begin(), design.elements.end(),
                                   [](const Element& e) { return e.rule != ReferencePointRule::placement; });
    EXPECT_EQ(static_cast<std::size_t>(off), expected.off_placement) << expected.file;
    for (const Element& element : design.elements)
      EXPECT_FALSE(element.storey.empty()) << expected.file << " " << element.guid;
    EXPECT_TRUE(design.warnings.empty()) << expected.file << ": " << design.warnings[0];
  }
}

}  // namespace test_design
}  // namespace plumbline::ifc

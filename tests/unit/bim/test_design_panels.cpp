// Which elements of a design are panels: plates, cladding, walls that hang; parts of fixings are none.
#include <algorithm>

#include "base/text/text.hpp"
#include "design_reading.hpp"
#include "small_building.hpp"
#include "test_support.hpp"

namespace plumbline::ifc {
namespace test_design_panels {

using test::small_building;

/// A plate of `side` [mm] at the anchor F2-C1, with `kind` as PredefinedType (IFC4 on).
std::string plate_at_anchor(int side, const std::string& kind) {
  const std::string size = std::to_string(side) + ".";
  return "#500=IFCCARTESIANPOINT((2000.,-20.,400.));#501=IFCAXIS2PLACEMENT3D(#500,$,$);#502=IFCLOCALPLACEMENT(#34,#501)"
         ";"
         "#503=IFCRECTANGLEPROFILEDEF(.AREA.,$,#49," +
         size + ",20.);#504=IFCEXTRUDEDAREASOLID(#503,#21,#24," + size +
         ");#505=IFCSHAPEREPRESENTATION(#22,'Body','SweptSolid',(#504));#506=IFCPRODUCTDEFINITIONSHAPE($,$,(#505));"
         "#507=IFCPLATE('3bvctVUKr0kugbFTf53O9L',#5,'Base',$,$,#502,#506,$" +
         kind + ");";
}

TEST(Panels, PlatesOfAFixingAreNone) {
  const auto base = [](const std::string& schema, const std::string& extra, const AnchorRule& rule = {}) {
    const Design design = read(small_building(schema, extra), rule);
    EXPECT_TRUE(named(design, "Panel 1").is_panel);
    const bool told = std::any_of(design.warnings.begin(), design.warnings.end(), [](const std::string& warning) {
      return warning.find("1 small plate ('Base')") != std::string::npos;
    });
    return std::pair(named(design, "Base").is_panel, told);
  };
  EXPECT_EQ(base("IFC4", plate_at_anchor(200, ",$")), std::pair(false, true)) << "beside a panel fifty times as large";
  EXPECT_EQ(base("IFC2X3", plate_at_anchor(200, "")), std::pair(false, true));
  EXPECT_EQ(base("IFC4", plate_at_anchor(800, ",$")), std::pair(true, false)) << "may be a panel";
  EXPECT_EQ(base("IFC4", plate_at_anchor(200, ",.CURTAIN_PANEL.")), std::pair(true, false)) << "says that it clads";
  EXPECT_EQ(base("IFC4X3", plate_at_anchor(800, ",.BASE_PLATE.")), std::pair(false, false)) << "says what it is";
  AnchorRule all;
  all.panels = {"class=IfcPlate"};
  EXPECT_EQ(base("IFC4", plate_at_anchor(200, ",$"), all), std::pair(true, false)) << "the user's word";
}

TEST(Panels, AKindMayStandAtTheType) {
  const std::string type =
      "#510=IFCPLATETYPE('3cvctVUKr0kugbFTf53O9L',#5,'Type',$,$,$,$,$,$,.KIND.);"
      "#511=IFCRELDEFINESBYTYPE('3dvctVUKr0kugbFTf53O9L',#5,$,$,(#507),#510);";
  const auto with = [&](const std::string& kind, const std::string& own) {
    std::string text = type;
    return plate_at_anchor(200, own) + text.replace(text.find("KIND"), 4, kind);
  };
  const Design clads = read(small_building("IFC2X3", with("CURTAIN_PANEL", "")));
  EXPECT_TRUE(named(clads, "Base").is_panel && named(clads, "Base").is_cladding);
  EXPECT_EQ(named(clads, "Base").type_name, "Type");
  const Design fixing = read(small_building("IFC4X3", with("BASE_PLATE", ",.NOTDEFINED.")));
  EXPECT_FALSE(named(fixing, "Base").is_panel);
  const Design own = read(small_building("IFC4X3", with("BASE_PLATE", ",.CURTAIN_PANEL.")));
  EXPECT_TRUE(named(own, "Base").is_panel) << "its own goes first";
}

TEST(Panels, WhatHangsAtAnchorsWithoutAWordIsNotPassedOver) {
  std::string bytes = small_building("IFC4");
  for (const std::string ifc_class : {"IFCCURTAINWALL(", "IFCPLATE("})
    bytes.replace(bytes.find(ifc_class), ifc_class.size(), "IFCBUILDINGELEMENTPROXY(");
  const auto asked = [](const std::string& file, const AnchorRule& rule) {
    std::string text;
    for (const NotApplied& request : read(file, rule).not_applied) text += request.asked + ": " + request.reason;
    return text;
  };
  const std::string told = asked(bytes, {});
  EXPECT_NE(told.find("IfcBuildingElementProxy at anchors ('Facade' and 1 more)"), std::string::npos) << told;
  EXPECT_NE(told.find("panel_selection=['class=IfcBuildingElementProxy']"), std::string::npos) << told;
  EXPECT_NE(told.find("panel_selection=[none]"), std::string::npos) << told;
  // Upright slabs are precast parts; slabs that lie are floors, and of them nothing is said.
  std::string slabs = bytes;
  for (std::size_t at; (at = slabs.find("IFCBUILDINGELEMENTPROXY(")) != std::string::npos;)
    slabs.replace(at, 24, "IFCSLAB(");
  EXPECT_NE(asked(slabs, {}).find("IfcSlab at anchors ('Facade' and 1 more)"), std::string::npos) << asked(slabs, {});
  // Small plates at all of these anchors are no answer: they may be parts of the fixing.
  const Design bare = read(bytes);
  std::string plates;
  int number = 600;
  for (const Element& anchor : bare.elements) {
    if (!anchor.is_anchor) continue;
    const Eigen::Vector3d off = 1e3 * (anchor.position - named(bare, "F2-C1").position);
    std::string plate = plate_at_anchor(200, ",$");
    for (const std::string from : {"#500", "#501", "#502", "#503", "#504", "#505", "#506", "#507"})
      for (size_t at; (at = plate.find(from)) != std::string::npos;)
        plate.replace(at, 4, "#" + std::to_string(number + from.back() - '0'));
    plate.replace(plate.find("2000.,-20.,400."), 15,
                  text::format_fixed(2000 + off.y(), 3) + "," + text::format_fixed(-20 - off.x(), 3) + "," +
                      text::format_fixed(400 + off.z(), 3));
    plate.replace(plate.find("3bvc"), 4, "3b" + std::to_string(number / 10));
    plates += plate, number += 10;
  }
  std::string held = bytes;
  held.replace(held.rfind("ENDSEC;"), 0, plates);
  EXPECT_GT(number, 600);
  EXPECT_NE(asked(held, {}).find("IfcBuildingElementProxy at anchors ('Facade' and 1 more)"), std::string::npos)
      << asked(held, {});
  AnchorRule none, panels;
  none.panels = {"none"}, panels.panels = {"class=IfcBuildingElementProxy"};
  EXPECT_EQ(asked(bytes, none), "");
  EXPECT_EQ(asked(bytes, panels), "");
  EXPECT_TRUE(named(read(bytes, panels), "Panel 1").is_panel);
  // Narrow (a mullion), in the opening of a wall, and away from any anchor: nobody hangs it here.
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = bytes;
    return text.replace(text.find(from), from.size(), to);
  };
  EXPECT_EQ(asked(changed("$,#49,2200.,20.)", "$,#49,300.,20.)"), {}), "");
  EXPECT_EQ(asked(changed("(3000.,-100.,0.)", "(3000.,-900.,0.)"), {}), "");
  EXPECT_EQ(asked(changed("ENDSEC;\r\nEND-",
                          "#590=IFCRELFILLSELEMENT('3evctVUKr0kugbFTf53O9L',#5,$,$,#220,#228);"
                          "#591=IFCRELFILLSELEMENT('3fvctVUKr0kugbFTf53O9L',#5,$,$,#228,#220);"
                          "ENDSEC;\r\nEND-"),
                  {}),
            "");
}

/// Precast walls behind which base plates of no said kind lie: the walls are the panels, and not the plates.
TEST(Panels, AWallBeforeItsBasePlateIsThePanel) {
  std::string bytes = small_building("IFC4", plate_at_anchor(200, ",$"));
  for (const auto& [from, to] :
       {std::pair{"IFCCURTAINWALL(", "IFCBUILDINGELEMENTPROXY("}, {"#228=IFCPLATE(", "#228=IFCWALL("}})
    bytes.replace(bytes.find(from), std::string(from).size(), to);
  // One wall does not say which way it faces; then it is not judged, and that is told.
  const Design open = read(bytes);
  EXPECT_TRUE(std::any_of(open.not_applied.begin(), open.not_applied.end(),
                          [](const NotApplied& n) { return n.asked == "walls at anchors (Panel 1)"; }));
  AnchorRule faces;
  faces.facades = {parse_facade_rule("*: azimuth=90deg")};
  const Design before = read(bytes, faces);
  EXPECT_TRUE(named(before, "Panel 1").is_panel);
  EXPECT_FALSE(named(before, "Base").is_panel) << "a part of the fixing, behind the wall";
  EXPECT_TRUE(before.not_applied.empty());
  // A wall behind its anchors is what they are fixed to; the small plate may be a panel then.
  std::string behind = bytes;
  behind.replace(behind.find("(3000.,-100.,0.)"), 16, "(3000.,100.,0.)");
  const Design on_it = read(behind, faces);
  EXPECT_FALSE(named(on_it, "Panel 1").is_panel);
  EXPECT_TRUE(named(on_it, "Base").is_panel);
  // The user's word goes before.
  AnchorRule rule;
  rule.panels = {"class=IfcPlate"};
  EXPECT_FALSE(named(read(bytes, rule), "Panel 1").is_panel);
}

/// Small panels before the wall that their anchors are fixed to: plates that stand edge to edge are panels, and nobody
/// has to say what that wall is. Two beside each other may be the base plates of neighbours.
TEST(Panels, SmallPlatesEdgeToEdgeAreNoFixings) {
  const auto before_a_wall = [](const std::vector<double>& places) {
    std::string plates;
    for (std::size_t i = 0; i < places.size(); ++i) {
      std::string plate = plate_at_anchor(500, ",$");
      for (char digit = '0'; digit < '8'; ++digit)
        for (size_t at; (at = plate.find(std::string("#50") + digit)) != std::string::npos;)
          plate.replace(at, 4, "#" + std::to_string(600 + 10 * static_cast<int>(i) + digit - '0'));
      plate.replace(plate.find("2000.,-20.,400."), 15, text::format_fixed(places[i], 1) + ",-60.,400.");
      plate.replace(plate.find("3bvc"), 4, "3b" + std::to_string(60 + i));
      plate.replace(plate.find("'Base'"), 6, "'Base " + std::to_string(i) + "'");
      plates += plate;
    }
    std::string bytes = small_building("IFC4", plates);
    for (const auto& [from, to] : {std::pair{"IFCCURTAINWALL(", "IFCBUILDINGELEMENTPROXY("},
                                   {"#228=IFCPLATE(", "#228=IFCWALL("},
                                   {"(3000.,-100.,0.)", "(3000.,100.,0.)"}})
      bytes.replace(bytes.find(from), std::string(from).size(), to);
    return read(bytes);
  };
  const auto asks = [](const Design& design) {
    return std::any_of(design.not_applied.begin(), design.not_applied.end(),
                       [](const NotApplied& n) { return n.asked == "walls at anchors (Panel 1)"; });
  };
  const Design field = before_a_wall({1490, 2000, 2510, 3020, 3530, 4040});
  EXPECT_FALSE(asks(field));
  for (const char* name : {"Base 0", "Base 1", "Base 5"}) EXPECT_TRUE(named(field, name).is_panel) << name;
  EXPECT_FALSE(named(field, "Panel 1").is_panel);
  EXPECT_TRUE(asks(before_a_wall({1990, 2500, 3530, 4040}))) << "pairs";
  EXPECT_TRUE(asks(before_a_wall({1450, 2010, 2570, 3430, 3990}))) << "60 mm apart";
}

/// A plate of that body in the middle of nowhere; `lines` define #510.
Element bent_plate(const std::string& lines, const std::string& schema = "IFC4") {
  const Design design = read(small_building(
      schema,
      "#500=IFCCARTESIANPOINT((3000.,-100.,9000.));#501=IFCAXIS2PLACEMENT3D(#500,$,$);#502=IFCLOCALPLACEMENT(#34,"
      "#501);#505=IFCSHAPEREPRESENTATION(#22,'Body','SweptSolid',(#510));#506=IFCPRODUCTDEFINITIONSHAPE($,$,(#505"
      "));#507=IFCPLATE('3bvctVUKr0kugbFTf53O9L',#5,'Bent',$,$,#502,#506,$" +
          std::string(schema == "IFC2X3" ? "" : ",.CURTAIN_PANEL.") + ");" + lines));
  const Element& plate = named(design, "Bent");
  EXPECT_TRUE(plate.is_panel && plate.has_box);
  return plate;
}

std::vector<double> sag_of_plate(const std::string& lines, const std::string& schema = "IFC4") {
  return bent_plate(lines, schema).sag;
}

/// An outline in plan, 3 m high.
std::string upright(const std::string& curve) {
  return "#510=IFCEXTRUDEDAREASOLID(#511,#21,#24,3000.);#511=IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,#512);" + curve;
}

std::string bent(const std::string& points) {
  return upright(
      "#512=IFCINDEXEDPOLYCURVE(#513,(IFCARCINDEX((1,2,3)),IFCLINEINDEX((3,4)),IFCARCINDEX((4,5,6)),IFCLINEINDEX((6,1))"
      "),."
      "F.);#513=IFCCARTESIANPOINTLIST2D((" +
      points + "));");
}

std::string polyline(const std::vector<std::string>& points) {
  std::string list, lines;
  int number = 520;
  for (const std::string& point : points) {
    list += (list.empty() ? "#" : ",#") + std::to_string(number);
    lines += "#" + std::to_string(number++) + "=IFCCARTESIANPOINT((" + point + "));";
  }
  return upright("#512=IFCPOLYLINE((" + list + ",#520));" + lines);
}

/// 2 m wide, 20 mm thick, its outer side towards smaller y: what the design itself curves is known.
TEST(Panels, TheSagOfTheDesignsOwnSidesIsKnown) {
  const auto expect = [](const std::vector<double>& sag, double outer, double inner, const char* what) {
    ASSERT_EQ(sag.size(), 6U) << what;
    EXPECT_NEAR(sag[2], outer, 0.15 * outer + 1e-9) << what;
    EXPECT_NEAR(sag[3], inner, 0.15 * inner + 1e-9) << what;
    EXPECT_FALSE(sag[4] > 1e-9 || sag[5] > 1e-9) << what << ": its ends are planes, or less than half of a side";
  };
  expect(sag_of_plate(bent("(-1000.,0.),(0.,-30.),(1000.,0.),(1000.,20.),(0.,-10.),(-1000.,20.)")), 0.0257, 0.0257,
         "curved outward");
  expect(sag_of_plate(bent("(-1000.,-30.),(0.,0.),(1000.,-30.),(1000.,-10.),(0.,20.),(-1000.,-10.)")), 0.0257, 0.0257,
         "curved inward");
  const std::string flat = "(-1000.,0.),(0.,0.),(1000.,0.),(1000.,20.),(0.,20.),(-1000.,20.)";
  expect(sag_of_plate(bent(flat)), 0, 0, "arcs through points on a line");
  for (const char* schema : {"IFC2X3", "IFC4"}) {
    expect(sag_of_plate(polyline({"-1000.,20.", "-1000.,-5.", "-985.,-20.", "985.,-20.", "1000.,-5.", "1000.,20."}),
                        schema),
           0, 0, "flat with chamfers");
    expect(sag_of_plate(polyline({"-1000.,20.", "-1000.,0.", "0.,-30.", "1000.,0.", "1000.,20."}), schema), 0.0273, 0,
           "folded, and flat inside");
  }
  // Ribs behind it leave the outer side a plane.
  expect(sag_of_plate(polyline(
             {"-1000.,20.", "-1000.,0.", "1000.,0.", "1000.,20.", "100.,20.", "100.,80.", "-100.,80.", "-100.,20."})),
         0, 0.06, "a rib behind it");
}

/// A sheet 20 mm thick, extruded towards smaller y: an outline in elevation, of which the box says nothing.
TEST(Panels, WhatIsNoRectangleIsKnown) {
  const auto filled = [](const std::vector<std::string>& corners) {
    std::string list, lines;
    int number = 520;
    for (const std::string& corner : corners) {
      list += (list.empty() ? "#" : ",#") + std::to_string(number);
      lines += "#" + std::to_string(number++) + "=IFCCARTESIANPOINT((" + corner + "));";
    }
    const std::vector<double> sides =
        bent_plate(
            "#510=IFCEXTRUDEDAREASOLID(#511,#514,#517,20.);#511=IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,#512);"
            "#514=IFCAXIS2PLACEMENT3D(#513,#515,#516);#513=IFCCARTESIANPOINT((0.,0.,0.));#515=IFCDIRECTION((0.,-"
            "1.,0.));#516=IFCDIRECTION((1.,0.,0.));#517=IFCDIRECTION((0.,0.,1.));#512=IFCPOLYLINE((" +
            list + ",#520));" + lines)
            .filled;
    EXPECT_EQ(sides.size(), 6U);
    return sides.size() == 6 ? sides[2] : std::nan("");
  };
  EXPECT_EQ(filled({"0.,0.", "1200.,0.", "1200.,1000.", "0.,1000."}), 1);
  EXPECT_NEAR(filled({"0.,0.", "1000.,0.", "1200.,1000.", "0.,1000."}), 0.92, 0.02) << "one edge slants";
  EXPECT_NEAR(filled({"0.,0.", "1200.,0.", "0.,1000."}), 0.5, 0.05);
}

/// Joints are between outer sides, and the box is that of the whole body.
TEST(Panels, AnOuterSideThatIsNarrowerThanTheBodyIsKnown) {
  const auto rectangle = [](const std::vector<std::string>& corners) {
    const std::vector<double> all = bent_plate(polyline(corners)).rectangles;
    // Of the sides towards smaller and larger y: least and largest x.
    return all.size() == 24 ? std::vector<double>{all[9], all[11], all[13], all[15]} : std::vector<double>{};
  };
  const auto expect = [](const std::vector<double>& found, const std::vector<double>& wanted) {
    ASSERT_EQ(found.size(), wanted.size());
    for (std::size_t k = 0; k < wanted.size(); ++k) EXPECT_NEAR(found[k], wanted[k], 1e-9) << k;
  };
  expect(rectangle({"-1000.,20.", "-1000.,0.", "1000.,0.", "1000.,20."}), {});
  expect(rectangle({"-1000.,20.", "-1000.,-5.", "-985.,-20.", "985.,-20.", "1000.,-5.", "1000.,20."}),
         {-0.985, 0.985, -1, 1});
  expect(rectangle({"-1000.,20.", "-1000.,3.", "-994.,3.", "-994.,0.", "994.,0.", "994.,3.", "1000.,3.", "1000.,20."}),
         {-0.994, 0.994, -1, 1});
  // A rib stands out before it, or a rim: with it the side is as wide as the body.
  expect(rectangle({"-1000.,20.", "-1000.,0.", "-30.,0.", "-30.,-40.", "30.,-40.", "30.,0.", "1000.,0.", "1000.,20."}),
         {});
  expect(rectangle({"-1000.,20.", "-1000.,-20.", "-970.,-20.", "-970.,0.", "970.,0.", "970.,-20.", "1000.,-20.",
                    "1000.,20."}),
         {});
}

TEST(Panels, TheSagOfFacesThatAreListed) {
  // A sheet of two facets, folded by 30 mm in its middle, and one that is flat.
  const auto facets = [](const std::string& middle) {
    return sag_of_plate(
        "#510=IFCTRIANGULATEDFACESET(#511,$,$,((1,2,5),(1,5,4),(2,3,6),(2,6,5)),$);#511=IFCCARTESIANPOINTLIST3D(((-"
        "1000.,0"
        ".,0.),(0.," +
        middle + ",0.),(1000.,0.,0.),(-1000.,0.,3000.),(0.," + middle + ",3000.),(1000.,0.,3000.)));");
  };
  EXPECT_NEAR(facets("-30.")[2], 0.027, 0.002);
  EXPECT_NEAR(facets("30.")[2], 0.027, 0.002);
  EXPECT_NEAR(facets("0.")[2], 0, 1e-9);
  const auto brep = [](const std::string& middle) {
    std::string lines = "#510=IFCFACETEDBREP(#511);#511=IFCCLOSEDSHELL((#531,#541));";
    const std::string y[2][4] = {{"0.", middle, middle, "0."}, {middle, "0.", "0.", middle}};
    const char *x[2][4] = {{"-1000.", "0.", "0.", "-1000."}, {"0.", "1000.", "1000.", "0."}},
               *z[4] = {"0.", "0.", "3000.", "3000."};
    for (int face = 0; face < 2; ++face) {
      const int id = 531 + 10 * face;
      const auto n = [&](int k) { return "#" + std::to_string(id + k); };
      lines += n(0) + "=IFCFACE((" + n(1) + "));" + n(1) + "=IFCFACEOUTERBOUND(" + n(2) + ",.T.);" + n(2) +
               "=IFCPOLYLOOP((" + n(3) + "," + n(4) + "," + n(5) + "," + n(6) + "));";
      for (int k = 0; k < 4; ++k)
        lines += n(3 + k) + "=IFCCARTESIANPOINT((" + x[face][k] + "," + y[face][k] + "," + z[k] + "));";
    }
    return sag_of_plate(lines, "IFC2X3");
  };
  EXPECT_NEAR(brep("-30.")[2], 0.027, 0.002);
  EXPECT_NEAR(brep("0.")[2], 0, 1e-9);
}

}  // namespace test_design_panels
}  // namespace plumbline::ifc

// A building small enough to work out by hand, in any of the schemas and in millimetres: two storeys at 0 and 3.5 m on
// a site that is turned by 90° and moved, one slab, two anchors a floor, a curtain wall with a plate, a misplaced
// anchor.
#pragma once

#include <string>

namespace plumbline::test {

/// For `extra`, in IFC4: a third anchor of the panel, above the line of the other two, which alone do not tell how it
/// turns about that line.
inline const std::string kThirdAnchor =
    "#500=IFCCARTESIANPOINT((3000.,0.,900.));\r\n#501=IFCAXIS2PLACEMENT3D(#500,$,$);\r\n"
    "#502=IFCLOCALPLACEMENT(#34,#501);\r\n"
    "#503=IFCMECHANICALFASTENER('23vctVUKr0kugbFTf53O9L',#5,'F2-C3',$,'M20',#502,#55,'T3',$,$,.ANCHORBOLT.);\r\n"
    "#504=IFCRELCONTAINEDINSPATIALSTRUCTURE('3bvctVUKr0kugbFTf53O9L',#5,$,$,(#503),#36);";

/// `extra` are further instances, from #500 on. `length_unit` is the instance of the length unit (#11).
inline std::string small_building(const std::string& schema, const std::string& extra = "",
                                  const std::string& length_unit = "#11=IFCSIUNIT(*,.LENGTHUNIT.,.MILLI.,.METRE.);") {
  // IFC4 gave fasteners, plates and curtain walls a last argument, PredefinedType.
  const std::string last = schema == "IFC2X3" ? ");" : ",$);";
  const std::string fastener = schema == "IFC2X3" ? "$,$);" : "$,$,.ANCHORBOLT.);";
  std::string out =
      "ISO-10303-21;\r\nHEADER;\r\nFILE_DESCRIPTION(('ViewDefinition [CoordinationView]'),'2;1');\r\n"
      "FILE_NAME('small.ifc','2024-01-01T00:00:00',('A'),('B'),'C','D','E');\r\nFILE_SCHEMA(('" +
      schema + "'));\r\nENDSEC;\r\nDATA;\r\n";
  const auto line = [&out](const std::string& text) { out += text + "\r\n"; };
  line("#1=IFCPERSON($,'Doe',$,$,$,$,$,$);");
  line("#2=IFCORGANIZATION($,'Office',$,$,$);");
  line("#3=IFCPERSONANDORGANIZATION(#1,#2,$);");
  line("#4=IFCAPPLICATION(#2,'1','Modeller','MOD');");
  line("#5=IFCOWNERHISTORY(#3,#4,$,.NOCHANGE.,$,$,$,1700000000);");
  line(length_unit);
  line("#12=IFCSIUNIT(*,.PLANEANGLEUNIT.,$,.RADIAN.);");
  line("#13=IFCUNITASSIGNMENT((#11,#12));");
  // A conversion-based unit that nobody assigned: it must not count.
  line("#14=IFCDIMENSIONALEXPONENTS(1,0,0,0,0,0,0);");
  line("#15=IFCMEASUREWITHUNIT(IFCLENGTHMEASURE(304.8),#11);");
  line("#16=IFCCONVERSIONBASEDUNIT(#14,.LENGTHUNIT.,'FOOT',#15);");
  line("#20=IFCCARTESIANPOINT((0.,0.,0.));");
  line("#21=IFCAXIS2PLACEMENT3D(#20,$,$);");
  line("#22=IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-05,#21,$);");
  line("#23=IFCPROJECT('0YvctVUKr0kugbFTf53O9L',#5,'Small',$,$,$,$,(#22),#13);");
  line("#24=IFCDIRECTION((0.,0.,1.));");
  line("#25=IFCDIRECTION((0.,1.,0.));");
  line("#26=IFCCARTESIANPOINT((10000.,20000.,100.));");
  line("#27=IFCAXIS2PLACEMENT3D(#26,#24,#25);");
  line("#28=IFCLOCALPLACEMENT($,#27);");
  line("#29=IFCSITE('1YvctVUKr0kugbFTf53O9L',#5,'Site',$,$,#28,$,$,.ELEMENT.,$,$,$,$,$);");
  line("#30=IFCLOCALPLACEMENT(#28,#21);");
  line("#31=IFCBUILDING('2YvctVUKr0kugbFTf53O9L',#5,'Stra\\X2\\00DF\\X0\\e',$,$,#30,$,$,.ELEMENT.,$,$,$);");
  line("#32=IFCCARTESIANPOINT((0.,0.,3500.));");
  line("#33=IFCAXIS2PLACEMENT3D(#32,$,$);");
  line("#34=IFCLOCALPLACEMENT(#30,#33);");
  line("#35=IFCLOCALPLACEMENT(#30,#21);");
  line("#36=IFCBUILDINGSTOREY('3YvctVUKr0kugbFTf53O9L',#5,'Level 2',$,$,#34,$,$,.ELEMENT.,3500.);");
  line("#37=IFCBUILDINGSTOREY('0ZvctVUKr0kugbFTf53O9L',#5,'Level 1',$,$,#35,$,$,.ELEMENT.,0.);");
  line("#38=IFCRELAGGREGATES('1ZvctVUKr0kugbFTf53O9L',#5,$,$,#23,(#29));");
  line("#39=IFCRELAGGREGATES('2ZvctVUKr0kugbFTf53O9L',#5,$,$,#29,(#31));");
  line("#40=IFCRELAGGREGATES('3ZvctVUKr0kugbFTf53O9L',#5,$,$,#31,(#36,#37));");
  // a bolt of 20 mm and 100 mm along z, about the origin of its placement
  line("#48=IFCCARTESIANPOINT((0.,0.));");
  line("#49=IFCAXIS2PLACEMENT2D(#48,$);");
  line("#50=IFCCIRCLEPROFILEDEF(.AREA.,$,#49,10.);");
  line("#51=IFCCARTESIANPOINT((0.,0.,-50.));");
  line("#52=IFCAXIS2PLACEMENT3D(#51,$,$);");
  line("#53=IFCEXTRUDEDAREASOLID(#50,#52,#24,100.);");
  line("#54=IFCSHAPEREPRESENTATION(#22,'Body','SweptSolid',(#53));");
  line("#55=IFCPRODUCTDEFINITIONSHAPE($,$,(#54));");
  int id = 100;
  for (const int floor : {1, 2})
    for (const int column : {1, 2}) {
      const std::string n = std::to_string(id), shape = "#55";
      line("#" + n + "=IFCCARTESIANPOINT((" + std::to_string(2000 * column) + ".,0.,500.));");
      line("#" + std::to_string(id + 1) + "=IFCAXIS2PLACEMENT3D(#" + n + ",$,$);");
      line("#" + std::to_string(id + 2) + "=IFCLOCALPLACEMENT(#" + (floor == 1 ? "35" : "34") + ",#" +
           std::to_string(id + 1) + ");");
      line("#" + std::to_string(id + 3) + "=IFCMECHANICALFASTENER('" + std::to_string(floor) + std::to_string(column) +
           "vctVUKr0kugbFTf53O9L',#5,'F" + std::to_string(floor) + "-C" + std::to_string(column) + "',$,'M20',#" +
           std::to_string(id + 2) + "," + shape + ",'T" + n + "'," + fastener);
      id += 10;
    }
  line("#200=IFCRELCONTAINEDINSPATIALSTRUCTURE('0avctVUKr0kugbFTf53O9L',#5,$,$,(#103,#113),#37);");
  line("#201=IFCRELCONTAINEDINSPATIALSTRUCTURE('1avctVUKr0kugbFTf53O9L',#5,$,$,(#123,#133,#220),#36);");
  // a curtain wall without shape, whose plate is its part and in no storey by itself
  line("#219=IFCLOCALPLACEMENT(#34,#21);");
  line("#220=IFCCURTAINWALL('2avctVUKr0kugbFTf53O9L',#5,'Facade',$,$,#219,$,$" + last);
  line("#221=IFCCARTESIANPOINT((3000.,-100.,0.));");
  line("#222=IFCAXIS2PLACEMENT3D(#221,$,$);");
  line("#223=IFCLOCALPLACEMENT(#219,#222);");
  line("#224=IFCRECTANGLEPROFILEDEF(.AREA.,$,#49,2200.,20.);");
  line("#225=IFCEXTRUDEDAREASOLID(#224,#21,#24,1000.);");
  line("#226=IFCSHAPEREPRESENTATION(#22,'Body','SweptSolid',(#225));");
  line("#227=IFCPRODUCTDEFINITIONSHAPE($,$,(#226));");
  line("#228=IFCPLATE('3avctVUKr0kugbFTf53O9L',#5,'Panel 1',$,$,#223,#227,$" + last);
  line("#229=IFCRELAGGREGATES('0bvctVUKr0kugbFTf53O9L',#5,$,$,#220,(#228));");
  if (!extra.empty()) line(extra);
  return out + "ENDSEC;\r\nEND-ISO-10303-21;\r\n";
}

}  // namespace plumbline::test

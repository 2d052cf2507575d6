#include "building/ifc/ifc_schema.hpp"

#include <algorithm>
#include <array>

#include "building/ifc/ifc_elements.hpp"

namespace plumbline::ifc {
namespace {

constexpr unsigned k2x3 = 1, k4 = 2, k4x3 = 4;

constexpr EntityLayout kLayouts[] = {
    // objects
    {"IFCELEMENT", kAllSchemas, "GlobalId OwnerHistory Name Description ObjectType ObjectPlacement Representation Tag"},
    {"IFCPROXY", k2x3 | k4, "GlobalId OwnerHistory Name Description ObjectType ObjectPlacement Representation"},
    {"IFCPROJECT", kAllSchemas,
     "GlobalId OwnerHistory Name Description ObjectType LongName Phase RepresentationContexts UnitsInContext"},
    {"IFCSITE", kAllSchemas, "GlobalId OwnerHistory Name Description ObjectType ObjectPlacement Representation"},
    {"IFCBUILDING", kAllSchemas, "GlobalId OwnerHistory Name Description ObjectType ObjectPlacement Representation"},
    {"IFCBUILDINGSTOREY", kAllSchemas,
     "GlobalId OwnerHistory Name Description ObjectType ObjectPlacement Representation LongName CompositionType "
     "Elevation"},
    {"IFCGRID", kAllSchemas,
     "GlobalId OwnerHistory Name Description ObjectType ObjectPlacement Representation UAxes VAxes WAxes"},
    {"IFCOWNERHISTORY", kAllSchemas,
     "OwningUser OwningApplication State ChangeAction LastModifiedDate LastModifyingUser LastModifyingApplication "
     "CreationDate"},
    {"IFCAPPLICATION", kAllSchemas, "ApplicationDeveloper Version ApplicationFullName ApplicationIdentifier"},
    // relations
    {"IFCRELAGGREGATES", kAllSchemas, "GlobalId OwnerHistory Name Description RelatingObject RelatedObjects"},
    {"IFCRELNESTS", kAllSchemas, "GlobalId OwnerHistory Name Description RelatingObject RelatedObjects"},
    {"IFCRELCONTAINEDINSPATIALSTRUCTURE", kAllSchemas,
     "GlobalId OwnerHistory Name Description RelatedElements RelatingStructure"},
    {"IFCRELVOIDSELEMENT", kAllSchemas,
     "GlobalId OwnerHistory Name Description RelatingBuildingElement RelatedOpeningElement"},
    {"IFCRELPROJECTSELEMENT", kAllSchemas,
     "GlobalId OwnerHistory Name Description RelatingElement RelatedFeatureElement"},
    {"IFCRELFILLSELEMENT", kAllSchemas,
     "GlobalId OwnerHistory Name Description RelatingOpeningElement RelatedBuildingElement"},
    {"IFCRELCONNECTSWITHREALIZINGELEMENTS", kAllSchemas,
     "GlobalId OwnerHistory Name Description ConnectionGeometry RelatingElement RelatedElement RealizingElements "
     "ConnectionType"},
    {"IFCRELCONNECTSELEMENTS", kAllSchemas,
     "GlobalId OwnerHistory Name Description ConnectionGeometry RelatingElement RelatedElement"},
    {"IFCRELDEFINESBYTYPE", kAllSchemas, "GlobalId OwnerHistory Name Description RelatedObjects RelatingType"},
    {"IFCRELDEFINESBYPROPERTIES", kAllSchemas,
     "GlobalId OwnerHistory Name Description RelatedObjects RelatingPropertyDefinition"},
    {"IFCRELASSIGNSTOGROUP", kAllSchemas,
     "GlobalId OwnerHistory Name Description RelatedObjects RelatedObjectsType RelatingGroup"},
    {"IFCELEMENTQUANTITY", kAllSchemas, "GlobalId OwnerHistory Name Description MethodOfMeasurement Quantities"},
    {"IFCPROPERTYENUMERATION", kAllSchemas, "Name EnumerationValues Unit"},
    {"IFCPROPERTYSET", kAllSchemas, "GlobalId OwnerHistory Name Description HasProperties"},
    {"IFCPROPERTYSINGLEVALUE", k2x3 | k4, "Name Description NominalValue Unit"},
    {"IFCPROPERTYSINGLEVALUE", k4x3, "Name Specification NominalValue Unit"},
    {"IFCPROPERTYBOUNDEDVALUE", k2x3, "Name Description UpperBoundValue LowerBoundValue Unit"},
    {"IFCPROPERTYBOUNDEDVALUE", k4, "Name Description UpperBoundValue LowerBoundValue Unit SetPointValue"},
    {"IFCPROPERTYBOUNDEDVALUE", k4x3, "Name Specification UpperBoundValue LowerBoundValue Unit SetPointValue"},
    // units and georeference
    {"IFCUNITASSIGNMENT", kAllSchemas, "Units"},
    {"IFCSIUNIT", kAllSchemas, "Dimensions UnitType Prefix Name"},
    {"IFCCONVERSIONBASEDUNIT", kAllSchemas, "Dimensions UnitType Name ConversionFactor"},
    {"IFCCONVERSIONBASEDUNITWITHOFFSET", k4 | k4x3, "Dimensions UnitType Name ConversionFactor"},
    {"IFCMEASUREWITHUNIT", kAllSchemas, "ValueComponent UnitComponent"},
    {"IFCMAPCONVERSION", k4 | k4x3,
     "SourceCRS TargetCRS Eastings Northings OrthogonalHeight XAxisAbscissa XAxisOrdinate Scale"},
    {"IFCMAPCONVERSIONSCALED", k4x3,
     "SourceCRS TargetCRS Eastings Northings OrthogonalHeight XAxisAbscissa XAxisOrdinate Scale FactorX FactorY "
     "FactorZ"},
    {"IFCRIGIDOPERATION", k4x3, "SourceCRS TargetCRS FirstCoordinate SecondCoordinate Height"},
    {"IFCPROJECTEDCRS", k4, "Name Description GeodeticDatum VerticalDatum MapProjection MapZone MapUnit"},
    {"IFCPROJECTEDCRS", k4x3, "Name Description GeodeticDatum VerticalDatum MapProjection MapZone MapUnit"},
    // placements
    {"IFCLOCALPLACEMENT", kAllSchemas, "PlacementRelTo RelativePlacement"},
    {"IFCGRIDPLACEMENT", k2x3 | k4, "PlacementLocation PlacementRefDirection"},
    {"IFCGRIDPLACEMENT", k4x3, "PlacementRelTo PlacementLocation PlacementRefDirection"},
    {"IFCLINEARPLACEMENT", k4x3, "PlacementRelTo RelativePlacement CartesianPosition"},
    {"IFCVIRTUALGRIDINTERSECTION", kAllSchemas, "IntersectingAxes OffsetDistances"},
    {"IFCGRIDAXIS", kAllSchemas, "AxisTag AxisCurve SameSense"},
    {"IFCAXIS1PLACEMENT", kAllSchemas, "Location Axis"},
    {"IFCAXIS2PLACEMENT2D", kAllSchemas, "Location RefDirection"},
    {"IFCAXIS2PLACEMENT3D", kAllSchemas, "Location Axis RefDirection"},
    {"IFCCARTESIANPOINT", kAllSchemas, "Coordinates"},
    {"IFCDIRECTION", kAllSchemas, "DirectionRatios"},
    {"IFCVECTOR", kAllSchemas, "Orientation Magnitude"},
    {"IFCCARTESIANTRANSFORMATIONOPERATOR2D", kAllSchemas, "Axis1 Axis2 LocalOrigin Scale"},
    {"IFCCARTESIANTRANSFORMATIONOPERATOR2DNONUNIFORM", kAllSchemas, "Axis1 Axis2 LocalOrigin Scale Scale2"},
    {"IFCCARTESIANTRANSFORMATIONOPERATOR3D", kAllSchemas, "Axis1 Axis2 LocalOrigin Scale Axis3"},
    {"IFCCARTESIANTRANSFORMATIONOPERATOR3DNONUNIFORM", kAllSchemas,
     "Axis1 Axis2 LocalOrigin Scale Axis3 Scale2 Scale3"},
    // representations
    {"IFCGEOMETRICREPRESENTATIONCONTEXT", kAllSchemas,
     "ContextIdentifier ContextType CoordinateSpaceDimension Precision WorldCoordinateSystem TrueNorth"},
    {"IFCPRODUCTDEFINITIONSHAPE", kAllSchemas, "Name Description Representations"},
    {"IFCSHAPEREPRESENTATION", kAllSchemas, "ContextOfItems RepresentationIdentifier RepresentationType Items"},
    {"IFCTOPOLOGYREPRESENTATION", kAllSchemas, "ContextOfItems RepresentationIdentifier RepresentationType Items"},
    {"IFCREPRESENTATIONMAP", kAllSchemas, "MappingOrigin MappedRepresentation"},
    {"IFCMAPPEDITEM", kAllSchemas, "MappingSource MappingTarget"},
    {"IFCEXTRUDEDAREASOLID", kAllSchemas, "SweptArea Position ExtrudedDirection Depth"},
    {"IFCEXTRUDEDAREASOLIDTAPERED", k4 | k4x3, "SweptArea Position ExtrudedDirection Depth EndSweptArea"},
    {"IFCREVOLVEDAREASOLID", kAllSchemas, "SweptArea Position Axis Angle"},
    {"IFCREVOLVEDAREASOLIDTAPERED", k4 | k4x3, "SweptArea Position Axis Angle EndSweptArea"},
    {"IFCSWEPTDISKSOLID", kAllSchemas, "Directrix Radius InnerRadius StartParam EndParam"},
    {"IFCSWEPTDISKSOLIDPOLYGONAL", k4 | k4x3, "Directrix Radius InnerRadius StartParam EndParam"},
    {"IFCFACETEDBREP", kAllSchemas, "Outer"},
    {"IFCFACETEDBREPWITHVOIDS", kAllSchemas, "Outer"},
    {"IFCADVANCEDBREP", k4 | k4x3, "Outer"},
    {"IFCADVANCEDBREPWITHVOIDS", k4 | k4x3, "Outer"},
    {"IFCFACEBASEDSURFACEMODEL", kAllSchemas, "FbsmFaces"},
    {"IFCSHELLBASEDSURFACEMODEL", kAllSchemas, "SbsmBoundary"},
    {"IFCCONNECTEDFACESET", kAllSchemas, "CfsFaces"},
    {"IFCCLOSEDSHELL", kAllSchemas, "CfsFaces"},
    {"IFCOPENSHELL", kAllSchemas, "CfsFaces"},
    {"IFCFACE", kAllSchemas, "Bounds"},
    {"IFCFACESURFACE", kAllSchemas, "Bounds FaceSurface SameSense"},
    {"IFCADVANCEDFACE", k4 | k4x3, "Bounds FaceSurface SameSense"},
    {"IFCFACEBOUND", kAllSchemas, "Bound Orientation"},
    {"IFCFACEOUTERBOUND", kAllSchemas, "Bound Orientation"},
    {"IFCPOLYLOOP", kAllSchemas, "Polygon"},
    {"IFCEDGELOOP", kAllSchemas, "EdgeList"},
    {"IFCVERTEXLOOP", kAllSchemas, "LoopVertex"},
    {"IFCORIENTEDEDGE", kAllSchemas, "EdgeStart EdgeEnd EdgeElement Orientation"},
    {"IFCEDGECURVE", kAllSchemas, "EdgeStart EdgeEnd EdgeGeometry SameSense"},
    {"IFCVERTEXPOINT", kAllSchemas, "VertexGeometry"},
    {"IFCTRIANGULATEDFACESET", k4 | k4x3, "Coordinates Normals Closed CoordIndex PnIndex"},
    {"IFCTRIANGULATEDIRREGULARNETWORK", k4x3, "Coordinates Normals Closed CoordIndex PnIndex"},
    {"IFCPOLYGONALFACESET", k4 | k4x3, "Coordinates Closed Faces PnIndex"},
    {"IFCINDEXEDPOLYGONALFACE", k4 | k4x3, "CoordIndex"},
    {"IFCINDEXEDPOLYGONALFACEWITHVOIDS", k4 | k4x3, "CoordIndex"},
    {"IFCCARTESIANPOINTLIST2D", k4 | k4x3, "CoordList"},
    {"IFCCARTESIANPOINTLIST3D", k4 | k4x3, "CoordList"},
    {"IFCBOOLEANRESULT", kAllSchemas, "Operator FirstOperand SecondOperand"},
    {"IFCBOOLEANCLIPPINGRESULT", kAllSchemas, "Operator FirstOperand SecondOperand"},
    {"IFCCSGSOLID", kAllSchemas, "TreeRootExpression"},
    {"IFCBLOCK", kAllSchemas, "Position XLength YLength ZLength"},
    {"IFCRECTANGULARPYRAMID", kAllSchemas, "Position XLength YLength Height"},
    {"IFCRIGHTCIRCULARCYLINDER", kAllSchemas, "Position Height Radius"},
    {"IFCRIGHTCIRCULARCONE", kAllSchemas, "Position Height BottomRadius"},
    {"IFCSPHERE", kAllSchemas, "Position Radius"},
    {"IFCBOUNDINGBOX", kAllSchemas, "Corner XDim YDim ZDim"},
    {"IFCGEOMETRICSET", kAllSchemas, "Elements"},
    {"IFCGEOMETRICCURVESET", kAllSchemas, "Elements"},
    // curves
    {"IFCPOLYLINE", kAllSchemas, "Points"},
    {"IFCLINE", kAllSchemas, "Pnt Dir"},
    {"IFCCIRCLE", kAllSchemas, "Position Radius"},
    {"IFCELLIPSE", kAllSchemas, "Position SemiAxis1 SemiAxis2"},
    {"IFCTRIMMEDCURVE", kAllSchemas, "BasisCurve Trim1 Trim2 SenseAgreement MasterRepresentation"},
    {"IFCCOMPOSITECURVE", kAllSchemas, "Segments SelfIntersect"},
    {"IFCCOMPOSITECURVESEGMENT", kAllSchemas, "Transition SameSense ParentCurve"},
    {"IFCINDEXEDPOLYCURVE", k4 | k4x3, "Points Segments"},
    {"IFCBSPLINECURVEWITHKNOTS", k4 | k4x3, "Degree ControlPointsList"},
    {"IFCRATIONALBSPLINECURVEWITHKNOTS", k4 | k4x3, "Degree ControlPointsList"},
    // profiles
    {"IFCRECTANGLEPROFILEDEF", kAllSchemas, "ProfileType ProfileName Position XDim YDim"},
    {"IFCROUNDEDRECTANGLEPROFILEDEF", kAllSchemas, "ProfileType ProfileName Position XDim YDim"},
    {"IFCRECTANGLEHOLLOWPROFILEDEF", kAllSchemas, "ProfileType ProfileName Position XDim YDim"},
    {"IFCCIRCLEPROFILEDEF", kAllSchemas, "ProfileType ProfileName Position Radius"},
    {"IFCCIRCLEHOLLOWPROFILEDEF", kAllSchemas, "ProfileType ProfileName Position Radius"},
    {"IFCELLIPSEPROFILEDEF", kAllSchemas, "ProfileType ProfileName Position SemiAxis1 SemiAxis2"},
    {"IFCISHAPEPROFILEDEF", kAllSchemas, "ProfileType ProfileName Position OverallWidth OverallDepth"},
    {"IFCLSHAPEPROFILEDEF", kAllSchemas, "ProfileType ProfileName Position Depth Width"},
    {"IFCTSHAPEPROFILEDEF", kAllSchemas, "ProfileType ProfileName Position Depth FlangeWidth"},
    {"IFCUSHAPEPROFILEDEF", kAllSchemas, "ProfileType ProfileName Position Depth FlangeWidth"},
    {"IFCCSHAPEPROFILEDEF", kAllSchemas, "ProfileType ProfileName Position Depth Width"},
    {"IFCZSHAPEPROFILEDEF", kAllSchemas, "ProfileType ProfileName Position Depth FlangeWidth WebThickness"},
    {"IFCTRAPEZIUMPROFILEDEF", kAllSchemas, "ProfileType ProfileName Position BottomXDim TopXDim YDim TopXOffset"},
    {"IFCARBITRARYCLOSEDPROFILEDEF", kAllSchemas, "ProfileType ProfileName OuterCurve"},
    {"IFCARBITRARYPROFILEDEFWITHVOIDS", kAllSchemas, "ProfileType ProfileName OuterCurve"},
    {"IFCDERIVEDPROFILEDEF", kAllSchemas, "ProfileType ProfileName ParentProfile Operator"},
    {"IFCCOMPOSITEPROFILEDEF", kAllSchemas, "ProfileType ProfileName Profiles"},
};

bool equal_but_for_case(std::string_view name, std::string_view capitals) {
  return std::equal(name.begin(), name.end(), capitals.begin(), capitals.end(),
                    [](char a, char b) { return (a >= 'a' && a <= 'z' ? static_cast<char>(a - 'a' + 'A') : a) == b; });
}

}  // namespace

Schema schema_of(const step::File& file) {
  std::string found;
  for (const std::string& name : file.schemas()) {
    if (name.starts_with("IFC2X3")) return Schema::ifc2x3;
    if (name.starts_with("IFC4X3")) return Schema::ifc4x3;
    if (name == "IFC4" || name.starts_with("IFC4_") || name.starts_with("IFC4X1") || name.starts_with("IFC4X2"))
      return Schema::ifc4;
    found += (found.empty() ? "" : ", ") + name;
  }
  throw step::Error(file.name() + ": FILE_SCHEMA names " + (found.empty() ? "no schema" : "'" + found + "'") +
                    ", expected IFC2X3, IFC4 or IFC4X3");
}

const char* schema_name(Schema schema) {
  return schema == Schema::ifc2x3 ? "IFC2X3" : schema == Schema::ifc4 ? "IFC4" : "IFC4X3";
}

std::span<const EntityLayout> entity_layouts() { return kLayouts; }

const EntityLayout* find_layout(Schema schema, std::string_view keyword) {
  for (const EntityLayout& layout : kLayouts)
    if (layout.keyword == keyword && (layout.schemas & static_cast<unsigned>(schema))) return &layout;
  return element_class_name(schema, keyword).empty() ? nullptr : &kLayouts[0];
}

std::optional<std::size_t> attribute_position(const EntityLayout& layout, std::string_view attribute) {
  std::string_view rest = layout.attributes;
  for (std::size_t position = 0; !rest.empty(); ++position) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    if (rest.substr(0, end) == attribute) return position;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return {};
}

std::span<const ElementClass> element_classes() { return kElementClasses; }

std::string_view element_class_name(Schema schema, std::string_view keyword) {
  for (const ElementClass& element : kElementClasses)
    if ((element.schemas & static_cast<unsigned>(schema)) && equal_but_for_case(element.name, keyword))
      return element.name;
  return {};
}

}  // namespace plumbline::ifc

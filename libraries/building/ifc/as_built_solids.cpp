#include "building/ifc/as_built_solids.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "building/ifc/ifc_guid.hpp"
#include "building/step/step_writer.hpp"

namespace plumbline::ifc {
namespace {

using step::list;
using step::null;
using step::reference;
using step::text;

constexpr const char* kSolid = "IFCBUILDINGELEMENTPROXY";
constexpr double kMarkerRadius = 0.03;  ///< [m]
constexpr double kPanelGrowth = 0.001;  ///< [m] so that a panel as built does not flicker in the design's

/// The three-dimensional context of the project, its "Body" if it has one; 0 without any.
InstanceId body_context(const Model& model) {
  InstanceId whole = 0;
  for (const Entity& project : model.all("IFCPROJECT"))
    for (const InstanceId id : project.references("RepresentationContexts")) {
      if (model.keyword(id) != "IFCGEOMETRICREPRESENTATIONCONTEXT") continue;
      const auto arguments =
          model.entity(id).arguments();  // ContextIdentifier, ContextType, CoordinateSpaceDimension, …
      if (arguments.size() > 2 && arguments[2].number == 3 && whole == 0) whole = id;
    }
  return whole;
}

Container container_at(const Model& model, Placements& placements, InstanceId instance, double length_unit) {
  Container container;
  container.instance = instance;
  const Entity entity = model.entity(instance);
  container.key = entity.text("GlobalId");
  if (const auto placement = entity.optional_reference("ObjectPlacement")) {
    container.project_from_container = placements.project_from_placement(*placement, instance);
    container.project_from_container.translation *= length_unit;
    container.placement = *placement;
  }
  return container;
}

}  // namespace

std::string key_prefix_of(const std::string& epoch) { return epoch.empty() ? "" : epoch + "/"; }

std::string as_built_solid_guid(const std::string& project_guid, const std::string& epoch, const std::string& element) {
  return derived_ifc_guid(project_guid, std::string(kSolid) + "/" + key_prefix_of(epoch) + element);
}

ProductWriter::ProductWriter(Appender& appender, const Design& design, std::string key_prefix)
    : appender_(appender), prefix_(std::move(key_prefix)), context_(body_context(appender.model())) {
  const Model& model = appender.model();
  Placements placements(model);
  const auto add = [&](const std::string& key, InstanceId instance) {
    try {
      containers_.try_emplace(key, container_at(model, placements, instance, design.length_unit));
    } catch (const step::Error&) {  // a storey that cannot be placed contains nothing of ours
    }
  };
  for (const Storey& storey : design.storeys) add(storey.guid, storey.instance);
  for (const char* keyword : {"IFCBUILDING", "IFCSITE"})
    for (const std::uint32_t index : model.file().of_type(keyword))
      if (!containers_.contains("")) add("", model.file().instances()[index].id);
  if (!containers_.contains("") && !containers_.empty()) containers_[""] = containers_.begin()->second;
}

const Container& ProductWriter::container_of(const std::string& storey_guid) const {
  const auto found = containers_.find(storey_guid);
  return found == containers_.end() ? containers_.at("") : found->second;
}

InstanceId ProductWriter::origin() {
  if (!origin_) origin_ = appender_.add("IFCCARTESIANPOINT", {list({"0.", "0.", "0."})});
  return origin_;
}

InstanceId ProductWriter::shape(const char* identifier, const char* type, InstanceId item) {
  const InstanceId representation = appender_.add(
      "IFCSHAPEREPRESENTATION", {reference(context_), text(identifier), text(type), list({reference(item)})});
  layered_.push_back(reference(representation));
  return appender_.add("IFCPRODUCTDEFINITIONSHAPE", {null, null, list({reference(representation)})});
}

void ProductWriter::add_survey_point(const AnchorDeviationT& anchor, const std::string& name) {
  const Container& container = container_of(anchor.storey_guid);
  const InstanceId placement =
      appender_.add_placement(container.placement, container.project_from_container.inverse() * anchor.as_built);
  const InstanceId points = appender_.add("IFCGEOMETRICSET", {list({reference(origin())})});
  std::vector<std::string> rest{text("SurveyPoint"), reference(placement),
                                reference(shape("Annotation", "GeometricSet", points))};
  if (appender_.schema() == Schema::ifc4x3) rest.push_back(step::enumeration("SURVEY"));
  const std::string key = prefix_ + anchor.guid;
  const InstanceId point = appender_.add_root("IFCANNOTATION", key, name, "Measured position of the anchor", rest);
  appender_.add_root("IFCRELASSIGNSTOPRODUCT", key, "", "",
                     {list({reference(point)}), null, reference(anchor.instance)});
  contained_[container.key].push_back(point), products_.push_back(point);
}

/// Colours of Okabe and Ito (2008), which colour-blind people tell apart.
InstanceId ProductWriter::style_of(ToleranceVerdict verdict, bool panel) {
  InstanceId& style = styles_[{verdict, panel}];
  if (style) return style;
  const char* red = "0.835";
  const char* green = "0.369";
  const char* blue = "0.";
  if (verdict == ToleranceVerdict::pass) red = "0.", green = "0.62", blue = "0.451";
  if (verdict == ToleranceVerdict::undecided) red = "0.902", green = "0.624", blue = "0.";
  const InstanceId colour = appender_.add("IFCCOLOURRGB", {null, red, green, blue});
  const InstanceId rendering = appender_.add(
      "IFCSURFACESTYLERENDERING",
      {reference(colour), panel ? "0.4" : "0.", null, null, null, null, null, null, step::enumeration("NOTDEFINED")});
  style = appender_.add("IFCSURFACESTYLE", {text(std::string("As-built ") + (panel ? "panel " : "anchor ") +
                                                 EnumNameToleranceVerdict(verdict)),
                                            step::enumeration("BOTH"), list({reference(rendering)})});
  // Before IFC4 a styled item names its styles through an assignment.
  if (appender_.schema() == Schema::ifc2x3)
    style = appender_.add("IFCPRESENTATIONSTYLEASSIGNMENT", {list({reference(style)})});
  return style;
}

InstanceId ProductWriter::extrusion(InstanceId profile, double bottom, double height) {
  const InstanceId at =
      appender_.add("IFCAXIS2PLACEMENT3D", {reference(appender_.add_point(Eigen::Vector3d(0, 0, bottom))), null, null});
  return appender_.add("IFCEXTRUDEDAREASOLID",
                       {reference(profile), reference(at), reference(appender_.add_direction(Eigen::Vector3d::UnitZ())),
                        appender_.length(height)});
}

void ProductWriter::add_proxy(const std::string& key, const std::string& name, const std::string& object_type,
                              InstanceId solid, ToleranceVerdict verdict, bool panel, const Container& container,
                              const RigidTransform& project_from_own, InstanceId element) {
  appender_.add("IFCSTYLEDITEM", {reference(solid), list({reference(style_of(verdict, panel))}), null});
  const InstanceId placement =
      appender_.add_placement(container.placement, container.project_from_container.inverse() * project_from_own);
  const InstanceId proxy = appender_.add_root(
      kSolid, key, name, std::string("As built: ") + EnumNameToleranceVerdict(verdict),
      {text(object_type), reference(placement), reference(shape("Body", "SweptSolid", solid)), null, null});
  appender_.add_root("IFCRELASSIGNSTOPRODUCT", key + "/solid", "", "",
                     {list({reference(proxy)}), null, reference(element)});
  contained_[container.key].push_back(proxy), products_.push_back(proxy);
}

void ProductWriter::add_marker(const AnchorDeviationT& anchor, const std::string& name) {
  InstanceId& profile = profiles_[anchor.verdict];
  if (!profile) {
    const auto corner = [&](double x, double y) {
      return reference(appender_.add("IFCCARTESIANPOINT", {list({appender_.length(x), appender_.length(y)})}));
    };
    const std::string middle = corner(0, 0);
    const std::string axes = reference(appender_.add("IFCAXIS2PLACEMENT2D", {middle, null}));
    const std::string area = step::enumeration("AREA");
    if (anchor.verdict == ToleranceVerdict::pass) {
      profile = appender_.add("IFCCIRCLEPROFILEDEF", {area, null, axes, appender_.length(kMarkerRadius)});
    } else if (anchor.verdict == ToleranceVerdict::fail) {
      const std::string side = appender_.length(2 * kMarkerRadius);
      profile = appender_.add("IFCRECTANGLEPROFILEDEF", {area, null, axes, side, side});
    } else {
      const double r = 1.3 * kMarkerRadius, half = r * std::sqrt(0.75);
      const std::string top = corner(0, r), left = corner(-half, -r / 2), right = corner(half, -r / 2);
      const InstanceId line = appender_.add("IFCPOLYLINE", {list({top, left, right, top})});
      profile = appender_.add("IFCARBITRARYCLOSEDPROFILEDEF", {area, null, reference(line)});
    }
  }
  const InstanceId solid = extrusion(profile, -kMarkerRadius, 2 * kMarkerRadius);
  add_proxy(prefix_ + anchor.guid, name, "AsBuiltAnchor", solid, anchor.verdict, false,
            container_of(anchor.storey_guid), RigidTransform{Eigen::Quaterniond::Identity(), anchor.as_built},
            anchor.instance);
}

void ProductWriter::add_panel(const PanelDeviationT& panel, const Element& element) {
  const Eigen::Vector3d size = element.box_high - element.box_low + Eigen::Vector3d::Constant(2 * kPanelGrowth);
  const Eigen::Vector3d middle = 0.5 * (element.box_high + element.box_low);
  const Eigen::Vector3d centre = element.project_from_element * middle;
  RigidTransform moved;
  const double angle = panel.rotation.norm();
  const Eigen::Quaterniond turn(angle > 0 ? Eigen::AngleAxisd(angle, panel.rotation / angle)
                                          : Eigen::AngleAxisd::Identity());
  moved.rotation = turn * element.project_from_element.rotation;
  moved.translation = centre + panel.shift;
  const InstanceId at = appender_.add("IFCCARTESIANPOINT", {list({"0.", "0."})});
  const InstanceId axes = appender_.add("IFCAXIS2PLACEMENT2D", {reference(at), null});
  const InstanceId profile = appender_.add(
      "IFCRECTANGLEPROFILEDEF",
      {step::enumeration("AREA"), null, reference(axes), appender_.length(size.x()), appender_.length(size.y())});
  const InstanceId solid = extrusion(profile, -0.5 * size.z(), size.z());
  add_proxy(prefix_ + panel.guid, "As-built " + panel.name, "AsBuiltPanel", solid, panel.verdict, true,
            container_of(panel.storey_guid), moved, panel.instance);
}

void ProductWriter::finish() {
  if (!layered_.empty())
    appender_.add("IFCPRESENTATIONLAYERASSIGNMENT",
                  {text("As built" + (prefix_.empty() ? "" : " " + prefix_.substr(0, prefix_.size() - 1))),
                   text("Measured positions and panels; no part of the design"), list(layered_), null});
  for (const auto& [key, container] : containers_) {
    const auto found = contained_.find(container.key);
    if (found == contained_.end()) continue;
    std::vector<std::string> products;
    for (const InstanceId product : found->second) products.push_back(reference(product));
    appender_.add_root("IFCRELCONTAINEDINSPATIALSTRUCTURE", prefix_ + container.key, "", "",
                       {list(products), reference(container.instance)});
    contained_.erase(found);
  }
}

}  // namespace plumbline::ifc

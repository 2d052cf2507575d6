// As-built one sees: small solids with the colour of the verdict, as elements of their own, tied to those of the
// design.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "artifacts/deviation.hpp"
#include "building/ifc/design.hpp"
#include "building/ifc/ifc_appender.hpp"
#include "building/ifc/ifc_placement.hpp"

namespace plumbline::ifc {

/// What GlobalIds of a campaign's solids come from, beside those of their elements.
std::string key_prefix_of(const std::string& epoch);
/// GlobalId of the solid that stands in the as-built file of that campaign for an anchor or panel as it was built.
std::string as_built_solid_guid(const std::string& project_guid, const std::string& epoch, const std::string& element);

/// Where additions are contained: the storey of their element, else the building, else the site.
struct Container {
  InstanceId instance = 0, placement = 0;  ///< 0: none
  RigidTransform project_from_container;   ///< [m]
  std::string key;                         ///< for GlobalIds
};

/// Adds products at places of the project frame, each contained in the spatial structure and assigned to its element of
/// the design. Call finish() at the end: it writes the containment relations.
class ProductWriter {
 public:
  ProductWriter(Appender& appender, const Design& design, std::string key_prefix);

  /// Whether there is a three-dimensional context and a spatial element to contain anything.
  bool possible() const { return context_ != 0 && !containers_.empty(); }

  /// An IfcAnnotation with a point. `element` is the instance it belongs to.
  void add_survey_point(const AnchorDeviationT& anchor, const std::string& name);
  /// A solid of some centimetres: cylinder for pass, cube for fail, prism for undecided, so that it reads without
  /// colour.
  void add_marker(const AnchorDeviationT& anchor, const std::string& name);
  /// The panel's box where its anchors hold it, a millimetre larger all around.
  void add_panel(const PanelDeviationT& panel, const Element& element);
  void finish();
  /// All that were added.
  const std::vector<InstanceId>& products() const { return products_; }

 private:
  const Container& container_of(const std::string& storey_guid) const;
  InstanceId shape(const char* identifier, const char* type, InstanceId item);
  InstanceId origin();
  InstanceId style_of(ToleranceVerdict verdict, bool panel);
  void add_proxy(const std::string& key, const std::string& name, const std::string& object_type, InstanceId solid,
                 ToleranceVerdict verdict, bool panel, const Container& container,
                 const RigidTransform& project_from_own, InstanceId element);
  InstanceId extrusion(InstanceId profile, double bottom, double height);

  Appender& appender_;
  std::string prefix_;
  InstanceId context_ = 0, origin_ = 0;
  std::map<std::string, Container> containers_;  // by GlobalId of the storey; "" for the rest
  std::map<std::string, std::vector<InstanceId>> contained_;
  std::vector<InstanceId> products_;
  std::vector<std::string> layered_;  // representations, as references
  std::map<std::pair<ToleranceVerdict, bool>, InstanceId> styles_;
  std::map<ToleranceVerdict, InstanceId> profiles_;
};

}  // namespace plumbline::ifc

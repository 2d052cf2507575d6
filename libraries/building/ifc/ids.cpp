#include "building/ifc/ids.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "base/text/xml_text.hpp"
#include "building/ifc/design.hpp"

namespace plumbline::ifc {
namespace {

using text::xml_escaped;

std::string simple(const std::string& value) { return "<simpleValue>" + xml_escaped(value) + "</simpleValue>"; }

std::string one_of(const std::vector<std::string>& values) {
  std::string text = "<xs:restriction base=\"xs:string\">";
  for (const std::string& value : values) text += "<xs:enumeration value=\"" + xml_escaped(value) + "\"/>";
  return text + "</xs:restriction>";
}

std::string upper(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::toupper(c); });
  return name;
}

/// What elements a specification is about: one class, and of it these GlobalIds.
struct Subject {
  std::string ifc_class;
  std::vector<std::string> guids;  ///< empty: all
};

class Writer {
 public:
  Writer(const Design& design, const IdsOptions& options) : options_(options) {
    version_ = design.schema == "IFC4X3" ? "IFC4X3_ADD2" : design.schema;
  }

  /// A specification of its own for each class, because the entity facet of IDS holds for all that is asked.
  void specification(const std::string& name, const std::string& why, const Subject& subject,
                     const std::vector<std::string>& requirements) {
    text_ += "  <specification name=\"" + xml_escaped(name) + "\" ifcVersion=\"" + version_ + "\" description=\"" +
             xml_escaped(why) +
             "\">\n    <applicability minOccurs=\"1\" maxOccurs=\"unbounded\">\n      <entity><name>" +
             simple(upper(subject.ifc_class)) + "</name></entity>\n";
    if (!subject.guids.empty())
      text_ += "      <attribute><name>" + simple("GlobalId") + "</name><value>" + one_of(subject.guids) +
               "</value></attribute>\n";
    text_ += "    </applicability>\n    <requirements>\n";
    for (const std::string& requirement : requirements) text_ += "      " + requirement + "\n";
    text_ += "    </requirements>\n  </specification>\n";
  }

  std::string property(const std::string& set, const std::string& name, const std::string& type,
                       const std::vector<std::string>& values = {}) const {
    const std::string in = options_.epoch.empty() ? set : set + "_" + options_.epoch;
    return "<property dataType=\"" + type + "\" cardinality=\"required\"><propertySet>" + simple(in) +
           "</propertySet><baseName>" + simple(name) + "</baseName>" +
           (values.empty() ? "" : "<value>" + one_of(values) + "</value>") + "</property>";
  }

  std::string verdict(const std::string& set) const {
    return property(set, "Verdict", "IFCLABEL", {"PASS", "FAIL", "UNDECIDED", "NOTMEASURED"});
  }

  std::string finish(const std::string& title) const {
    return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<ids xmlns=\"http://standards.buildingsmart.org/IDS\" "
           "xmlns:xs=\"http://www.w3.org/2001/XMLSchema\" xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" "
           "xsi:schemaLocation=\"http://standards.buildingsmart.org/IDS "
           "http://standards.buildingsmart.org/IDS/1.0/ids.xsd\">\n<info><title>" +
           xml_escaped(title) + "</title>" + (options_.date.empty() ? "" : "<date>" + options_.date + "</date>") +
           "<purpose>" + (options_.must_pass ? "Acceptance of the facade's substructure" : "As-built deviations") +
           "</purpose></info>\n<specifications>\n" + text_ + "</specifications>\n</ids>\n";
  }

 private:
  const IdsOptions& options_;
  std::string version_, text_;
};

using ByClass = std::map<std::string, std::vector<std::string>>;

void ask_of_anchors(const DeviationT& deviation, const IdsOptions& options, Writer& writer) {
  ByClass all, measured, with_u;
  for (const auto& anchor : deviation.anchors) {
    if (anchor->instance == 0 || anchor->guid.size() != 22) continue;
    all[anchor->class_].push_back(anchor->guid);
    if (!anchor->deviation.allFinite()) continue;
    measured[anchor->class_].push_back(anchor->guid);
    const auto is_known = [](double value) { return std::isfinite(value); };
    if (anchor->covariance.size() == 9 && std::all_of(anchor->covariance.begin(), anchor->covariance.end(), is_known))
      with_u[anchor->class_].push_back(anchor->guid);
  }
  const std::string set = "ASB_AnchorDeviation", length = "IFCLENGTHMEASURE";
  for (const auto& [ifc_class, guids] : all)
    writer.specification("Every anchor has a verdict (" + ifc_class + ")",
                         "Anchors of the plate table and of the design, by their GlobalIds", {ifc_class, guids},
                         {writer.verdict(set)});
  for (const auto& [ifc_class, guids] : measured)
    writer.specification(
        "Measured anchors say where they are (" + ifc_class + ")",
        "As-built minus design in the axes of the project, and the measured position", {ifc_class, guids},
        {writer.property(set, "DeviationX", length), writer.property(set, "DeviationY", length),
         writer.property(set, "DeviationZ", length), writer.property(set, "Deviation3D", length),
         writer.property(set, "DesignPosition", length), writer.property(set, "AsBuiltPosition", length)});
  for (const auto& [ifc_class, guids] : with_u)
    writer.specification(
        "Measured anchors say how sure that is (" + ifc_class + ")", "Standard uncertainties of the measured position",
        {ifc_class, guids},
        {writer.property("ASB_Uncertainty", "StdX", length), writer.property("ASB_Uncertainty", "StdY", length),
         writer.property("ASB_Uncertainty", "StdZ", length)});
  if (!options.must_pass) return;
  for (const auto& [ifc_class, guids] : all)
    writer.specification("Every anchor is within tolerance (" + ifc_class + ")", "Acceptance", {ifc_class, guids},
                         {writer.property(set, "Verdict", "IFCLABEL", {"PASS"})});
}

/// Panels whose parts are panels are judged by these.
ByClass panels_of(const Design& design) {
  std::set<std::string> wholes;
  for (const Element& element : design.elements)
    if (element.is_panel) wholes.insert(element.parent_guid);
  ByClass panels;
  for (const Element& element : design.elements)
    if (element.is_panel && !wholes.contains(element.guid) && element.guid.size() == 22)
      panels[element.ifc_class].push_back(element.guid);
  return panels;
}

void ask_of_panels(const Design& design, const DeviationT& deviation, const IdsOptions& options, Writer& writer) {
  std::map<std::string, std::string> class_of;
  for (const Element& element : design.elements)
    if (element.is_panel) class_of[element.guid] = element.ifc_class;
  ByClass judged, fitted;
  for (const auto& panel : deviation.panels) {
    const auto found = class_of.find(panel->guid);
    if (panel->instance == 0 || panel->guid.size() != 22 || found == class_of.end()) continue;
    judged[found->second].push_back(panel->guid);
    if (panel->shift.allFinite()) fitted[found->second].push_back(panel->guid);
  }
  for (const auto& [ifc_class, guids] : fitted)
    writer.specification("Panels say how they sit on their anchors (" + ifc_class + ")",
                         "Best fit of the panel to its anchors as built", {ifc_class, guids},
                         {writer.property("ASB_PanelFit", "FitX", "IFCLENGTHMEASURE"),
                          writer.property("ASB_PanelFit", "FitY", "IFCLENGTHMEASURE"),
                          writer.property("ASB_PanelFit", "FitZ", "IFCLENGTHMEASURE")});
  for (const auto& [ifc_class, guids] : judged)
    writer.specification("Every judged panel has a verdict (" + ifc_class + ")", "The worst of its lengths and anchors",
                         {ifc_class, guids}, {writer.verdict("ASB_PanelFit")});
  if (!options.must_pass) return;
  // Also of those that nobody judged, which have no verdict.
  for (const auto& [ifc_class, guids] : panels_of(design))
    writer.specification("Every panel is within tolerance (" + ifc_class + ")", "Acceptance", {ifc_class, guids},
                         {writer.property("ASB_PanelFit", "Verdict", "IFCLABEL", {"PASS"})});
}

/// The verdict on all of it, which no element shows: nothing passes while something that was asked for is not judged,
/// a surface fails or the measurement is in doubt.
void ask_of_the_whole(const IdsOptions& options, Writer& writer) {
  const Subject project{"IfcProject", {}};
  writer.specification("The whole has a verdict", "Anchors, panels, surfaces and all that was asked for", project,
                       {writer.verdict("ASB_Judgement")});
  if (options.must_pass)
    writer.specification("The whole is ready to install", "Acceptance: nothing fails, is undecided or not judged",
                         project, {writer.property("ASB_Judgement", "Verdict", "IFCLABEL", {"PASS"})});
}

}  // namespace

std::string write_ids(const Design& design, const DeviationT& deviation, const IdsOptions& options) {
  Writer writer(design, options);
  writer.specification("It is the model of this project", "By the GlobalId of IfcProject", {"IfcProject", {}},
                       {"<attribute cardinality=\"required\"><name>" + simple("GlobalId") + "</name><value>" +
                        simple(design.project_guid) + "</value></attribute>"});
  ask_of_anchors(deviation, options, writer);
  ask_of_panels(design, deviation, options, writer);
  ask_of_the_whole(options, writer);
  return writer.finish("As-built model of " + design.file_name);
}

}  // namespace plumbline::ifc

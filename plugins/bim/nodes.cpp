// bim.read_ifc and bim.write_ifc: the design in, the as-built state out.
#include "artifacts.hpp"
#include "artifacts/file.hpp"
#include "artifacts/plates.hpp"
#include "ifc/as_built_ifc.hpp"
#include "plumbline/node.hpp"

namespace plumbline::bim {
namespace {

step::File step_file(const FileT& file) {
  return step::File(std::string(file.content.begin(), file.content.end()), file.name);
}

struct ReadIfc : Node {
  static constexpr Info info{"bim.read_ifc", "", 1,
                             "Reads storeys, elements, anchors and panels from an IFC file (IFC2X3, IFC4, IFC4X3)"};
  In<plumbline::File> file{"file", "the IFC file (STEP text)"};
  Optional<Plates> plates{"plates", "anchor table: elements of these names (or tags) are anchors too"};
  Param<std::vector<std::string>> anchors{
      "anchors", {"IfcMechanicalFastener", "IfcDiscreteAccessory"}, "IFC classes whose elements are facade anchors"};
  Param<std::string> anchor_pattern{
      "anchor_pattern", "",
      "regular expression; elements whose name, object type, type name or tag it finds are anchors too"};
  Param<std::vector<std::string>> anchor_guids{"anchor_guids", std::vector<std::string>{},
                                               "GlobalIds of elements that are anchors too"};
  Out<plumbline::Design> design{"design", frame("frame=building"), "the design in the project frame"};
  Out<Points> anchor_points{"anchors", frame("frame=building"), "reference points of the anchors"};

  AnchorRule rule() const {
    AnchorRule rule{*anchors, *anchor_pattern, *anchor_guids, {}};
    if (!plates) return rule;
    for (const auto& plate : plates.unpack().plates) rule.names.push_back(plate->anchor);
    return rule;
  }

  void run(Context& context) override {
    const Design result = read_design(step_file(file.unpack()), rule());
    for (const std::string& warning : result.warnings) context.warn(warning);
    const PointsT points = bim::anchor_points(result);
    context.info(std::to_string(result.storeys.size()) + " storeys, " + std::to_string(result.elements.size()) +
                 " elements, " + std::to_string(points.points.size()) + " of them anchors");
    design.commit(to_artifact(result));
    anchor_points.commit(points);
  }
};

struct WriteIfc : Node {
  static constexpr Info info{"bim.write_ifc", "bim_writer", 1,
                             "Writes the as-built state into a copy of the design IFC, as property sets; (14) and dz"};
  In<plumbline::File> design_file{"design_file", "the design IFC; its own lines stay as they are"};
  In<plumbline::Design> design{"design", frame("frame=?F"), "what bim.read_ifc read from that file"};
  In<Accuracy> accuracy{"accuracy", frame("frame=?F"), "evaluation against the survey"};
  In<Points> model{"model", frame("frame=?F"), "as-built points with their covariance"};
  Param<double> tolerance_xy{"tolerance_xy", 0, "m", between(0, 1),
                             "of the horizontal deviation from the design; 0: tau of the evaluation"};
  Param<double> tolerance_z{"tolerance_z", 0, "m", between(0, 1),
                            "of the vertical deviation; 0: tau of the evaluation"};
  Param<std::vector<double>> facade_normal{"facade_normal", std::vector<double>{}, "1", between(-1, 1),
                                           "outward, x y z; empty: from the anchors"};
  Param<double> panel_reach{"panel_reach", kPanelReach, "m", between(0, 10),
                            "anchors so near to a panel fix it, where the design does not say"};
  Param<bool> survey_points{"survey_points", true, "an IfcAnnotation at every measured position"};
  Param<std::string> epoch{"epoch", "", "name of the campaign; campaigns of different names can stand in one file"};
  Param<int64_t> timestamp{"timestamp", 0, "s", at_least(0),
                           "date of the additions since 1970; 0: the latest date in the design file"};
  Param<std::string> file_name{"file_name", "as_built.ifc", "name of the file"};
  Param<std::string> method{"method", "photogrammetry under survey control", "for ASB_Provenance"};
  Param<std::string> instrument{"instrument", "", "for ASB_Provenance, such as total station and camera"};
  Param<std::string> observation_time{"observation_time", "", "for ASB_Provenance, ISO 8601"};
  Param<std::string> run_id{"run_id", "", "for ASB_Provenance"};
  Out<plumbline::File> out{"file", "the as-built IFC"};

  AsBuilt as_built(const Design& read) const {
    AsBuilt result = as_built_from(model.unpack(), accuracy.unpack());
    if (*tolerance_xy > 0) result.tolerance_xy = *tolerance_xy;
    if (*tolerance_z > 0) result.tolerance_z = *tolerance_z;
    result.panel_reach = *panel_reach;
    if (facade_normal->size() == 3) {
      const Eigen::Vector3d normal(facade_normal->data());
      if (!(normal.norm() > 1e-6)) throw std::runtime_error("parameter 'facade_normal' is 0 0 0, expected a direction");
      result.facade_normal = normal.normalized();
    } else if (!facade_normal->empty()) {
      throw std::runtime_error("parameter 'facade_normal' has " + std::to_string(facade_normal->size()) +
                               " numbers, expected three");
    }
    result.provenance = {{"Method", *method},
                         {"Instrument", *instrument},
                         {"ObservationTime", *observation_time},
                         {"AdjustmentRunId", *run_id},
                         {"DesignFile", read.file_name},
                         {"SoftwareVersion", "Plumbline " PLUMBLINE_BUILD_ID}};
    return result;
  }

  void run(Context& context) override {
    const FileT original = design_file.unpack();
    const step::File file = step_file(original);
    const Design read = from_artifact(design.unpack());
    require_same_file(file, read);
    const AsBuiltIfc result = write_as_built(file, read, as_built(read), {*epoch, *timestamp, *survey_points});
    for (const std::string& warning : result.warnings) context.warn(warning);
    context.metric("anchors_measured", result.measured, "1");
    context.metric("anchors_passed", result.passed, "1");
    context.metric("anchors_undecided", result.undecided, "1");
    context.metric("anchors_failed", result.failed, "1");
    FileT to;
    to.name = *file_name;
    to.media_type = "application/x-step";
    to.content.assign(result.bytes.begin(), result.bytes.end());
    out.commit(to);
  }

  /// The additions refer to instances by number: those of another file would be nonsense.
  static void require_same_file(const step::File& file, const Design& read) {
    for (const Element& element : read.elements) {
      const step::Instance* instance = file.find(element.instance);
      if (instance && file.arguments(*instance).at(0).text == element.guid) continue;
      throw std::runtime_error("input 'design' was read from " + read.file_name + ", in which #" +
                               std::to_string(element.instance) + " is " + element.guid + "; in 'design_file' " +
                               file.name() + " it is not: connect both to the same file");
    }
  }
};

}  // namespace
}  // namespace plumbline::bim

PLUMBLINE_PLUGIN("bim", "0.1.0", "MIT", plumbline::bim::ReadIfc, plumbline::bim::WriteIfc)

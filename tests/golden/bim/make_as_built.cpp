// make_as_built OUT FILE.ifc … : enriches design files with known deviations, and says in OUT/NAME.json what an
// independent reader must find, and in OUT/NAME.ids what the second campaign's file has to hold.
// OUT/NAME.two_epochs.ifc holds a second campaign with every verdict in it.
#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "../../unit/bim/doubt.hpp"
#include "../../unit/bim/loop_state.hpp"
#include "../../unit/bim/measured.hpp"
#include "../../unit/bim/small_building.hpp"
#include "building/ifc/as_built_ifc.hpp"
#include "building/ifc/ids.hpp"
#include "building/ifc/installation_ifc.hpp"
#include "building/judgement/surfaces.hpp"

namespace {

using namespace plumbline;
using Json = nlohmann::json;

/// Every anchor a little higher than the one before.
DeviationT measurements(const ifc::Design& design) {
  std::map<std::string, Eigen::Vector3d> deviations;
  double step = 0;
  for (const ifc::Element& element : design.elements)
    if (element.is_anchor) deviations[element.guid] = Eigen::Vector3d(0.001, -0.002, 0.0001 * step++);
  return test::judged(design, deviations, Eigen::Vector3d::Constant(1e-4), Eigen::Vector3d::Constant(std::nan("")));
}

/// The next campaign: some did not move, some are out of tolerance, some nearly, some were not measured.
DeviationT second_epoch(const ifc::Design& design) {
  std::map<std::string, Eigen::Vector3d> deviations;
  int k = 0;
  for (const ifc::Element& element : design.elements)
    if (element.is_anchor && ++k % 4 != 0)
      deviations[element.guid] = Eigen::Vector3d(0, 0.001, k % 4 == 1 ? 0.009 : k % 4 == 2 ? 0.005 : 0);
  DeviationT judged = test::judged(design, deviations, Eigen::Vector3d::Constant(1e-3), Eigen::Vector3d(0, -1, 0));
  // What people are told may be longer than a label of IFC.
  judged.doubts.push_back(std::make_unique<MeasurementDoubtT>(test::doubt(std::string(300, 'x'))));
  judged.doubts.back()->grade = DoubtGrade::doubt;
  judged.misfits.push_back(std::make_unique<MeasurementDoubtT>(test::doubt("the residuals are as large")));
  judged.misfits.back()->grade = DoubtGrade::misfit, judged.misfits.back()->factor = 1.3;
  return judged;
}

Json box_of(const ifc::Element& element) {
  if (!element.has_box) return nullptr;
  Eigen::AlignedBox3d box;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d local(corner & 1 ? element.box_high.x() : element.box_low.x(),
                                corner & 2 ? element.box_high.y() : element.box_low.y(),
                                corner & 4 ? element.box_high.z() : element.box_low.z());
    box.extend(Eigen::Vector3d(element.project_from_element * local));
  }
  return {box.min().x(), box.min().y(), box.min().z(), box.max().x(), box.max().y(), box.max().z()};
}

Json vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// Whether the axes of the element are those of the project, so that its box is the box of the project's axes too.
bool parallel(const ifc::Element& element) {
  return (element.project_from_element.rotation.toRotationMatrix().cwiseAbs().array().round() -
          element.project_from_element.rotation.toRotationMatrix().cwiseAbs().array())
             .abs()
             .maxCoeff() < 1e-6;
}

/// Everything in order, and of it nothing or one thing not judged: the acceptance accepts the first alone.
void make_accepted(const std::filesystem::path& out, const step::File& file) {
  const ifc::Design design = ifc::read_design(file, {});
  std::map<std::string, Eigen::Vector3d> deviations;
  for (const ifc::Element& element : design.elements)
    if (element.is_anchor) deviations[element.guid] = Eigen::Vector3d(1e-4, 1e-4, 1e-4);
  DeviationT deviation = test::judged(design, deviations, Eigen::Vector3d::Constant(1e-4), {0, -1, 0});
  const AccuracyT accuracy = test::residuals(deviation, 0.00005);
  std::ofstream(out / "accepted.ids") << ifc::write_ids(design, deviation, {"", "2026-05-12", true});
  const auto write = [&](const std::string& name) {
    std::ofstream(out / name, std::ios::binary)
        << ifc::enriched(file, ifc::write_as_built(file, design, deviation, accuracy, {}));
  };
  write("accepted.ifc");
  SurfaceJudgementT surfaces;
  surfaces.requests.push_back(std::make_unique<JudgementRequestT>());
  surfaces.requests[0]->asked = "*: flatness(1m)=3mm", surfaces.requests[0]->not_judged = "nobody looked at it";
  judgement::take_surfaces(std::move(surfaces), deviation);
  write("not_judged.ifc");
  deviation.panels.clear(), deviation.verdict = ToleranceVerdict::pass;
  write("panel_not_judged.ifc");
}

void make(const std::filesystem::path& out, const std::string& name, const step::File& file) {
  const ifc::Design design =
      ifc::read_design(file, {{"IfcMechanicalFastener", "IfcWindow", "IfcPlate"}, "", {}, {}, {}, true});
  const DeviationT deviation = measurements(design);
  const AccuracyT accuracy = test::residuals(deviation, 0.00005);
  ifc::AsBuiltIfcOptions options;
  options.provenance = {{"Method", "test"}};
  const ifc::AsBuiltIfc result = ifc::write_as_built(file, design, deviation, accuracy, options);
  std::ofstream(out / (name + ".design.ifc"), std::ios::binary) << file.bytes();
  std::ofstream(out / (name + ".as_built.ifc"), std::ios::binary) << ifc::enriched(file, result);
  options.epoch = "2026-05";
  const step::File once = step::File(ifc::enriched(file, result), name + ".as_built.ifc");
  const DeviationT later = second_epoch(design);
  const AccuracyT residuals = test::residuals(later, 0.00005);
  const std::string twice = ifc::enriched(once, ifc::write_as_built(once, design, later, residuals, options));
  const step::File two(twice, name + ".two_epochs.ifc");
  std::ofstream(out / (name + ".ids")) << ifc::write_ids(design, later, {options.epoch, "2026-05-12", false});
  const auto [plan, state] = test::loop_of(design);
  std::ofstream(out / (name + ".two_epochs.ifc"), std::ios::binary)
      << ifc::enriched(two, ifc::write_installation(two, design, plan, state, {}));
  Json expected{{"length_unit", design.length_unit},
                {"instances", file.instances().size() + result.instances_added},
                {"storeys", Json::array()},
                {"elements", Json::array()},
                {"anchors", Json::array()}};
  for (const ifc::Storey& storey : design.storeys)
    expected["storeys"].push_back({{"guid", storey.guid}, {"name", storey.name}, {"height", storey.placement_height}});
  for (const ifc::Element& element : design.elements)
    expected["elements"].push_back(
        {{"guid", element.guid},
         {"class", element.ifc_class},
         {"storey", element.storey_guid},
         {"placement", vector(element.project_from_element.translation)},
         {"axes",
          {vector(element.project_from_element.rotation * Eigen::Vector3d::UnitX()),
           vector(element.project_from_element.rotation * Eigen::Vector3d::UnitZ())}},
         {"box", element.rule == ifc::ReferencePointRule::parts_centre ? Json() : box_of(element)},
         {"parallel", parallel(element)}});
  for (const auto& anchor : deviation.anchors)
    expected["anchors"].push_back({{"guid", anchor->guid},
                                   {"deviation", {anchor->deviation.x(), anchor->deviation.y(), anchor->deviation.z()}},
                                   {"delta_z", 0.00005},
                                   {"verdict", ifc::label_of(anchor->verdict)},
                                   {"floor", anchor->floor}});
  std::ofstream(out / (name + ".json")) << expected.dump(1);
}

}  // namespace

int main(int count, char** arguments) {
  try {
    const std::filesystem::path out = arguments[1];
    std::filesystem::create_directories(out);
    for (const char* schema : {"IFC2X3", "IFC4", "IFC4X3"})
      make(out, std::string("small_") + schema, step::File(test::small_building(schema), schema));
    make_accepted(out, step::File(test::small_building("IFC4", test::kThirdAnchor), "accepted"));
    for (int i = 2; i < count; ++i) {
      const std::filesystem::path path = arguments[i];
      make(out, path.stem().string(), step::File::read(path.string()));
    }
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}

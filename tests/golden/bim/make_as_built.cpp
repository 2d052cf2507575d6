// make_as_built OUT FILE.ifc … : enriches design files with known deviations, and says in OUT/NAME.json what an
// independent reader must find.
#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "../../unit/bim/small_building.hpp"
#include "ifc/as_built_ifc.hpp"

namespace {

using namespace plumbline;
using Json = nlohmann::json;

bim::AsBuilt measurements(const bim::Design& design) {
  bim::AsBuilt as_built;
  double step = 0;
  for (const bim::Element& element : design.elements) {
    if (!element.is_anchor) continue;
    bim::AsBuiltAnchor anchor;
    anchor.id = element.guid;
    anchor.role = "check";
    // Floors by storey, so that every storey gets statistics.
    for (std::size_t i = 0; i < design.storeys.size(); ++i)
      if (design.storeys[i].guid == element.storey_guid) anchor.floor = static_cast<int>(i) + 1;
    anchor.position = element.position + Eigen::Vector3d(0.001, -0.002, 0.0001 * step);
    anchor.covariance = Eigen::Matrix3d::Identity() * 1e-8;
    anchor.survey = bim::SurveyResidual{{0, 0, 0.00005 * step}, 0.0001, bim::Verdict::pass, 1};
    as_built.anchors.push_back(anchor);
    ++step;
  }
  for (const bim::AsBuiltAnchor& anchor : as_built.anchors) {
    const bool known = std::any_of(as_built.floors.begin(), as_built.floors.end(),
                                   [&](const auto& f) { return f.floor == anchor.floor; });
    if (!known)
      as_built.floors.push_back({anchor.floor,
                                 "check",
                                 true,
                                 1,
                                 0.0001,
                                 0.0002,
                                 bim::Verdict::pass,
                                 0.0003,
                                 0.0004,
                                 {{0.002, 1}, {0.008, 1}}});
  }
  as_built.provenance = {{"Method", "test"}};
  return as_built;
}

Json box_of(const bim::Element& element) {
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
bool parallel(const bim::Element& element) {
  return (element.project_from_element.rotation.toRotationMatrix().cwiseAbs().array().round() -
          element.project_from_element.rotation.toRotationMatrix().cwiseAbs().array())
             .abs()
             .maxCoeff() < 1e-6;
}

void make(const std::filesystem::path& out, const std::string& name, const step::File& file) {
  const bim::Design design = bim::read_design(file, {{"IfcMechanicalFastener", "IfcWindow", "IfcPlate"}, "", {}, {}});
  const bim::AsBuilt as_built = measurements(design);
  const bim::AsBuiltIfc result = bim::write_as_built(file, design, as_built, {});
  std::ofstream(out / (name + ".design.ifc"), std::ios::binary) << file.bytes();
  std::ofstream(out / (name + ".as_built.ifc"), std::ios::binary) << result.bytes;
  Json expected{{"length_unit", design.length_unit},
                {"storeys", Json::array()},
                {"elements", Json::array()},
                {"anchors", Json::array()}};
  for (const bim::Storey& storey : design.storeys)
    expected["storeys"].push_back({{"guid", storey.guid}, {"name", storey.name}, {"height", storey.placement_height}});
  for (const bim::Element& element : design.elements)
    expected["elements"].push_back(
        {{"guid", element.guid},
         {"class", element.ifc_class},
         {"storey", element.storey_guid},
         {"placement", vector(element.project_from_element.translation)},
         {"axes",
          {vector(element.project_from_element.rotation * Eigen::Vector3d::UnitX()),
           vector(element.project_from_element.rotation * Eigen::Vector3d::UnitZ())}},
         {"box", element.rule == bim::ReferencePointRule::parts_centre ? Json() : box_of(element)},
         {"parallel", parallel(element)}});
  std::vector<std::string> unmatched;
  for (const bim::AnchorDeviation& anchor : bim::match_anchors(design, as_built, unmatched))
    expected["anchors"].push_back({{"guid", anchor.element->guid},
                                   {"deviation", {anchor.deviation.x(), anchor.deviation.y(), anchor.deviation.z()}},
                                   {"delta_z", anchor.measured->survey->difference.z()},
                                   {"verdict", bim::label_of(anchor.verdict)},
                                   {"floor", anchor.measured->floor}});
  std::ofstream(out / (name + ".json")) << expected.dump(1);
}

}  // namespace

int main(int count, char** arguments) {
  try {
    const std::filesystem::path out = arguments[1];
    std::filesystem::create_directories(out);
    for (const char* schema : {"IFC2X3", "IFC4", "IFC4X3"})
      make(out, std::string("small_") + schema, step::File(test::small_building(schema), schema));
    for (int i = 2; i < count; ++i) {
      const std::filesystem::path path = arguments[i];
      make(out, path.stem().string(), step::File::read(path.string()));
    }
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}

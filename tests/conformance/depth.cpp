// What every node of the role depth must do: points on the faces of a design
// with true standard deviations, random and common, holes where nothing can be known, and words where it cannot work.
// Nodes that take photographs get those of a simulated facade, nodes that take a file a scan of the same facade.
#include <cmath>
#include <map>
#include <random>
#include <sstream>

#include "artifacts/camera.hpp"
#include "artifacts/design.hpp"
#include "artifacts/file.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/image.hpp"
#include "artifacts/poses.hpp"
#include "artifacts/surface_points.hpp"
#include "cloud_bytes.hpp"
#include "node_harness.hpp"
#include "stopping.hpp"
#include "surface_artifact.hpp"

namespace depth_tests {

using namespace plumbline;
using namespace plumbline::test;

/// Two panels: plaster, and paint with nothing on it, which the scanner does not see either.
struct Facade {
  NodeHarness node{"simulate.facade"};
  DesignT design;
  PosesT poses;
  std::vector<double> truth;  ///< of the first panel: offset, tilts, bows [m, rad]
  TemporaryFolder folder;
  std::string scan;

  Facade() {
    const std::pair<const char*, const char*> settings[] = {
        {"columns", "2"},  {"rows", "1"},          {"plain", "1"},          {"photographs", "6"}, {"width", "760"},
        {"height", "520"}, {"panel_width", "0.5"}, {"panel_height", "0.4"}, {"distance", "3"}};
    for (const auto& [name, value] : settings) node.set(name, value);
    node.run();
    design = node.output<Design>("design"), poses = node.output<Poses>("poses");
    const FileT table = node.output<File>("truth");
    std::istringstream lines(std::string(table.content.begin(), table.content.end()));
    std::string line, word;
    std::getline(lines, line), std::getline(lines, line);
    std::istringstream words(line);
    std::getline(words, word, ','), std::getline(words, word, ',');
    while (std::getline(words, word, ',')) truth.push_back(1e-3 * std::stod(word));
    scan = (folder.path() / "scan.las").string();
    cloud_bytes::LasFile las;
    las.minor = 4, las.format = 6, las.scale = 1e-5, las.offset = design.elements[0]->placement.translation;
    std::ofstream(scan, std::ios::binary) << cloud_bytes::las_file(las, scanned());
  }
  double height(double x, double y) const {
    const double a = 2 * x / 0.5, b = 2 * y / 0.4;
    return truth[0] + truth[1] * x + truth[2] * y + truth[3] * (1 - a * a - 2.0 / 3) + truth[4] * (1 - b * b - 2.0 / 3);
  }
  std::vector<Eigen::Vector3d> scanned() const {
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal(0, 1);
    const double moved = 2e-4 * normal(random);
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 100; ++i)
      for (int j = 0; j < 80; ++j) {
        const double x = (i + 0.5) * 0.005 - 0.25, y = (j + 0.5) * 0.005 - 0.2;
        points.push_back(design.elements[0]->placement *
                         Eigen::Vector3d(x, y, height(x, y) + moved + 0.001 * normal(random)));
      }
    return points;
  }
};

const Facade& facade() {
  static const Facade made;
  return made;
}

class Depth : public testing::TestWithParam<std::string> {
 protected:
  static NodeHarness prepared(const DesignT* design, const PosesT& poses) {
    const Facade& site = facade();
    NodeHarness node(GetParam());
    if (node.has_input("images")) {
      for (size_t i = 0; i < site.node.output_count("images"); ++i)
        node.input<Image>("images", site.node.output<Image>("images", i));
      node.input<Poses>("poses", poses);
      node.input<Camera>("camera", site.node.output<Camera>("camera"));
    }
    if (node.has_parameter("file", "")) {
      node.set("file", site.scan);
      node.set("noise", "0.001"), node.set("place_sigma", "0.0002"), node.set("turn_sigma", "0.00001");
    }
    if (design) node.input<Design>("design", *design);
    return node;
  }
  static NodeHarness ran() {
    NodeHarness node = prepared(&facade().design, facade().poses);
    node.run();
    return node;
  }
  static std::vector<StatedPoint> points_of(const NodeHarness& node) {
    return stated_points(node.output<SurfacePoints>("surface"), node.output<Folder>("files").uri);
  }
  static std::string refusal(NodeHarness node) {
    try {
      node.run();
    } catch (const NodeFailed& error) {
      return error.what();
    }
    return "";
  }
};

TEST_P(Depth, PointsLieWithinWhatIsStatedOfThem) {
  const NodeHarness node = ran();
  const RigidTransform& placement = facade().design.elements[0]->placement;
  const Eigen::Vector3d out = placement.rotation * Eigen::Vector3d::UnitZ();
  double random = 0, mean = 0;
  Eigen::RowVectorXd common;
  std::vector<double> errors, sigmas;
  for (const StatedPoint& point : points_of(node)) {
    const Eigen::Vector3d local = placement.inverse() * point.place;
    if (std::abs(local.x()) > 0.23 || std::abs(local.y()) > 0.18) continue;  // away from the borders
    errors.push_back(local.z() - facade().height(local.x(), local.y())), sigmas.push_back(point.sigma);
    mean += errors.back();
    const Eigen::RowVectorXd by = out.transpose() * point.by_common_errors;
    common = common.size() == 0 ? by : Eigen::RowVectorXd(common + by);
  }
  ASSERT_GT(errors.size(), 100U);
  const double count = static_cast<double>(errors.size());
  mean /= count;
  for (size_t i = 0; i < errors.size(); ++i) random += std::pow((errors[i] - mean) / sigmas[i], 2) / count;
  EXPECT_GT(random, 0.5) << "the random parts are stated too large";
  EXPECT_LT(random, 1.7) << "the random parts are stated too small";
  ASSERT_GT(common.size(), 0) << "nothing is stated of what all points have in common";
  const double systematic = (common / count).norm();
  EXPECT_GT(systematic, 2e-5) << "the orientations, or the scan's place, are not known that well";
  EXPECT_LT(std::abs(mean), 4 * systematic + 1e-5);
}

TEST_P(Depth, NothingIsInventedWhereNothingCanBeSeen) {
  const RigidTransform& plain = facade().design.elements[1]->placement;
  size_t on_plain = 0, all = 0;
  for (const StatedPoint& point : points_of(ran())) {
    const Eigen::Vector3d local = plain.inverse() * point.place;
    ++all, on_plain += std::abs(local.x()) < 0.2 && std::abs(local.y()) < 0.15;
  }
  EXPECT_GT(all, 100U);
  EXPECT_LE(on_plain, all / 50);
}

TEST_P(Depth, GivesTheSameBitsTwiceAndNamesTheFaces) {
  const NodeHarness a = ran(), b = ran();
  EXPECT_EQ(a.output_bytes("surface"), b.output_bytes("surface"));
  const auto surface = a.output<SurfacePoints>("surface");
  ASSERT_EQ(surface.faces.size(), 2U);
  EXPECT_EQ(surface.faces[0]->id, facade().design.elements[0]->name);
  EXPECT_EQ(surface.faces[0]->guid, facade().design.elements[0]->guid);
  EXPECT_TRUE(surface.source == "photographs" || surface.source == "scan") << surface.source;
}

TEST_P(Depth, ADesignThreeMetresOffHasNoPoints) {
  DesignT off = facade().design;
  for (auto& element : off.elements)
    element->placement.translation += 3 * (element->placement.rotation * Eigen::Vector3d::UnitZ());
  NodeHarness node = prepared(&off, facade().poses);
  try {
    node.run();
  } catch (const NodeFailed& error) {
    EXPECT_NE(std::string(error.what()).find("frame"), std::string::npos) << error.what();
    return;
  }
  EXPECT_LT(points_of(node).size(), 20U);
}

TEST_P(Depth, WithoutFacesOrCovarianceItSaysWhatToConnect) {
  EXPECT_NE(refusal(prepared(nullptr, facade().poses)).find("design"), std::string::npos);
  DesignT bare = facade().design;
  for (auto& element : bare.elements) element->is_panel = false;
  EXPECT_NE(refusal(prepared(&bare, facade().poses)).find("panel"), std::string::npos);
  NodeHarness node = prepared(&facade().design, facade().poses);
  if (node.has_parameter("file", "")) return;  // a scan needs none
  PosesT without = facade().poses;
  without.joint_covariance.clear();
  EXPECT_NE(refusal(prepared(&facade().design, without)).find("joint_orientations"), std::string::npos);
}

TEST_P(Depth, StopsWhereverItAsks) {
  EXPECT_EQ(stopping_at_fault([] { return prepared(&facade().design, facade().poses); }), "");
}

INSTANTIATE_TEST_SUITE_P(Kinds, Depth, testing::ValuesIn(kinds_of_role("depth")), test_name);

}  // namespace depth_tests

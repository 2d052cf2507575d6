// F. Krumm's Geodetic Network Adjustment Examples (61 networks of textbooks, with the adjusted coordinates of 44) as
// GNU Gama distributes them in tests/krumm/input; not committed: $PLUMBLINE_TEST_DATA/survey/krumm/{1D,2D,3D}.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "base/text/text.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "survey/files/krumm.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_krumm_collection {

namespace fs = std::filesystem;

constexpr const char* kCollection = "survey/krumm/1D";
constexpr double kPrinted = 1.1e-4;  // [m]: four decimals, of an adjustment that stopped at about that

/// What the reader passes over, in words: angles in an inclined plane.
const std::set<std::string> kInPart = {"Wolf_PosAngle_and_Dist"};

/// Results that are not those of the file beside them, and why.
const std::map<std::string, std::string> kOtherResult = {};

std::vector<fs::path> networks() {
  std::vector<fs::path> files;
  for (const char* part : {"1D", "2D", "3D"})
    for (const auto& entry : fs::directory_iterator(test::data_file(std::string("survey/krumm/") + part)))
      if (entry.path().extension() == ".dat") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// Rows "name x dx sx y dy sy ..." of an .adj file; the minus sign may be U+2212.
std::map<std::string, std::vector<double>> adjusted(const fs::path& file) {
  std::map<std::string, std::vector<double>> rows;
  std::string text = test::read_file(file);
  for (size_t at; (at = text.find("\xE2\x88\x92")) != std::string::npos;) text.replace(at, 3, "-");
  for (const auto& line : text::split_lines(text)) {
    const auto parts = text::split_blanks(line.text);
    if (parts.size() < 4 || parts[0].front() == '#' || parts[0].front() == '<') continue;
    std::vector<double> values;
    for (size_t i = 1; i < parts.size(); ++i)
      if (const auto value = text::parse_number(parts[i])) values.push_back(*value);
    if (values.size() + 1 == parts.size()) rows[std::string(parts[0])] = values;
  }
  return rows;
}

TEST(KrummCollection, IsReadWithoutASkippedLine) {
  PLUMBLINE_REQUIRE_DATA(kCollection);
  for (const fs::path& file : networks()) {
    SCOPED_TRACE(file.filename().string());
    const SurveyObservations survey = read_krumm(test::read_file(file), file.filename().string());
    if (kInPart.contains(file.stem().string())) {
      EXPECT_FALSE(survey.skipped.empty());
      continue;
    }
    for (const SkippedLine& s : survey.skipped)
      ADD_FAILURE() << place(s.source) << ": found " << s.found << ", expected " << s.expected;
  }
}

TEST(KrummCollection, AgreesWithItsAdjustedCoordinates) {
  PLUMBLINE_REQUIRE_DATA(kCollection);
  int compared = 0;
  double largest = 0;
  for (const fs::path& file : networks()) {
    SCOPED_TRACE(file.filename().string());
    fs::path result = file;
    result.replace_extension(".adj");
    const std::string name = file.stem().string();
    if (!fs::exists(result) || kInPart.contains(name) || kOtherResult.contains(name)) continue;
    const auto expected = adjusted(result);
    if (expected.empty()) continue;
    NetworkResult network;
    try {
      network = adjust_network(read_krumm(test::read_file(file), name), {});
    } catch (const NetworkError& error) {
      ADD_FAILURE() << error.what();
      continue;
    }
    double worst = 0;
    size_t found = 0;
    for (const ResultPoint& p : network.points) {
      const auto row = expected.find(p.id);
      if (row == expected.end()) continue;
      ++found;
      // Three numbers an axis: coordinate, its correction, its standard deviation; heights alone have one axis.
      const bool heights = name.find("Height") != std::string::npos;
      for (int axis = 0; axis < 3; ++axis) {
        const size_t at = heights ? 0 : static_cast<size_t>(3 * axis);
        if ((heights && axis < 2) || at >= row->second.size() || p.roles[axis] == CoordinateRole::unused) continue;
        worst = std::max(worst, std::abs(p.position[axis] - row->second[at]));
      }
    }
    EXPECT_GT(found, 0u);
    EXPECT_LT(worst, kPrinted);
    largest = std::max(largest, worst);
    ++compared;
    std::printf("%-40s %2zu points, largest difference %.6f m, sigma0 %.3f\n", name.c_str(), found, worst,
                network.sigma0);
  }
  std::printf("%d networks compared, largest difference %.6f m\n", compared, largest);
  EXPECT_GE(compared, 38);
}

/// Networks in latitude and longitude have no result beside them. One of them states its sigma0 (0.6611, in [Sigma0]):
/// taken on the ellipsoid in place of the plane it would be 0.6564.
TEST(KrummCollection, LeicksNetworksComeOutWithTheirSigma0) {
  const std::map<std::string, std::pair<double, int>> expected = {
      {"Leick53", {0.6282, 4}}, {"Leick54", {0.6282, 4}}, {"Leick55", {0.6613, 21}}, {"Leick56", {0.6461, 22}}};
  for (const auto& [name, result] : expected) {
    const std::string file = "survey/krumm/2D/" + name + ".dat";
    PLUMBLINE_REQUIRE_DATA(file);
    const NetworkResult r = adjust_network(read_krumm(test::read_file(test::data_file(file)), name), {});
    EXPECT_NEAR(r.sigma0, result.first, 1e-4) << name;
    EXPECT_EQ(r.degrees_of_freedom, result.second) << name;
    if (name != "Leick55") continue;
    // Of a least squares solution of its own.
    EXPECT_LT((r.point("Trav-14").position.head<2>() - Eigen::Vector2d(18303.3154, 4963703.3497)).norm(), 1.5e-4);
    EXPECT_LT((r.point("Chemo").position.head<2>() - Eigen::Vector2d(33925.5241, 4961461.8039)).norm(), 1.5e-4);
    EXPECT_LT((r.sigma(r.point("Otter")).head<2>() - Eigen::Vector2d(1.8328, 11.0467)).norm(), 2e-3);
  }
}

}  // namespace test_krumm_collection
}  // namespace plumbline::survey

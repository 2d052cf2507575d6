// A PhotoModeler export with four control points against the reports of DBAT (Damped Bundle Adjustment Toolbox 0.9.2):
// σ0, counts, every orientation with its standard deviations, object points as printed.
#include <gtest/gtest.h>

#include <map>
#include <sstream>

#include "photo/block/image_block_folder.hpp"
#include "test_support.hpp"

namespace test_photomodeler {

using namespace plumbline;

struct Report {
  double sigma0 = 0;
  int redundancy = 0, parameters = 0, observations = 0;
  struct Value {
    double value = 0, sigma = 0;
  };
  std::vector<std::map<std::string, Value>> photos;     ///< Omega, Phi, Kappa [°], Xc, Yc, Zc [m]
  std::map<int, std::array<double, 3>> control_sigmas;  ///< posterior
};

Report read_report(const std::filesystem::path& file) {
  std::istringstream lines(test::read_file(file));
  Report report;
  std::string line, name, section;
  const auto number_behind = [&](const char* key) {
    return std::stod(line.substr(line.find(key) + std::string(key).size()));
  };
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    std::string first;
    words >> first;
    if (first == "Sigma0:") report.sigma0 = number_behind("Sigma0:");
    if (first == "Redundancy") report.redundancy = static_cast<int>(number_behind("Redundancy"));
    if (line.find("Number of params:") != std::string::npos)
      report.parameters = static_cast<int>(number_behind("params:"));
    if (line.find("Number of observations:") != std::string::npos)
      report.observations = static_cast<int>(number_behind("observations:"));
    if (first == "Photo" && line.find(": ") != std::string::npos) report.photos.emplace_back();
    if (first == "Posterior" || first == "Prior" || first == "Diff") section = first;
    if (!first.empty() && first.back() == ':') {
      const std::string key = first.substr(0, first.size() - 1);
      if (key == "Value" && !report.photos.empty()) report.photos.back()[name].value = number_behind("Value:");
      if (key == "Deviation" && !report.photos.empty()) report.photos.back()[name].sigma = number_behind("Deviation:");
      if (key != "Value" && key != "Deviation") name = key;
    }
    if (section == "Posterior" && first.size() > 1 && std::isdigit(first[0]) && first.back() == ',') {
      for (char& c : line)
        if (c == ',') c = ' ';
      std::istringstream row(line);
      int id = 0;
      double x = 0, y = 0, z = 0;
      std::array<double, 3> sigma{};
      row >> id >> x >> y >> z >> sigma[0] >> sigma[1] >> sigma[2];
      report.control_sigmas[id] = sigma;
    }
    if (line.find("Quality") != std::string::npos) name.clear();
  }
  return report;
}

class PhotoModelerBlock : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Projects, PhotoModelerBlock,
                         testing::Values("fixed-no-orient", "fixed-with-orient", "weighted-no-orient",
                                         "weighted-with-orient"),
                         [](const auto& project) {
                           std::string name = project.param;
                           std::erase(name, '-');
                           return name;
                         });

TEST_P(PhotoModelerBlock, AgreesWithItsReport) {
  const std::string folder = "blocks/photomodeler_cam/", project = GetParam();
  PLUMBLINE_REQUIRE_DATA("blocks/photomodeler_cam/ref/ctrlpts-fixed.txt");
  const Report report = read_report(test::data_file(folder + "dbatexports/" + project + "-dbatreport.txt"));
  ASSERT_EQ(report.photos.size(), 21u);
  const std::string control = project.substr(0, project.find('-'));
  const block::ReadBlock read = block::read_image_block(
      test::data_file(folder), project, test::data_file(folder + "ref/ctrlpts-" + control + ".txt").string(), {});
  block::PointBlockOptions options;
  options.image_sigma = read.block.measurements[0].sigma;
  const block::PointBlockResult result = block::adjust_point_block(read.block, options);
  EXPECT_EQ(result.observations, report.observations);
  EXPECT_EQ(result.unknowns, report.parameters);
  EXPECT_EQ(result.degrees_of_freedom, report.redundancy);
  EXPECT_NEAR(result.sigma0 / options.image_sigma / report.sigma0, 1, 1e-4);
  // The report's coordinates are shifted: its control was moved by the mean offset to the export's.
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < 21; ++i) {
    const auto& photo = report.photos[i];
    shift += (result.block.images[i].centre -
              Eigen::Vector3d(photo.at("Xc").value, photo.at("Yc").value, photo.at("Zc").value)) /
             21;
  }
  const double degree = M_PI / 180;
  for (size_t i = 0; i < 21; ++i) {
    const auto& photo = report.photos[i];
    const auto& image = result.block.images[i];
    const Eigen::VectorXd sigma = result.orientation_covariance[i].diagonal().cwiseSqrt();
    const char* names[] = {"Xc", "Yc", "Zc", "Omega", "Phi", "Kappa"};
    for (int k = 0; k < 6; ++k) {
      const auto& reported = photo.at(names[k]);
      const double unit = k < 3 ? 1 : degree;
      const double printed = 0.5 * std::pow(10, std::floor(std::log10(reported.sigma)) - 2);  // three digits
      EXPECT_NEAR(sigma(k) / unit, reported.sigma, 0.001 * reported.sigma + printed) << i << " " << names[k];
      const double value = k < 3 ? image.centre(k) - shift(k) : image.angles(k - 3) / degree;
      EXPECT_NEAR(k < 3 ? value - reported.value : std::remainder(value - reported.value, 360.0), 0,
                  0.002 * reported.sigma + 2e-6)
          << i << " " << names[k];
    }
  }
  for (const auto& entry : result.control) {
    const auto& sigma = report.control_sigmas.at(std::stoi(result.block.points[entry.point].name));
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(std::sqrt(result.point_covariances[entry.point](k, k)), sigma[k], 0.001 * sigma[k] + 0.5e-5);
  }
}

}  // namespace test_photomodeler

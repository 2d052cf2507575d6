// `plumbline run survey_network` on gama-local files, as their user meets it: coordinates and standard deviations in
// network.json are compared with the stored result as they stand, in the axes of the file.
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "gama_result.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_network_json {

using Json = nlohmann::json;

/// network.json of the pipeline, run with a store of its own.
Json run_pipeline(const std::filesystem::path& file) {
  const test::TemporaryFolder folder;
  const std::string out = folder.path() / "out";
  const std::string command = "PLUMBLINE_STORE='" + (folder.path() / "store").string() +
                              "' '" PLUMBLINE_PROGRAM "' run '" + std::string(plumbline::test::source_dir()) +
                              "/pipelines/survey_network.yaml' 'file=" + file.string() + "' --out '" + out + "' > '" +
                              (folder.path() / "log").string() + "' 2>&1";
  // One network has a common error that is no accident, and ends with 3 for it; its numbers are there all the same.
  const int status = std::system(command.c_str());
  if (!WIFEXITED(status) || (WEXITSTATUS(status) != 0 && WEXITSTATUS(status) != 3))
    throw std::runtime_error(test::read_file(folder.path() / "log"));
  return Json::parse(test::read_file(out + "/network.json"));
}

double number(const Json& value) { return value.is_number() ? value.get<double>() : kNotGiven; }

class NetworkJson : public testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(NetworkJson, HasTheCoordinatesOfTheFile) {
  const auto& [name, axes] = GetParam();
  const std::string base = std::string("survey/gama/") + name;
  PLUMBLINE_REQUIRE_DATA(base + ".gkf");
  const Json network = run_pipeline(test::data_file(base + ".gkf"));
  const GamaResult gama = read_result(test::data_file(base + ".xml"));

  EXPECT_EQ(network.at("axes"), axes);
  EXPECT_EQ(network.at("statistics").at("degrees_of_freedom"), gama.degrees_of_freedom);
  std::map<std::string, Json> points;
  for (const Json& p : network.at("points")) points[p.at("id")] = p;
  for (size_t i = 0; i < gama.order.size(); ++i) {
    const auto& [id, axis] = gama.order[i];
    const GamaPoint& expected = gama.points.at(id);
    const size_t k = static_cast<size_t>(axis - 'x');
    const double coordinate = k == 0 ? expected.x : k == 1 ? expected.y : expected.z;
    const double sigma = 1e-3 * std::sqrt(gama.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)));
    EXPECT_NEAR(number(points.at(id).at("position").at(k)), coordinate, 5e-7) << id << axis;
    EXPECT_NEAR(number(points.at(id).at("sigma").at(k)), sigma, 1e-3 * sigma + 1e-12) << id << axis;
  }
}

INSTANTIATE_TEST_SUITE_P(Survey, NetworkJson,
                         testing::Values(std::pair{"2020-barta-phase_0-1TK", "sw"},
                                         std::pair{"2020-barta-phase_1-2TK", "sw"}, std::pair{"local_3d", "sw"},
                                         std::pair{"from-to-dh", "en"}, std::pair{"Baumann23_3_4_fix", "en"}),
                         [](const auto& network) {
                           std::string text = network.param.first;
                           for (char& c : text)
                             if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
                           return text;
                         });

}  // namespace test_network_json
}  // namespace plumbline::survey

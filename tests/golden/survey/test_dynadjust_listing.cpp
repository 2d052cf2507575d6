// A network of DynAdjust beside the file that it adjusted (sampleData of icsm-au/DynAdjust, gnss-network*.xml and
// gnss.simult.adj.expected of version 1.0.3): 43 stations, 417 components of baselines, clusters and points.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "survey/adjust/adjust_network.hpp"
#include "survey/files/dynaml.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_dynadjust_listing {

const char* const kStations = "survey/dynadjust/gnss-networkstn.xml";
const char* const kMeasurements = "survey/dynadjust/gnss-networkmsr.xml";
const char* const kListing = "survey/dynadjust/gnss.simult.adj.expected";

/// Stations and measurements in one file, as DynaML has them, too.
std::string combined() {
  const std::string stations = test::read_file(test::data_file(kStations));
  std::string all = test::read_file(test::data_file(kMeasurements));
  const std::string first = "<DnaStation>", last = "</DnaStation>";
  const size_t from = stations.find(first), to = stations.rfind(last) + last.size();
  all.insert(all.find("<DnaMeasurement>"), stations.substr(from, to - from) + "\n");
  return all;
}

struct Station {
  double height = 0;      ///< above the ellipsoid [m]
  Eigen::Vector3d sigma;  ///< e, n, up [m]
};

/// "211300470 FFF latitude longitude H h X Y Z SD(e) SD(n) SD(up) description".
std::map<std::string, Station> listed() {
  std::istringstream listing(test::read_file(test::data_file(kListing)));
  std::map<std::string, Station> stations;
  bool inside = false;
  for (std::string line; std::getline(listing, line);) {
    if (line.starts_with("Adjusted Coordinates")) inside = true;
    std::istringstream words(line);
    std::string name, held;
    double v[10] = {};
    if (!inside || !(words >> name >> held) || held.size() != 3) continue;
    for (double& value : v) words >> value;
    if (words) stations[name] = {v[3], {v[7], v[8], v[9]}};
  }
  return stations;
}

TEST(DynAdjustListing, GnssNetworkOfFortyThreeStations) {
  PLUMBLINE_REQUIRE_DATA(kStations);
  PLUMBLINE_REQUIRE_DATA(kMeasurements);
  PLUMBLINE_REQUIRE_DATA(kListing);
  const SurveyObservations survey = read_dynaml(combined(), "gnss.xml");
  EXPECT_TRUE(survey.skipped.empty());
  AdjustOptions options;
  options.geoid.slope_sigma = 0;
  const NetworkResult r = adjust_network(survey, options);
  EXPECT_EQ(r.degrees_of_freedom, 288);
  EXPECT_NEAR(r.sum_of_squares, 336.64, 1.5);
  const std::map<std::string, Station> stations = listed();
  ASSERT_EQ(stations.size(), 43u);
  for (const auto& [id, station] : stations) {
    const ResultPoint& p = r.point(id);
    EXPECT_LT(std::abs(p.position.z() - station.height), 1.2e-3) << id;
    for (int k = 0; k < 3; ++k) EXPECT_LT(std::abs(r.sigma(p)[k] - station.sigma[k]), 6e-5) << id;  // as printed
  }
}

}  // namespace test_dynadjust_listing
}  // namespace plumbline::survey

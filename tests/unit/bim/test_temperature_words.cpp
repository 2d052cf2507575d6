// What 10 K do to a building is told with the number of its own height and width, and not where it drowns.
#include <gtest/gtest.h>

#include <cmath>

#include "building/ifc/temperature_words.hpp"

namespace plumbline::ifc {
namespace test_temperature_words {

const double unknown = std::nan("");

TEST(TemperatureWords, SayWhatTenKelvinDoToThisHeightAndWidth) {
  // 30 m askew in plan, 60 m high.
  const std::vector<Eigen::Vector3d> tower = {{100, 200, 10}, {118, 224, 10}, {100, 200, 70}, {118, 224, 70}};
  EXPECT_EQ(
      temperature_words(tower, 0.005, {0.0004, 0.0005, 0.0003}),
      "The model knows no temperature: 10 K make the 60.0 m of height between these anchors 6.0 mm longer or "
      "shorter, and their 30.0 m of width 3.0 mm (concrete, 1e-5 a kelvin by EN 1991-1-5); the smallest tolerance "
      "is 5.0 mm; the median standard deviation of a height is 0.40 mm");
  EXPECT_NE(temperature_words(tower, unknown, {0.0004}), "") << "beside what a height is stated to";
  EXPECT_EQ(temperature_words(tower, unknown, {unknown}), "");
  EXPECT_EQ(temperature_words({}, 0.005, {0.0004}), "");
}

TEST(TemperatureWords, AreSilentWhereItDrowns) {
  const std::vector<Eigen::Vector3d> house = {{0, 0, 0}, {5, 0, 0}, {0, 0, 9.9}};
  EXPECT_EQ(temperature_words(house, 0.005, {0.0005}), "") << "0.99 mm: less than a fifth, and than 2 x 0.5 mm";
  EXPECT_NE(temperature_words(house, 0.0049, {0.0005}), "");
  EXPECT_NE(temperature_words(house, 0.005, {0.0004}), "");
}

TEST(TemperatureWords, TakeWhatWasMeasuredAndTheSmallestTolerance) {
  DeviationT deviation;
  for (const double height : {0.0, 60.0, 900.0}) {
    auto anchor = std::make_unique<AnchorDeviationT>();
    anchor->design = {0, 0, height};
    anchor->deviation.setConstant(height < 100 ? 0.001 : unknown);
    anchor->covariance = {1e-6, 0, 0, 0, 1e-6, 0, 0, 0, 9e-8};
    for (const double tolerance : {unknown, 0.008, 0.004}) {
      anchor->axes.push_back(std::make_unique<JudgedAxisT>());
      anchor->axes.back()->tolerance = tolerance;
    }
    deviation.anchors.push_back(std::move(anchor));
  }
  const std::string words = temperature_words(deviation);
  EXPECT_NE(words.find("the 60.0 m of height"), std::string::npos) << words;
  EXPECT_NE(words.find("the smallest tolerance is 4.0 mm"), std::string::npos) << words;
  EXPECT_NE(words.find("of a height is 0.30 mm"), std::string::npos) << words;
}

}  // namespace test_temperature_words
}  // namespace plumbline::ifc

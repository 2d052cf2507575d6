// The survey against the design: what explains a gap, in words; readings of a map conversion; the fit.
#include <gtest/gtest.h>

#include "building/ifc/georeference.hpp"

namespace plumbline::ifc {
namespace test_georeference {

/// A facade of 12 anchors; the survey in map coordinates by the standard's conversion, a few millimetres off.
struct Site {
  MapConversion map{691000.5, 5335000.25, 520.3, std::cos(0.4), std::sin(0.4), 1, true, "EPSG:25832", 1};
  CommonPoints points;

  Site() {
    const PlanTransform t{0.4, 1, {691000.5, 5335000.25, 520.3}};
    for (int i = 0; i < 12; ++i) {
      points.ids.push_back("A" + std::to_string(i));
      points.design.push_back({2.0 * (i % 4), 0.1 * (i % 3), 3.0 * (i / 4)});
      points.survey.push_back(survey_from_design(t, points.design.back()) +
                              Eigen::Vector3d(0.003 * (i % 2), -0.002, 0.001 * (i % 3)));
    }
  }
  std::string words() const { return explain_gap(points, readings_of(map, 0.001), "tower.ifc"); }
};

TEST(Gap, IsExplainedByTheMapConversionInTheSurveysWords) {
  const std::string words = Site().words();
  EXPECT_NE(words.find("the survey is 5380 km from tower.ifc"), std::string::npos) << words;
  EXPECT_NE(words.find("its map conversion would explain it to 4 mm: frames.with.use=map_conversion"),
            std::string::npos)
      << words;
}

TEST(Gap, FaultyConversionsAreNamedByTheReadingThatFits) {
  Site site;
  site.map.eastings *= 1000, site.map.northings *= 1000,
      site.map.orthogonal_height *= 1000;  // Revit <= 2020: project unit
  site.map.scale = 1000;
  EXPECT_NE(site.words().find("frames.with.use=map_conversion_in_project_units"), std::string::npos) << site.words();
  site = Site();
  site.map.map_unit = 0.001;
  EXPECT_NE(site.words().find("frames.with.use=map_conversion_in_metres"), std::string::npos) << site.words();
  site = Site();
  site.map.x_axis_ordinate = -site.map.x_axis_ordinate;
  EXPECT_NE(site.words().find("frames.with.use=map_conversion_turned_back"), std::string::npos) << site.words();
}

TEST(Gap, AReadingInAnotherUnitKeepsTheGridScale) {
  MapConversion map;
  map.eastings = 691000.5, map.northings = 5335000.25;
  map.scale = 0.9996e-3, map.scale_given = true;  // for metres, and no unit of the map says so
  for (const Reading& reading : readings_of(map, 0.001))
    if (reading.use == "map_conversion_in_metres") {
      EXPECT_DOUBLE_EQ(reading.transform.scale, 0.9996);
      return;
    }
  FAIL() << "no such reading";
}

TEST(Gap, SiteGridsSwappedAxesAndFeetAreNamed) {
  Site site;
  site.map.eastings += 12;  // not this building's
  EXPECT_NE(site.words().find("a shift and a turn about the vertical would explain it to 2 mm"), std::string::npos)
      << site.words();
  EXPECT_NE(site.words().find("the design's map conversion does not explain it"), std::string::npos);
  Site feet;
  for (auto& p : feet.points.survey) p /= 0.3048;
  EXPECT_NE(feet.words().find("with the survey in feet"), std::string::npos) << feet.words();
  Site swapped;
  for (auto& p : swapped.points.survey) std::swap(p.x(), p.y());
  EXPECT_NE(swapped.words().find("with east and north swapped in the survey"), std::string::npos) << swapped.words();
}

TEST(Gap, ADesignInMillimetresThatItsFileCallsMetresIsNamed) {
  Site site;
  for (auto& p : site.points.design) p *= 1000;  // as the file is read: 1 mm as 1 m
  EXPECT_NE(site.words().find("if the numbers of the design are millimetres, it fits after a shift and a turn"),
            std::string::npos)
      << site.words();
  for (std::size_t i = 0; i < site.points.ids.size(); ++i) site.points.survey[i] = 0.001 * site.points.design[i];
  EXPECT_NE(
      site.words().find("if the numbers of the design are millimetres, it fits: the file declares another length"),
      std::string::npos)
      << site.words();
}

/// Which of the two is wrong the numbers do not say.
TEST(Gap, ADesignInMetresThatItsFileCallsMillimetresIsNamedBesideASurveyInMillimetres) {
  Site site;
  for (std::size_t i = 0; i < site.points.ids.size(); ++i) site.points.design[i] = 0.001 * site.points.survey[i];
  EXPECT_NE(site.words().find("mend the survey's files, or the unit of the design"), std::string::npos) << site.words();
}

TEST(Gap, WhatNothingExplainsSaysSo) {
  Site site;
  for (std::size_t i = 0; i < 12; ++i) site.points.survey[i].x() += static_cast<double>(i * i);
  EXPECT_NE(site.words().find("check whether the names in the plate table mean the same anchors"), std::string::npos)
      << site.words();
  for (std::size_t i = 0; i < 12; ++i) site.points.survey[i] = site.points.design[i] + Eigen::Vector3d(0.02, 0, 0);
  EXPECT_EQ(site.words(), "");
}

TEST(Fit, FindsShiftAndTurnWithTheirUncertainty) {
  const Site site;
  Eigen::Matrix4d covariance;
  const PlanTransform t = fit_plan(site.points, covariance);
  EXPECT_NEAR(t.angle, 0.4, 1e-3);
  EXPECT_LT(misfit(site.points, t), 0.004);
  EXPECT_NEAR((design_from_survey(t, survey_from_design(t, {1, 2, 3})) - Eigen::Vector3d(1, 2, 3)).norm(), 0, 1e-9);
  EXPECT_GT(covariance(0, 0), 0);
  CommonPoints column = site.points;
  for (auto& p : column.design) p.x() = p.y() = 0;
  EXPECT_THROW(fit_plan(column, covariance), std::runtime_error);
  column.ids.resize(2);
  EXPECT_THROW(fit_plan(column, covariance), std::runtime_error);
}

}  // namespace test_georeference
}  // namespace plumbline::ifc

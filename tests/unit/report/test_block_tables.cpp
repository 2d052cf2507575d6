// The page of an image block: every cell of its tables is the figure of its heading.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "page_tables.hpp"
#include "show/report/image_block_page.hpp"
#include "show/report/markup.hpp"

namespace plumbline::report {
namespace test_block_tables {

using namespace page_tables;
using Json = nlohmann::ordered_json;
using testing::HasSubstr;
using testing::Not;

Json block() {
  return Json::parse(R"({"datum": "control", "warnings": [], "left_out": ["tag 9: seen once"],
    "statistics": {"rms_px": 0.2468, "sigma0": 1.2344, "degrees_of_freedom": 321, "observations": 456, "unknowns": 135},
    "groups": [{"name": "image coordinates", "observations": 400, "redundancy": 290.25, "variance_factor": 2.25},
               {"name": "control", "observations": 6, "redundancy": 0.5, "variance_factor": 9}],
    "cameras": [{"id": "left", "width": 4000, "height": 3000, "images": 2, "rms_px": 0.2345, "pixel_pitch_um": 4,
                 "source": "self-calibrated",
                 "interior_orientation": [
                   {"name": "fx", "value": 3456.789, "sigma": 0.34, "estimated": true},
                   {"name": "k1", "value": -0.012345678, "sigma": 0.000056, "estimated": true, "unit": "1"},
                   {"name": "A2", "value": 1.25e-9, "sigma": 2.5e-11, "estimated": true, "unit": "mm^-4"},
                   {"name": "cy", "value": 1500, "sigma": 0, "estimated": false}],
                 "corner_inset": 0.1234, "corner_inset_sigma": 0.021,
                 "correlations": [{"of": "fx", "with": "cx", "correlation": 0.9512},
                                  {"of": "fx", "with": "k1", "correlation": -0.949},
                                  {"of": "k1", "with": "k2", "correlation": -0.987}]}],
    "images": [{"path": "a.jpg", "camera": "left", "oriented": true, "tags": 7, "rms_px": 0.1357, "coverage": 0.375,
                "centre": [1.23456, -2.34567, 3.45678], "sigma": [0.0003, 0.0004, 0.0012], "reason": "",
                "interior_correlation": 0.2},
               {"path": "b.jpg", "camera": "left", "oriented": true, "tags": 4, "rms_px": 0.4, "coverage": 0.25,
                "centre": [1, 2, 3], "sigma": [0.001, 0.001, 0.001], "reason": "few points",
                "interior_correlation": -0.97},
               {"path": "c.jpg", "camera": "left", "oriented": false, "reason": "no plate in it"}],
    "points": [{"id": "P1", "rays": 2, "largest_angle_deg": 34.6, "position": [1.234567, -2, 3],
                "sigma": [0.00012, 0.00034, 0.00056], "size_ratio": 1.00025, "size_ratio_sigma": 0.0001},
               {"id": "K1", "rays": 1, "largest_angle_deg": 12.4, "position": [4, 5, 6], "role": "control",
                "sigma": [0.001, 0.002, 0.003], "size_ratio": 0.9995, "size_ratio_sigma": 0,
                "surveyed": [4, 5, 6], "surveyed_sigma": [0.0005, 0.0006, 0.0007],
                "difference": [0.00111, -0.00222, 0.00333], "w": [1.1, -3.4, 2.2], "rms_px": 0.31, "contradicts": true},
               {"id": "C1", "rays": 2, "largest_angle_deg": 20, "position": [7, 8, 9], "role": "check",
                "sigma": [0.001, 0.001, 0.001], "surveyed": [7, 8, 9], "surveyed_sigma": [0.0005, 0.0005, 0.0005],
                "difference": [0.003, 0.001, -0.002], "w": [0, 0, 0], "rms_px": 0.2},
               {"id": "C2", "rays": 2, "largest_angle_deg": 20, "position": [7, 8, 9], "role": "check",
                "sigma": [0.001, 0.001, 0.001], "surveyed": [7, 8, 9], "surveyed_sigma": [0.0005, 0.0005, 0.0005],
                "difference": [-0.001, 0.003, 0.004], "w": [1, 2, 1.5], "rms_px": 0.2}],
    "check_points": {"holds": true, "degrees_of_freedom": 6, "nees": 7.26, "limit": 12.59, "words": ["a word"]},
    "observations": [{"image": "a.jpg", "point": "P1", "rms_px": 0.2}, {"image": "b.jpg", "point": "K1", "rms_px": 0.5},
                     {"image": "a.jpg", "point": "C1", "rms_px": 0.1, "control": true, "largest_w": 2.26}],
    "rejected": [{"image": "b.jpg", "point": "P1", "reason": "40 px off"}]})");
}

std::string page_of(const Json& json) {
  Markup html;
  write_image_block(html, json, "Block", "", {});
  return html.str();
}

TEST(BlockTables, ParametersOfACameraHaveTheDigitsOfTheirSigmas) {
  const std::string page = page_of(block());
  const auto rows = rows_behind(page, "id=\"cameras\"");
  ASSERT_EQ(rows.size(), 5u);
  const std::vector<std::array<std::string, 4>> expected = {{"fx", "3456.79", "0.34", "px"},
                                                            {"k1", "-0.012346", "0.000056", "1"},
                                                            {"A2", "1.25e-09", "2.5e-11", "mm^-4"},
                                                            {"cy", "1500.000000", "held", "px"},
                                                            {"corner inset", "0.123", "0.021", "px"}};
  for (size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].at("Parameter"), expected[i][0]);
    EXPECT_EQ(rows[i].at("Value"), expected[i][1]);
    EXPECT_EQ(rows[i].at("Sigma"), expected[i][2]);
    EXPECT_EQ(rows[i].at("Unit"), expected[i][3]);
  }
  EXPECT_THAT(bare(page), HasSubstr("4000 × 3000 px, 2 photographs, residuals 0.234 px (0.94 µm). self-calibrated."));
  EXPECT_THAT(bare(page), HasSubstr("neither can be told without the other: fx – cx +0.951, k1 – k2 -0.987."));
}

TEST(BlockTables, PhotographsHaveTheirFiguresOrWhyTheyAreNotOriented) {
  const auto rows = rows_behind(page_of(block()), "id=\"photographs\"");
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0].at("Photograph"), "a.jpg");
  EXPECT_EQ(rows[0].at("Points"), "7");
  EXPECT_EQ(rows[0].at("Residuals [px]"), "0.136");
  EXPECT_EQ(rows[0].at("Covered"), "38 %");
  EXPECT_EQ(rows[0].at("Largest angle [°]"), "35") << "of P1, which it shows, and not of C1";
  EXPECT_EQ(rows[0].at("Centre x, y, z [m]"), "1.2346, -2.3457, 3.4568");
  EXPECT_EQ(rows[0].at("Sigma [mm]"), "1.30");
  EXPECT_EQ(rows[0].at("Remarks"), "");
  EXPECT_EQ(rows[1].at("Largest angle [°]"), "12");
  EXPECT_EQ(rows[1].at("Remarks"), "correlated by -0.970 with the interior orientation");
  EXPECT_EQ(rows[2].at("Points"), "–");
  EXPECT_EQ(rows[2].at("Remarks"), "not oriented: no plate in it");
}

TEST(BlockTables, PointsHaveTheirFiguresInTheirUnits) {
  const auto rows = rows_behind(page_of(block()), "id=\"points\"");
  ASSERT_EQ(rows.size(), 4u);
  const std::map<std::string, std::string> first = {{"Point", "P1"},
                                                    {"Rays", "2"},
                                                    {"Of the photographs", "100 %"},
                                                    {"Largest angle [°]", "35"},
                                                    {"x [m]", "1.23457"},
                                                    {"y [m]", "-2.00000"},
                                                    {"z [m]", "3.00000"},
                                                    {"Sigma x [mm]", "0.120"},
                                                    {"Sigma y [mm]", "0.340"},
                                                    {"Sigma z [mm]", "0.560"},
                                                    {"Size over nominal", "1.00025 ± 0.00010"}};
  for (const auto& [name, value] : first) EXPECT_EQ(rows[0].at(name), value) << name;
  EXPECT_EQ(rows[1].at("Of the photographs"), "50 %") << "of those that are oriented";
  EXPECT_EQ(rows[1].at("Size over nominal"), "0.99950");
}

TEST(BlockTables, SurveyedPointsHaveTheirDifferencesAndCheckPointsTheirMean) {
  const std::string page = page_of(block());
  const auto rows = rows_behind(page, "id=\"control\"");
  ASSERT_EQ(rows.size(), 3u);
  const std::map<std::string, std::string> first = {{"Point", "K1"},
                                                    {"Role", "control"},
                                                    {"Rays", "1"},
                                                    {"dx [mm]", "+1.11"},
                                                    {"dy [mm]", "-2.22"},
                                                    {"dz [mm]", "+3.33"},
                                                    {"Sigma of the survey [mm]", "0.5, 0.6, 0.7"},
                                                    {"Sigma of the adjusted point [mm]", "1.0, 2.0, 3.0"},
                                                    {"Largest |w|", "3.4 !"},
                                                    {"Residuals [px]", "0.31"}};
  for (const auto& [name, value] : first) EXPECT_EQ(rows[0].at(name), value) << name;
  EXPECT_EQ(rows[1].at("Largest |w|"), "–") << "not tested";
  EXPECT_EQ(rows[2].at("Largest |w|"), "2.0");
  // Over the two check points: 3 and 1, 1 and 3, 2 and 4 mm.
  EXPECT_THAT(bare(page), HasSubstr("root mean square 2.2 mm in x, 2.2 mm in y, 3.2 mm in z over 2 points"));
  EXPECT_THAT(bare(page), HasSubstr("They hold: none is off by more than"));
  EXPECT_THAT(bare(page), HasSubstr("NEES 7.3 of 6 degrees of freedom (at most 12.6). a word."));
}

TEST(BlockTables, GroupsOfObservationsAreTestedWhereThereIsRedundancy) {
  const auto rows = rows_behind(page_of(block()), "id=\"groups\"");
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].at("Number"), "400");
  EXPECT_EQ(rows[0].at("Redundancy"), "290.2");
  EXPECT_EQ(rows[0].at("Variance factor"), "2.25");
  EXPECT_EQ(rows[0].at("Standard deviations times"), "1.50");
  EXPECT_EQ(rows[1].at("Variance factor"), "–") << "half an observation says nothing";
}

TEST(BlockTables, TheHeadHasTheNumbersOfTheBlock) {
  const std::string page = bare(page_of(block()));
  EXPECT_THAT(page, HasSubstr("2 of 3 photographs hang together, 4 points, residuals 0.25 pxDatum: control. 1 "
                              "photograph is only weakly oriented"));
  EXPECT_THAT(page, HasSubstr("Residuals|0.247 px|0.99 µm; root mean square"));
  EXPECT_THAT(
      page, HasSubstr("σ0|1.234|standard deviation of unit weight; 321 degrees of freedom, 456 observations, 135 unk"));
  EXPECT_THAT(page, HasSubstr("Left out|1|observations as blunders; 1 photographs or points"));
  double sum = 0;  // of the squares of twelve standard deviations
  for (const double s : {0.00012, 0.00034, 0.00056, 0.001, 0.002, 0.003}) sum += s * s;
  char mean[16];
  std::snprintf(mean, sizeof mean, "%.3f mm", 1e3 * std::sqrt((sum + 6e-6) / 12));
  EXPECT_THAT(page,
              HasSubstr("Points, 1 sigma|" + std::string(mean) + "|of a coordinate, rms over all; the worst 3.000 mm"));
  Json sound = block();
  sound["left_out"] = Json::array(), sound["images"][1]["reason"] = "";
  EXPECT_THAT(page_of(sound), HasSubstr("class=\"verdict pass\""));
  EXPECT_THAT(page_of(block()), Not(HasSubstr("class=\"verdict pass\"")));
}

/// What somebody pointed at by hand is looked at first, then the largest residuals; blunders before all.
TEST(BlockTables, TheWorstObservationsAreShownInTheirOrder) {
  const std::string page = bare(page_of(block()));
  const auto blunder = page.find("P1 in b.jpg|40 px off"),
             pointed = page.find("C1 in a.jpg|residuals 0.10 px, largest |w| 2.3"),
             worst = page.find("K1 in b.jpg|residuals 0.50 px"), last = page.find("P1 in a.jpg|residuals 0.20 px");
  for (const auto at : {blunder, pointed, worst, last}) EXPECT_NE(at, std::string::npos);
  EXPECT_LT(blunder, pointed);
  EXPECT_LT(pointed, worst);
  EXPECT_LT(worst, last);
}

}  // namespace test_block_tables
}  // namespace plumbline::report

// The page of a calibration: every cell is the figure of its heading.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <numbers>

#include "page_tables.hpp"
#include "show/report/calibration_page.hpp"
#include "show/report/markup.hpp"

namespace plumbline::report {
namespace test_calibration_page {

using namespace page_tables;
using Json = nlohmann::ordered_json;
using testing::HasSubstr;
using testing::Not;

Json camera(const std::string& id) {
  return Json::parse(R"({"id": ")" + id +
                     R"(", "board": "ChArUco 8 x 8", "model": "Brown", "width": 1200, "height": 800,
    "rms_px": 0.2346, "sigma_px": 0.3456, "degrees_of_freedom": 1234,
    "halves": {"median_difference_px": 0.125, "median_expected_px": 0.0628},
    "parameters": {"fx": 1127.3456, "cy": 401.5, "k1": -0.123456, "p1": 0.0002},
    "sigmas": {"fx": 0.25, "cy": 0.75, "k1": 0.0012, "p1": 0},
    "parameter_order": ["fx", "cy", "k1"],
    "correlations": [[1, 0.96, -0.5], [0.96, 1, 0.25], [-0.5, 0.25, 1]],
    "projection_uncertainty_px": [[0.1, 0.2, 0.3, 0.4], [0.5, 0.6, 0.7, 0.9], [null, 0.2, 0.2, 0.2]],
    "images": [{"path": "IMG_1.jpg", "used": true, "points": 49, "rms_px": 0.1234, "coverage": 0.437, "tilt_deg": 31.4,
                "residuals": [[100, 200, 0.1, -0.2]]},
               {"path": "IMG_2.jpg", "used": false, "reason": "blurred", "residuals": []}],
    "rejected": ["point 7 of IMG_1.jpg", "point 9 of IMG_1.jpg"], "warnings": []})");
}

std::string page_of(const Json& calibration) {
  Markup html;
  write_calibration(html, calibration, "Calibration", "site A");
  return html.str();
}

TEST(CalibrationPage, ParametersHaveTheDigitsOfTheirSigmas) {
  const std::string page = page_of(camera("left"));
  const auto rows = rows_behind(page, "id=\"parameters\"");
  ASSERT_EQ(rows.size(), 4u);
  const std::vector<std::array<std::string, 4>> expected = {{"fx", "1127.35", "0.25", "px"},
                                                            {"cy", "401.50", "0.75", "px"},
                                                            {"k1", "-0.1235", "0.0012", "1"},
                                                            {"p1", "0.000200", "held", "1"}};
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(rows[i].at("Parameter"), expected[i][0]);
    EXPECT_EQ(rows[i].at("Value"), expected[i][1]);
    EXPECT_EQ(rows[i].at("Sigma"), expected[i][2]);
    EXPECT_EQ(rows[i].at("Unit"), expected[i][3]);
  }
  EXPECT_THAT(bare(page), HasSubstr("from the residuals: 0.346 px; 1234 degrees of freedom."));
  EXPECT_THAT(bare(page), HasSubstr("Calibrated on 1 of 2 photographs, residuals 0.235 px"));
  EXPECT_THAT(bare(page),
              HasSubstr("differ by 0.125 px in the median over the image; their uncertainties let 0.063 px"));
}

TEST(CalibrationPage, CorrelationsStandAtTheirPlacesAndStrongOnesAreShown) {
  const std::string page = page_of(camera("left"));
  const auto cells = cells_behind(page, "Correlations");
  ASSERT_EQ(cells.size(), 4u);
  EXPECT_EQ(cells[0], (std::vector<std::string>{"", "fx", "cy", "k1"}));
  EXPECT_EQ(cells[1], (std::vector<std::string>{"fx", "1", "+0.96", "-0.50"}));
  EXPECT_EQ(cells[2], (std::vector<std::string>{"cy", "+0.96", "1", "+0.25"}));
  EXPECT_EQ(cells[3], (std::vector<std::string>{"k1", "-0.50", "+0.25", "1"}));
  EXPECT_THAT(page, HasSubstr("<strong>+0.96</strong>"));
  EXPECT_THAT(page, Not(HasSubstr("<strong>1</strong>")));
}

/// A rectangle for each place that is known, the darker the less sure, and its value beside some of them.
TEST(CalibrationPage, TheMapHasThePlacesAndShadesOfItsValues) {
  const std::string page = page_of(camera("left"));
  EXPECT_THAT(bare(page), HasSubstr("0.100 px at best, 0.900 px at worst"));
  const auto begin = page.find("id=\"uncertainty\""), end = page.find("</svg>", begin);
  std::vector<std::array<double, 5>> drawn;
  const auto attribute = [&](size_t from, const std::string& name) {
    const auto at = page.find(" " + name + "=\"", from) + name.size() + 3;
    return std::stod(page.substr(at, page.find('"', at) - at));
  };
  for (auto at = page.find("<rect", begin); at < end; at = page.find("<rect", at + 1))
    drawn.push_back({attribute(at, "x"), attribute(at, "y"), attribute(at, "width"), attribute(at, "height"),
                     attribute(at, "fill-opacity")});
  ASSERT_EQ(drawn.size(), 11u) << "one of twelve is not known";
  const double width = 760.0 / 4, height = 760.0 * 800 / 1200 / 3;
  const std::vector<double> values = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.9, 0.2, 0.2, 0.2};
  for (size_t i = 0; i < drawn.size(); ++i) {
    const size_t place = i < 8 ? i : i + 1;
    EXPECT_NEAR(drawn[i][0], width * static_cast<double>(place % 4), 0.006) << i;
    EXPECT_NEAR(drawn[i][1], height * static_cast<double>(place / 4), 0.006) << i;
    EXPECT_NEAR(drawn[i][2], width + 0.5, 0.006);
    EXPECT_NEAR(drawn[i][3], height + 0.5, 0.006);
    EXPECT_NEAR(drawn[i][4], 0.08 + (values[i] - 0.1), 0.0051) << i;
  }
  EXPECT_THAT(page.substr(begin, end - begin), HasSubstr(">0.70<")) << "second row, third column";
}

TEST(CalibrationPage, PhotographsHaveTheirFiguresOrWhyTheyAreLeftOut) {
  const std::string page = page_of(camera("left"));
  const auto rows = rows_behind(page, "id=\"photographs\"");
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].at("Photograph"), "IMG_1.jpg");
  EXPECT_EQ(rows[0].at("Points"), "49");
  EXPECT_EQ(rows[0].at("Residuals [px]"), "0.123");
  EXPECT_EQ(rows[0].at("Covered"), "44 %");
  EXPECT_EQ(rows[0].at("Tilt of the board [°]"), "31");
  EXPECT_EQ(rows[0].at("Remarks"), "");
  EXPECT_EQ(rows[1].at("Points"), "–");
  EXPECT_EQ(rows[1].at("Covered"), "–");
  EXPECT_EQ(rows[1].at("Remarks"), "left out: blurred");
  EXPECT_THAT(bare(page), HasSubstr("2 points left out as blunders"));
  EXPECT_THAT(page, HasSubstr("<li>point 9 of IMG_1.jpg</li>"));
}

TEST(CalibrationPage, ItIsMarkedWhereSomethingNeedsAttention) {
  Json sound = camera("left");
  sound["images"][1]["used"] = true;
  EXPECT_THAT(page_of(sound), HasSubstr("class=\"verdict pass\""));
  EXPECT_THAT(page_of(camera("left")), HasSubstr("class=\"verdict undecided\"")) << "one photograph was left out";
  sound["warnings"] = {"the halves contradict each other"};
  const std::string warned = page_of(sound);
  EXPECT_THAT(warned, HasSubstr("class=\"verdict undecided\""));
  EXPECT_THAT(warned, HasSubstr("<li>the halves contradict each other</li>"));
  sound["halves"]["median_expected_px"] = nullptr;
  EXPECT_THAT(page_of(sound), HasSubstr("nothing checks the model"));
}

/// Of a rig each camera has its own part, and the table the poses between them.
TEST(CalibrationPage, ARigHasItsPosesInMillimetresAndDegrees) {
  const double half = 0.5 * 5 * std::numbers::pi / 180;  // five degrees about y
  Json rig = {{"cameras", {camera("left"), camera("right")}}};
  rig["rig"] = {{{"camera", "right"},
                 {"reference", "left"},
                 {"shared", 12},
                 {"left_out", {"a", "b", "c"}},
                 {"translation", {-0.1234, 0.0456, 0.0007}},
                 {"translation_sigma", {0.0001, 0.0002, 0.0003}},
                 {"rotation", {std::cos(half), 0, std::sin(half), 0}},
                 {"rotation_sigma", {1e-4, 2e-4, 2e-4}},
                 {"rms_px", 0.234},
                 {"separate_rms_px", 0.2},
                 {"halves", 2.25}}};
  const std::string page = page_of(rig);
  const auto rows = rows_behind(page, "id=\"rig\"");
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].at("Camera"), "right");
  EXPECT_EQ(rows[0].at("Reference"), "left");
  EXPECT_EQ(rows[0].at("Moments shared"), "12");
  EXPECT_EQ(rows[0].at("Left out"), "3");
  expect_numbers(rows[0].at("Translation x, y, z [mm]"), {-123.4, 45.6, 0.7}, 2);
  expect_numbers(rows[0].at("Sigma [mm]"), {0.1, 0.2, 0.3}, 2);
  expect_numbers(rows[0].at("Turn [°]"), {5}, 3);
  expect_numbers(rows[0].at("Sigma [°]"), {std::sqrt(3e-8) * 180 / std::numbers::pi}, 4);
  expect_numbers(rows[0].at("Residuals here, alone [px]"), {0.234, 0.2}, 3);
  expect_numbers(rows[0].at("Halves"), {1.5}, 1);
  EXPECT_THAT(page, HasSubstr("<h1>left</h1>"));
  EXPECT_THAT(page, HasSubstr("<h1>right</h1>"));
  rig["rig"][0]["halves"] = nullptr;
  EXPECT_EQ(rows_behind(page_of(rig), "id=\"rig\"").at(0).at("Halves"), "too few");
  rig["rig"] = Json::array();
  EXPECT_THAT(page_of(rig), HasSubstr("No two cameras have three photographs of the same moments"));
}

}  // namespace test_calibration_page
}  // namespace plumbline::report

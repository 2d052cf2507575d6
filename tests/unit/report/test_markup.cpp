#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "show/report/format.hpp"
#include "show/report/image_block_page.hpp"
#include "show/report/markup.hpp"
#include "show/report/plot.hpp"

namespace plumbline::report {
namespace test_markup {

TEST(Markup, EscapesTextAndAttributes) {
  Markup m;
  m.open("p", {{"title", "a\"b<c>'&"}}).text("<script>alert(1)</script> & \x01").close();
  EXPECT_EQ(m.str(), "<p title=\"a&quot;b&lt;c&gt;&#39;&amp;\">&lt;script&gt;alert(1)&lt;/script&gt; &amp;  </p>\n");
}

TEST(Markup, RefusesUnbalancedElements) {
  Markup m;
  EXPECT_THROW(m.close(), std::logic_error);
  m.open("b");
  EXPECT_THROW(m.str(), std::logic_error);
}

TEST(Format, NumbersForReaders) {
  EXPECT_EQ(mm(0.00123456), "1.23");
  EXPECT_EQ(signed_mm(-0.00123456), "\u22121.23");
  EXPECT_EQ(signed_mm(0.00123456), "+1.23");
  EXPECT_EQ(signed_mm(-0.000001), "0.00");
  EXPECT_EQ(signed_mm(0.000001), "0.00");
  EXPECT_EQ(mm(std::numeric_limits<double>::quiet_NaN()), "\u2013");
  EXPECT_EQ(mm_with_u(0.001, std::nan("")), "+1.00");
  EXPECT_EQ(tolerance(0.0025), "2.5\u00A0mm");
  EXPECT_EQ(tolerance(0.005), "5\u00A0mm");
  EXPECT_EQ(percent(1), "100\u00A0%");
  EXPECT_EQ(percent(0.99996), "99.9\u00A0%");  // not quite all is not all
  EXPECT_EQ(percent(0.00001), "0.1\u00A0%");
  EXPECT_EQ(probability(0.0001), "<\u00A00.001");
  EXPECT_EQ(count(1, "anchor", "anchors"), "1\u00A0anchor");
}

TEST(Plot, Ticks) {
  EXPECT_EQ(ticks(-5.4, 5.4, 6), (std::vector<double>{-4, -2, 0, 2, 4}));
  EXPECT_EQ(decimals_of(ticks(-5.4, 5.4, 6)), 0);
  EXPECT_EQ(decimals_of(ticks(-0.2, 0.2, 9)), 2) << "steps of 0.05";
  EXPECT_EQ(decimals_of(ticks(0, 1, 10)), 1);
  EXPECT_EQ(round_down(377), 200);
  EXPECT_EQ(round_down(500), 500);
  EXPECT_EQ(round_up(0.03), 0.05);
}

TEST(Plot, LabelsNeverOverlap) {
  Markup svg;
  LabelPlacer placer({0, 0, 400, 400}, 12);
  int placed = 0;
  for (int i = 0; i < 60; ++i) placed += placer.place(svg, 200, 200, 12, "A" + std::to_string(i), "x");
  EXPECT_GE(placed, 2);  // places around one point; the neighbours of a taken one are taken as well
  EXPECT_LE(placed, 8);
  EXPECT_FALSE(placer.place(svg, 5, 600, 12, "outside", "x"));
}

TEST(ImageBlockPage, ShowsSurveyedPointsWithWhatWasWithheldAndEveryRejection) {
  const auto block = nlohmann::ordered_json::parse(R"({
    "statistics": {"rms_px": 0.25}, "datum": "control",
    "cameras": [{"id": "c", "width": 100, "height": 80, "rms_px": 0.25, "pixel_pitch_um": 4.0}],
    "images": [{"path": "a</script>.jpg", "oriented": true, "camera": "c", "centre": [0, 0, 5], "sigma": [0.001, 0.001, 0.001],
                "rotation": [0, 1, 0, 0], "tags": 3, "rms_px": 0.25, "coverage": 0.5}],
    "points": [
      {"id": "P1", "role": "check", "position": [0, 0, 0], "sigma": [0.001, 0.001, 0.001], "surveyed": [0, 0, 0],
       "surveyed_sigma": [0.002, 0.002, 0.002], "difference": [0.003, -0.004, 0], "w": [0, 0, 0], "rays": 2, "largest_angle_deg": 41},
      {"id": "P2", "role": "control", "position": [1, 0, 0], "sigma": [0.001, 0.001, 0.001], "surveyed": [1, 0, 0],
       "difference": [0, 0, 0.001], "w": [0.5, -3.6, 0], "rays": 2, "largest_angle_deg": 12},
      {"id": "P3", "position": [0, 1, 0], "sigma": [0.001, 0.001, 0.001], "rays": 2, "largest_angle_deg": 5}],
    "observations": [{"image": "a</script>.jpg", "point": "P1", "corners": [[10, 10]], "residuals": [[0.1, 0.2]], "rms_px": 0.16}],
    "rejected": [{"image": "a</script>.jpg", "point": "P3", "corners": [[1, 1]], "reason": "it disagrees"}]})");
  Markup m;
  write_image_block(m, block, "Title", "", {});
  const std::string& page = m.str();
  for (const char* expected : {"3.0\u00a0mm in x, 4.0\u00a0mm in y", "over 1\u00a0point", ">3.6<", "it disagrees",
                               "0.250 px (1.00 µm)", "1\u00a0observation was left out", "\"n\":\"P1\""})
    EXPECT_NE(page.find(expected), std::string::npos) << expected;
  EXPECT_EQ(page.find("a</script>"), std::string::npos) << "a name cannot end the script";
  EXPECT_NE(page.find("<td>41</td>"), std::string::npos) << "the photograph's largest angle";
}

}  // namespace test_markup
}  // namespace plumbline::report

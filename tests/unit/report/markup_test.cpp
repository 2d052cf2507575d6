#include "report/markup.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "report/format.hpp"
#include "report/plot.hpp"

namespace plumbline::report {
namespace {

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

}  // namespace
}  // namespace plumbline::report

// Pages and summary in inches: every length is converted once, with its unit, and to enough digits.
#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "geometry/random.hpp"
#include "show/report/exact_lengths.hpp"
#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/report.hpp"
#include "show/report/sheets_page.hpp"
#include "show/report/summary.hpp"
#include "spoken_pages.hpp"

namespace plumbline::report {
namespace test_inches {

using test::full_example;
using test::numbers_of;
using test::texts_read;

constexpr Speech kInches{Language::english, Units::inches};

/// Whether `inches` is what `millimetres` says, both as they are rounded.
bool same_length(const std::string& millimetres, const std::string& inches) {
  const auto half_step = [](const std::string& number) {
    const std::size_t point = number.find('.');
    return 0.5 * std::pow(10.0, point == std::string::npos ? 0 : -static_cast<double>(number.size() - point - 1));
  };
  return std::abs(25.4 * std::stod(inches) - std::stod(millimetres)) <=
         half_step(millimetres) + 25.4 * half_step(inches) + 1e-9;
}

struct ReadCell {
  std::string head, text;
};

/// Cells of all tables, with the head of their column.
std::vector<ReadCell> cells_of(const std::string& html) {
  std::vector<ReadCell> cells;
  const auto plain = [](const std::string& inner) { return std::regex_replace(inner, std::regex("<[^>]*>"), ""); };
  const std::regex a_cell("<t([hd])[^>]*>([^]*?)</t[hd]>");
  for (std::size_t at = 0; (at = html.find("<table", at)) != std::string::npos;) {
    const std::size_t end = html.find("</table>", at);
    std::vector<std::string> heads;
    for (std::size_t row = html.find("<tr", at); row < end; row = html.find("<tr", row + 1)) {
      const std::string inner = html.substr(row, html.find("</tr>", row) - row);
      const bool head = inner.find("scope=\"col\"") != std::string::npos;
      std::size_t column = 0;
      for (std::sregex_iterator cell(inner.begin(), inner.end(), a_cell), last; cell != last; ++cell, ++column) {
        const std::string text = plain((*cell)[2].str());
        if (head) heads.push_back(text);
        cells.push_back({column < heads.size() && !head ? heads[column] : "", text});
      }
    }
    at = end;
  }
  return cells;
}

TEST(Inches, EveryLengthOfTablesIsConverted) {
  const ReportInput input = full_example();
  const std::vector<ReadCell> before = cells_of(render_report(input));
  const Speaking speaking(kInches);
  const std::vector<ReadCell> after = cells_of(render_report(input));
  ASSERT_EQ(before.size(), after.size());
  int lengths = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (before[i].head.find("[mm") == std::string::npos) continue;
    EXPECT_NE(after[i].head.find("[in"), std::string::npos) << after[i].head;
    const auto was = numbers_of(before[i].text), is = numbers_of(after[i].text);
    ASSERT_EQ(was.size(), is.size()) << before[i].text << " | " << after[i].text;
    for (std::size_t k = 0; k < was.size(); ++k) {
      if (was[k].find('.') == std::string::npos) continue;  // part of a name
      if (before[i].head.find("[mm/m]") != std::string::npos)
        EXPECT_NEAR(std::stod(is[k]) * 1000 / 12, std::stod(was[k]), 0.1) << before[i].head << ": " << before[i].text;
      else
        EXPECT_TRUE(same_length(was[k], is[k])) << before[i].head << ": " << before[i].text << " | " << after[i].text;
      ++lengths;
    }
  }
  EXPECT_GT(lengths, 1000);
}

TEST(Inches, EveryLengthOfSentencesIsConverted) {
  const ReportInput input = full_example();
  const auto check = [](const std::vector<std::string>& before, const std::vector<std::string>& after) {
    ASSERT_LE(before.size(), after.size());
    for (std::size_t i = 0; i < before.size(); ++i) {
      const bool length = std::regex_search(before[i], std::regex("(^|[^A-Za-z=0-9])mm([^A-Za-z/]|$)"));
      if (!length || before[i].starts_with("Residual v")) continue;  // that one has limits of r and w
      EXPECT_FALSE(std::regex_search(after[i], std::regex("(^|[^A-Za-z=0-9])mm([^A-Za-z/]|$)"))) << after[i];
      // What the scale of a drawing stands for is round in each unit.
      const auto told = [](const std::string& text) {
        return numbers_of(std::regex_replace(text, std::regex("right edge stands for [0-9.]+"), ""));
      };
      const auto was = told(before[i]), is = told(after[i]);
      ASSERT_EQ(was.size(), is.size()) << before[i] << " | " << after[i];
      for (std::size_t k = 0; k < was.size(); ++k) {
        const std::string unit = "(?:\u00A0|\u202F| )?(?:%|m\\b(?!m)|times|px|mgon)";
        const bool other = std::regex_search(before[i], std::regex("p = " + was[k])) ||
                           std::regex_search(before[i], std::regex(was[k] + unit)) ||
                           was[k].find('.') == std::string::npos;
        EXPECT_TRUE(same_length(was[k], is[k]) || (other && was[k] == is[k])) << before[i] << " | " << after[i];
      }
    }
  };
  const std::vector<std::string> drawn = {"script", "style", "svg"};  // a chart in inches has other ticks
  const auto page = texts_read(render_report(input), drawn), sheets = texts_read(render_sheets(input), drawn);
  const Speaking speaking(kInches);
  check(page, texts_read(render_report(input), drawn));
  check(sheets, texts_read(render_sheets(input), drawn));
  const std::string inches = summary_text(input.accuracy, &*input.deviation, &*input.changes);
  EXPECT_NE(inches.find("Tolerance 0.1969 in"), std::string::npos) << inches;
}

/// Notes that artifacts hold are in millimetres: number and unit are converted together, and once.
TEST(Inches, NotesOfArtifactsAreConvertedWithTheirUnit) {
  const Speaking speaking(kInches);
  EXPECT_EQ(spoken("Floor 2 hangs 12.0 mm ± 0.4 mm low (7 of its 8 anchors share it): one cause"),
            "Floor 2 hangs 0.472 in ± 0.016 in low (7 of its 8 anchors share it): one cause");
  EXPECT_EQ(spoken("moved by the same, +1.2, -0.3, +4.0 mm (x, y, z)"),
            "moved by the same, +0.047, -0.012, +0.157 in (x, y, z)");
  EXPECT_EQ(spoken("limit 5 mm, of C4 mm, 5mm as you wrote it"), "limit 0.197 in, of C4 in, 5mm as you wrote it");
  EXPECT_EQ(spoken("numbers in mm"), "numbers in inches");
  EXPECT_EQ(spoken("limits of 4, 5 and 6 mm"), "limits of 0.157, 0.197 and 0.236 in");
  EXPECT_EQ(spoken("3 of 4 anchors by +1, -2, +4 mm"), "3 of 4 anchors by +0.039, -0.079, +0.157 in");
  for (const std::string uncertain :
       {"G12 E -1.0, N -1.5, H +0.4 mm; G3", "w = 4.3, wrong by 12.0 mm", "G12 E -1, N -2, H +4 mm"})
    EXPECT_EQ(spoken(uncertain), uncertain) << "half of it converted would be wrong by 25 times";
  EXPECT_EQ(spoken("1.7 times 12.0 mm, 3.10 m, 95.0 %"), "1.7 times 0.472 in, 3.10 m, 95.0 %");
  EXPECT_EQ(spoken(mm(0.0127, 1) + " ± " + mm(0.000254, 1) + "\u00A0mm"), "0.500 ± 0.010\u00A0in");
  EXPECT_EQ(spoken("Panel " + verbatim("Glass 12 mm") + " moved 12.7 mm"), "Panel Glass 12 mm moved 0.500 in")
      << "a name is no length";
  const Speaking both({Language::german, Units::inches});
  EXPECT_EQ(spoken("joint to P2 12.7 mm (limit 5 mm)"), "Fuge zu P2 0,500\u00A0Zoll (Grenze 0,197\u00A0Zoll)");
}

/// What a panel fails by is one of its own lengths or of its anchors': it reads the same in both rows, though the
/// sentence of the artifact is rounded to 0.1 mm.
TEST(Inches, APanelsReasonHasTheLengthsOfItsRows) {
  PanelDeviationT panel;
  panel.warp = std::make_unique<JudgedLengthT>();
  panel.warp->value = 0.00341, panel.warp->tolerance = 0.003;
  panel.joints.push_back(std::make_unique<PanelJointT>());
  panel.joints[0]->name = "P2", panel.joints[0]->change = std::make_unique<JudgedLengthT>();
  panel.joints[0]->change->value = -0.00664, panel.joints[0]->change->tolerance = 0.003175;
  panel.fixings.push_back(std::make_unique<PanelFixingT>());
  panel.fixings[0]->anchor = "A7";
  DeviationT deviation;
  deviation.anchors.push_back(std::make_unique<AnchorDeviationT>());
  deviation.anchors[0]->id = "A7";
  deviation.anchors[0]->axes.push_back(std::make_unique<JudgedAxisT>());
  JudgedAxisT& axis = *deviation.anchors[0]->axes[0];
  axis.axis = "vertical", axis.value = 0.00666, axis.tolerance = 0.005;
  const auto said = [&](const std::string& reason, Speech speech) {
    const Speaking speaking(speech);
    panel.reason = reason;
    return spoken(reason_of(panel, deviation));
  };
  const std::string by_anchor = "anchor A7 vertical 6.7 mm (limit 5 mm)";
  EXPECT_EQ(said(by_anchor, {}), by_anchor);
  EXPECT_EQ(said(by_anchor, kInches), "anchor A7 vertical 0.262 in (limit 0.1969\u00A0in)");
  EXPECT_EQ(said("joint to P2 -6.6 mm (limit 3.17 mm)", kInches), "joint to P2 −0.261 in (limit 0.125\u00A0in)");
  EXPECT_EQ(said("warp 3.4 mm (limit 3 mm)", kInches), "warp 0.134 in (limit 0.1181\u00A0in)");
  EXPECT_EQ(said("anchor A9 was not measured", kInches), "anchor A9 was not measured");
  EXPECT_EQ(said(by_anchor, {Language::german, Units::inches}),
            "Anker A7 Höhe 0,262\u00A0Zoll (Grenze 0,1969\u00A0Zoll)");
  // And of shifts.
  const Speaking speaking(kInches);
  CommonShiftT shift;
  shift.shift = {0.01204, -0.00304, 0.00041};
  shift.words = "8 of 9 anchors are shifted together by +12.0 mm in x, -3.0 mm in y, +0.4 mm in z.";
  EXPECT_EQ(spoken(words_of(shift)),
            "8 of 9 anchors are shifted together by +0.474 in in x, −0.120 in in y, +0.016 in in z.");
  GroupShiftT group;
  group.shift = {0, 0, -0.01204}, group.u = {0, 0, 0.00044};
  group.words = "Floor 2 hangs 12.0 mm ± 0.4 mm low (7 of its 8 anchors share it): one cause to look for.";
  EXPECT_EQ(spoken(words_of(group, deviation)),
            "Floor 2 hangs 0.474 in ± 0.017 in low (7 of its 8 anchors share it): one cause to look for.");
}

/// What is printed of a value and of its limit stands on the same side as they do, in both units.
TEST(Inches, RoundingKeepsTheSideOfTheLimit) {
  Random random(11);
  for (const Units units : {Units::millimetres, Units::inches}) {
    const Speaking speaking({Language::english, units});
    int wider = 0;
    for (int i = 0; i < 20000; ++i) {
      const double limit = i % 2 == 0 ? 0.005 : 0.003175;
      const double value = limit + 2e-4 * (random.uniform() - 0.5);
      const int digits = decimals_beside(value, limit, 1);
      const double shown = std::stod(spoken(mm(value, digits))), shown_limit = std::stod(spoken(mm(limit, digits)));
      ASSERT_GE(digits, 1);
      wider += digits > 1;
      if (std::abs(value - limit) > 1e-7) {
        EXPECT_EQ(value > limit, shown > shown_limit) << value << " " << limit;
        EXPECT_NE(shown, shown_limit) << value << " " << limit;
      }
    }
    EXPECT_GT(wider, 100);
  }
}

TEST(Inches, WhatIsToBeSetHasAFractionToo) {
  EXPECT_EQ(spoken(to_set(-0.0025)), "2.5\u00A0mm");
  const Speaking speaking(kInches);
  EXPECT_EQ(spoken(to_set(-0.0025)), "0.098\u00A0in (3/32)");
  EXPECT_EQ(spoken(to_set(0.0127)), "0.500\u00A0in (1/2)");
  EXPECT_EQ(spoken(to_set(0.0254)), "1.000\u00A0in (1)");
  EXPECT_EQ(spoken(to_set(0.0365125)), "1.438\u00A0in (1-7/16)");
  EXPECT_EQ(spoken(tolerance(0.003175)), "0.125\u00A0in");
  const Speaking both({Language::german, Units::inches});
  EXPECT_EQ(spoken("Reset or shim: " + to_set(0.0365125) + " outward, " + to_set(-0.0025) + " up."),
            "Versetzen oder unterlegen: 1,438\u00A0Zoll (1-7/16) nach außen, 0,098\u00A0Zoll (3/32) nach oben.");
}

}  // namespace test_inches
}  // namespace plumbline::report

// The workbook says what the judgement says, in both languages, and spreadsheet programs can read it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <set>

#include "../bim/unzipped.hpp"
#include "example.hpp"
#include "show/report/catalogue.hpp"
#include "show/report/deviation_workbook.hpp"
#include "show/report/workbook.hpp"
#include "test_support.hpp"

namespace plumbline::report {
namespace test_workbook {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(Workbook, HasAPartForEverySheetAndKeepsNumbersWhole) {
  const double third = 1.0 / 3;
  const std::string bytes =
      write_workbook({{"One & two",
                       {"Name", "Length"},
                       {0, 2},
                       {{std::string("A <1> \x01"), third}, {std::string(), std::numeric_limits<double>::quiet_NaN()}}},
                      {"Other", {"Name"}, {0}, {}}});
  const auto files = plumbline::test::unzipped(bytes);
  for (const char* name : {"[Content_Types].xml", "_rels/.rels", "xl/workbook.xml", "xl/_rels/workbook.xml.rels",
                           "xl/styles.xml", "xl/worksheets/sheet1.xml", "xl/worksheets/sheet2.xml"})
    EXPECT_EQ(files.count(name), 1u) << name;
  const std::string& sheet = files.at("xl/worksheets/sheet1.xml");
  EXPECT_TRUE(contains(sheet, "<v>0.3333333333333333</v>")) << sheet;
  EXPECT_TRUE(contains(sheet, "A &lt;1&gt;  ")) << "no control character gets into XML";
  EXPECT_FALSE(contains(sheet, "nan"));
  EXPECT_TRUE(contains(sheet, "<autoFilter ref=\"A1:B3\"/>"));
  EXPECT_TRUE(contains(files.at("xl/workbook.xml"), "name=\"One &amp; two\""));
}

TEST(Workbook, WhatNoProgramTakesIsRefused) {
  const Sheet sheet{"Anchors", {"a"}, {0}, {{1.0}}};
  EXPECT_NO_THROW(write_workbook({sheet}));
  EXPECT_THROW(write_workbook({sheet, sheet}), std::invalid_argument);
  for (const char* name : {"", "a/b", "a name that is longer than thirty-one letters"}) {
    Sheet wrong = sheet;
    wrong.name = name;
    EXPECT_THROW(write_workbook({wrong}), std::invalid_argument) << name;
  }
  Sheet narrow = sheet;
  narrow.rows.push_back({1.0, 2.0});
  EXPECT_THROW(write_workbook({narrow}), std::invalid_argument);
}

/// Every head and verdict of one language has its counterpart in the other.
TEST(Workbook, NoWordIsMissingInGerman) {
  const ReportInput input = test::example();
  const DeviationT& deviation = *input.deviation;
  const auto told = [](const std::string& text) {  // "Höhe [mm] u", "Höhe [mm] Toleranz"
    for (const std::string unit : {" u", " Tolerance"})
      if (text.ends_with(unit) && german().find(text.substr(0, text.size() - unit.size()))) return true;
    return german().find(text).has_value();
  };
  const auto sheets = deviation_sheets(deviation, Language::german);
  const auto english = deviation_sheets(deviation, Language::english);
  ASSERT_EQ(sheets.size(), english.size());
  for (std::size_t s = 0; s < sheets.size(); ++s) {
    EXPECT_TRUE(told(english[s].name)) << english[s].name;
    for (const std::string& head : english[s].heads) EXPECT_TRUE(told(head)) << head;
    EXPECT_NE(sheets[s].heads, english[s].heads);
    for (std::size_t c = 0; c < sheets[s].heads.size(); ++c)
      if (english[s].heads[c] == "Verdict" || english[s].heads[c] == "Decided by") {
        for (const auto& row : english[s].rows) {
          const std::string& word = std::get<std::string>(row[c]);
          EXPECT_TRUE(word.empty() || told(word)) << english[s].heads[c] << ": " << word;
        }
      }
  }
}

TEST(Workbook, SaysWhatTheJudgementSays) {
  const ReportInput input = test::example();
  const DeviationT& deviation = *input.deviation;
  const auto sheets = deviation_sheets(deviation, Language::english);
  const Sheet& anchors = sheets.at(0);
  ASSERT_EQ(anchors.rows.size(), deviation.anchors.size());
  const auto column = [&](const std::string& head) {
    return static_cast<std::size_t>(std::find(anchors.heads.begin(), anchors.heads.end(), head) -
                                    anchors.heads.begin());
  };
  for (const auto& row : anchors.rows) {
    const auto& id = std::get<std::string>(row[0]);
    const auto a = std::find_if(deviation.anchors.begin(), deviation.anchors.end(),
                                [&](const auto& anchor) { return anchor->id == id; });
    ASSERT_NE(a, deviation.anchors.end()) << id;
    const double dz = std::get<double>(row[column("dz [mm]")]);
    if (std::isfinite((*a)->deviation.z())) {
      EXPECT_NEAR(dz, 1e3 * (*a)->deviation.z(), 1e-9) << id;
    }
  }
  EXPECT_EQ(sheets.at(1).rows.size(), deviation.panels.size());
  EXPECT_EQ(sheets.at(2).rows.size(), deviation.floors.size());
}

/// openpyxl reads every cell back (Debian's python3-openpyxl, where it is installed).
TEST(Workbook, AnotherProgramReadsItBack) {
  if (std::system("/usr/bin/python3 -c 'import openpyxl' > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "python3-openpyxl is not installed";
  const ReportInput input = test::example();
  const DeviationT& deviation = *input.deviation;
  const auto sheets = deviation_sheets(deviation, Language::german);
  const plumbline::test::TemporaryFolder folder;
  const auto book = folder.path() / "d.xlsx", script = folder.path() / "read.py", out = folder.path() / "out.txt";
  std::ofstream(book, std::ios::binary) << write_workbook(sheets);
  std::ofstream(script)
      << "import openpyxl, sys\n"
         "for sheet in openpyxl.load_workbook(sys.argv[1]):\n"
         "    print(sheet.title, sheet.max_row, sheet.max_column)\n"
         "    for row in sheet.iter_rows(values_only=True): print(*['' if v is None else v for v in row], sep='|')\n";
  ASSERT_EQ(std::system(("PYTHONIOENCODING=utf-8 /usr/bin/python3 " + script.string() + " " + book.string() + " > " +
                         out.string())
                            .c_str()),
            0);
  const std::string read = plumbline::test::read_file(out);
  for (const Sheet& sheet : sheets) {
    EXPECT_TRUE(contains(read, sheet.name + " " + std::to_string(sheet.rows.size() + 1) + " " +
                                   std::to_string(sheet.heads.size()) + "\n"))
        << sheet.name << "\n"
        << read.substr(0, 2000);
    for (const auto& row : sheet.rows)
      for (const SheetCell& cell : row)
        if (const auto* words = std::get_if<std::string>(&cell); words && words->find('\n') == std::string::npos) {
          EXPECT_TRUE(contains(read, *words)) << *words;
        }
  }
}

}  // namespace test_workbook
}  // namespace plumbline::report

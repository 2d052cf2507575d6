// Pages and summary in German and in inches: no text without its German, no English word on a German page, no name
// taken for a word, every length converted once and to enough digits.
#include "show/report/language.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>

#include "../bim/doubt.hpp"
#include "example.hpp"
#include "geometry/random.hpp"
#include "show/report/catalogue.hpp"
#include "show/report/format.hpp"
#include "show/report/script_data.hpp"
#include "show/report/sheets_page.hpp"
#include "show/report/summary.hpp"
#include "source_texts.hpp"
#include "test_support.hpp"

namespace plumbline::report {
namespace {

constexpr Speech kGerman{Language::german, Units::millimetres}, kInches{Language::english, Units::inches};

TEST(Catalogue, PutsPlacesWhereTheOtherLanguageHasThem) {
  const Catalogue catalogue(
      "# a comment\n\nAnchor {id} is {#x} mm {~way}.\n  {~way} liegt Anker {id} um {#x} mm.\ntoo low\n  Zu tief\n"
      "{#n} anchor\n  {#n} Anker\n{~a} is out\n  {~a} außerhalb\n",
      ',');
  EXPECT_EQ(catalogue.find("Anchor F1.2 is −3.5 mm too low."), "Zu tief liegt Anker F1.2 um −3,5 mm.");
  EXPECT_EQ(catalogue.find("Anchor A is 3.5\u00A0mm too low."), "Zu tief liegt Anker A um 3,5 mm.")
      << "a no-break space is one";
  EXPECT_EQ(catalogue.find("Anchor A is far mm too low."), std::nullopt) << "a number is asked for";
  EXPECT_EQ(catalogue.find("1 anchor, 2 anchor and too low is out"), "1 Anker, 2 Anker und Zu tief außerhalb")
      << "a list";
  EXPECT_EQ(catalogue.find("too low. Anchor A is 3.5 mm too low. 2 anchor."),
            "Zu tief. Zu tief liegt Anker A um 3,5 mm. 2 Anker.")
      << "sentences one after another";
  EXPECT_EQ(catalogue.find("something else"), std::nullopt);
  EXPECT_EQ(catalogue.find("too low. something else."), std::nullopt) << "nothing half and half";
}

TEST(Catalogue, RefusesWithTheLine) {
  const auto error = [](const std::string& text) {
    try {
      const Catalogue catalogue(text, ',');
    } catch (const std::runtime_error& failure) {
      return std::string(failure.what());
    }
    return std::string("taken");
  };
  EXPECT_NE(error("a\n  b\na\n  c\n").find("line 3"), std::string::npos) << "twice";
  EXPECT_NE(error("a {x}\n  b {y}\n").find("same places"), std::string::npos);
  EXPECT_NE(error("a\nb\n  c\n").find("nothing in the other language"), std::string::npos);
  EXPECT_NE(error("a\n").find("nothing in the other language"), std::string::npos);
  EXPECT_NE(error("{a}{b}\n  {b} {a}\n").find("between them"), std::string::npos);
  EXPECT_EQ(error("a {x}\n  b {x}\n"), "taken");
}

/// Every text that sections of the page, the summary or the judgement compose is part of a sentence that has its
/// German.
TEST(German, HasEveryTextOfTheSources) {
  std::string sentences;
  for (const auto& entry : german().entries()) sentences += entry.written + "\n";
  const std::filesystem::path root = plumbline::test::source_dir();
  for (const std::string& file : test::files_with_texts(root))
    for (const test::SourceText& text : test::texts_of(root / file))
      for (const std::string& words : test::words_between_places(text.text))
        EXPECT_NE(sentences.find(words), std::string::npos)
            << file << ":" << text.line << ": '" << words << "' is in no sentence of plugins/show/report/german.txt";
}

/// What page.js and view.js say, too: tell("…") of what script_texts() hands to them.
TEST(German, HasEveryTextOfTheScripts) {
  std::set<std::string> handed(script_texts().begin(), script_texts().end());
  for (const std::string& text : handed) EXPECT_TRUE(german().find(text).has_value()) << text;
  for (const char* script : {"page.js", "view.js"}) {
    const std::string source = plumbline::test::read_file(std::filesystem::path(plumbline::test::source_dir()) /
                                                          "plugins/show/report" / script);
    const std::regex told("tell\\(\"([^\"]*)\"");
    for (std::sregex_iterator at(source.begin(), source.end(), told), end; at != end; ++at) {
      const std::string text = std::regex_replace((*at)[1].str(), std::regex("\\\\u03b7"), "\u03b7");
      EXPECT_TRUE(handed.contains(text)) << script << " says '" << text << "'";
    }
  }
}

/// What a reader sees or hears of a page.
std::vector<std::string> texts_read(std::string html, const std::vector<std::string>& without = {"script", "style"}) {
  for (const std::string& tag : without)
    for (std::size_t at = 0; (at = html.find("<" + tag, at)) != std::string::npos;)
      html.erase(at, html.find("</" + tag + ">", at) - at);
  std::vector<std::string> texts;
  const std::regex read(">([^<]+)<|(?:aria-label|title|placeholder|data-head)=\"([^\"]*)\"");
  for (std::sregex_iterator at(html.begin(), html.end(), read), end; at != end; ++at) {
    std::string text = (*at)[1].matched ? (*at)[1].str() : (*at)[2].str();
    for (const auto& [entity, sign] :
         {std::pair{"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&apos;", "'"}, {"&#39;", "'"}, {"&amp;", "&"}})
      for (std::size_t i = 0; (i = text.find(entity, i)) != std::string::npos; ++i)
        text.replace(i, std::string(entity).size(), sign);
    texts.push_back(text);
  }
  return texts;
}

std::set<std::string> words_in(const std::string& text) {
  std::set<std::string> words;
  std::string word;
  for (const char c : text + " ") {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalpha(byte) != 0 || byte >= 0xC3)
      word += static_cast<char>(std::tolower(byte));
    else if (byte >= 0x80 && !word.empty())
      word += c;
    else {
      if (word.size() > 1) words.insert(word);
      word.clear();
    }
  }
  return words;
}

/// Words of the catalogue's English that its German does not have.
const std::set<std::string>& english_words() {
  static const std::set<std::string> words = [] {
    std::set<std::string> english, other;
    for (const auto& entry : german().entries()) {
      for (const auto& part : entry.english)
        if (part.kind == Catalogue::Part::Kind::words) english.merge(words_in(part.text));
      for (const auto& part : entry.other)
        if (part.kind == Catalogue::Part::Kind::words) other.merge(words_in(part.text));
    }
    for (const std::string& word : other) english.erase(word);
    return english;
  }();
  return words;
}

/// Texts with an English word once what was given is taken out of them.
std::vector<std::string> english_in(const std::vector<std::string>& texts, const std::vector<std::string>& given) {
  std::vector<std::string> found;
  for (std::string text : texts) {
    const std::string whole = text;
    for (const std::string& name : given)
      for (std::size_t at = 0; (at = text.find(name, at)) != std::string::npos;) text.erase(at, name.size());
    for (const std::string& word : words_in(text))
      if (english_words().contains(word)) {
        found.push_back(word + ": " + whole);
        break;
      }
  }
  return found;
}

/// The example with what a page may have beside: facades that nobody confirmed, a doubt, a misfit, changes.
ReportInput full_example() {
  ReportInput input = test::example();
  input.deviation->misfits.push_back(std::make_unique<MeasurementDoubtT>(plumbline::test::doubt("REASON")));
  input.deviation->misfits.back()->grade = DoubtGrade::misfit, input.deviation->misfits.back()->factor = 1.7;
  input.deviation->requests.push_back(std::make_unique<JudgementRequestT>());
  input.deviation->requests.back()->asked = "class=IfcPlat: vertical=5mm",
  input.deviation->requests.back()->by = "rule";
  input.deviation->requests.back()->not_judged = "it selects no anchor of the plate table";
  input.grid = {{"A", "u", {0, 0, 0}, {1, 0, 0}}, {"1", "v", {2, -5, 0}, {0, 1, 0}}};
  AsBuiltChangesT changes;
  changes.compared = true, changes.before = "2026-05", changes.measured_twice = 3;
  for (const ChangeKind kind :
       {ChangeKind::mended, ChangeKind::opened_again, ChangeKind::unseen, ChangeKind::left_out}) {
    auto change = std::make_unique<AsBuiltChangeT>();
    change->kind = "anchor", change->id = "F01-C01-R1", change->floor = 1, change->before = ToleranceVerdict::fail;
    change->after = ToleranceVerdict::pass, change->change = kind, change->moved = kind == ChangeKind::mended;
    change->movement = {0.004, -0.0012, 0}, change->u = 0.0005;
    changes.changes.push_back(std::move(change));
  }
  input.changes = std::move(changes);
  return input;
}

const std::vector<std::string> kGiven = {"Facade anchors, full height",
                                         "Example building, south facade, 5 floors. Campaign of 12 May 2025",
                                         "Points F05-C01-R1 and F05-C02-R1 are seen from two set-ups only.",
                                         "full_height",
                                         "REASON",
                                         "name~^C-: azimuth=135deg",
                                         "Level ",
                                         "campaign.yaml",
                                         "observations.csv",
                                         "survey/station1.gsi",
                                         "station1.gsi",
                                         "station2.gsi",
                                         "station3.gsi",
                                         "station4.gsi",
                                         "60303ae22b998861bce3b28f33eec1be758a213c86c93c076dbe9f558c11c752",
                                         "survey/station1.gsi",
                                         "class=IfcPlat: vertical=5mm",
                                         "guid of ",
                                         "panel0",
                                         "panel1",
                                         "panel2",
                                         "panel3"};

TEST(German, NoEnglishWordIsLeftOnAPage) {
  const Speaking speaking(kGerman);
  const ReportInput input = full_example();
  for (const std::string& text : english_in(texts_read(render_report(input)), kGiven))
    ADD_FAILURE() << "report: " << text;
  for (const std::string& text : english_in(texts_read(render_sheets(input)), kGiven))
    ADD_FAILURE() << "sheets: " << text;
  ReportInput quiet = test::example();  // without a design: the pages of what was measured alone
  quiet.deviation.reset();
  for (const std::string& text : english_in(texts_read(render_report(quiet)), kGiven))
    ADD_FAILURE() << "report: " << text;
}

TEST(German, NoEnglishWordIsLeftInTheSummary) {
  const Speaking speaking(kGerman);
  const ReportInput input = full_example();
  const std::string text = summary_text(input.accuracy, &*input.deviation, &*input.changes);
  for (const std::string& line : english_in({text}, kGiven)) ADD_FAILURE() << line;
  EXPECT_NE(text.find("Toleranz 5,00 mm"), std::string::npos) << text;
}

/// The test above would find one.
TEST(German, AnEnglishWordIsFound) {
  EXPECT_EQ(english_in({"Anker außerhalb, alles unentschieden"}, {}).size(), 0u);
  EXPECT_EQ(english_in({"Anker nicht measured"}, {}).size(), 1u);
  EXPECT_EQ(english_in({"Measure it."}, {}).size(), 1u);
}

TEST(German, NamesStayAsTheyAre) {
  const Speaking speaking(kGerman);
  ReportInput input = test::example();
  input.deviation->anchors[0]->id = input.accuracy.anchors[0]->id = "Floor";
  for (auto& panel : input.deviation->panels)
    for (auto& fixing : panel->fixings)
      if (fixing->anchor == "F01-C01-R1") fixing->anchor = "Floor";
  input.deviation->panels[0]->name = "Panel 3";
  const std::string html = render_report(input);
  EXPECT_NE(html.find("<th scope=\"row\">Floor</th>"), std::string::npos);
  EXPECT_NE(html.find("<th scope=\"row\">Panel 3</th>"), std::string::npos);
  for (const char mark : {'\x01', '\x02', '\x03'}) EXPECT_EQ(html.find(mark), std::string::npos) << "a mark came out";
}

TEST(German, EnglishIsAsItWas) {
  const ReportInput input = full_example();
  const std::string before = render_report(input);
  {
    const Speaking speaking(kGerman);
    EXPECT_NE(render_report(input), before);
  }
  EXPECT_EQ(render_report(input), before) << "a language ends with its scope";
  EXPECT_EQ(before.find("id=\"spoken\">"), std::string::npos);
  EXPECT_EQ(spoken("Measure it."), "Measure it.");
}

/// Numbers of a text; a fraction in brackets says one again and does not count.
std::vector<std::string> numbers_of(const std::string& text) {
  const std::string plain = std::regex_replace(text, std::regex(" \\((?:\\d+-)?\\d+(?:/\\d+)?\\)"), "");
  std::vector<std::string> numbers;
  const std::regex number("\\d+(?:\\.\\d+)?");
  for (std::sregex_iterator at(plain.begin(), plain.end(), number), end; at != end; ++at) numbers.push_back(at->str());
  return numbers;
}

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
      const auto was = numbers_of(before[i]), is = numbers_of(after[i]);
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
  EXPECT_EQ(spoken(mm(0.0127, 1) + " ± " + mm(0.000254, 1) + "\u00A0mm"), "0.500 ± 0.010\u00A0in");
  const Speaking both({Language::german, Units::inches});
  EXPECT_EQ(spoken("joint to P2 12.7 mm (limit 5 mm)"), "Fuge zu P2 0,500\u00A0Zoll (Grenze 0,197\u00A0Zoll)");
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
}

}  // namespace
}  // namespace plumbline::report

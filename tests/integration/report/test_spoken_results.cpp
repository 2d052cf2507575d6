// What pipelines say with language=de has no English sentence: texts and pages of nodes that know nothing of languages,
// which report.words speaks.
#include <regex>
#include <set>
#include <sstream>

#include "program.hpp"
#include "test_paths.hpp"

namespace plumbline::test {
namespace test_spoken_results {

namespace fs = std::filesystem;

std::string pipeline(const std::string& name) {
  return (fs::path(source_dir()) / "pipelines" / (name + ".yaml")).string();
}

/// Lines with a word that English has and German has not. Names that the user gave are none of them here.
std::vector<std::string> english_lines(const std::string& text) {
  static const std::set<std::string> words = {
      "the",   "of",   "and",  "is",    "are",     "were",   "not",   "no",     "nothing", "to",
      "for",   "with", "from", "which", "it",      "its",    "they",  "this",   "that",    "photographs",
      "point", "file", "hang", "floor", "anchors", "panels", "files", "folder", "moves",   "measured",
      "below", "each", "read", "check", "missing", "height", "such",  "waits",  "plates",  "readings"};
  static const std::regex word("[A-Za-z_]+"), code(
                                                  "`[^`]*`|[^ ]+\\.(csv|yaml|ifc)|^(  |# )?[a-z_]+: |\\(Spalten "
                                                  "[^)]*\\)|plumbline .*|<style.*</style>|<[^>]*>");
  std::vector<std::string> found;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    const std::string plain = std::regex_replace(line, code, " ");
    for (std::sregex_iterator at(plain.begin(), plain.end(), word), end; at != end; ++at)
      if (words.contains(at->str())) {
        found.push_back(at->str() + ": " + line);
        break;
      }
  }
  return found;
}

void expect_german(const std::string& what, const std::string& text) {
  EXPECT_NE(text, "") << what;
  for (const std::string& line : english_lines(text)) ADD_FAILURE() << what << " in English, " << line;
}

void expect_german_file(const Program& plumbline, const std::string& file) {
  expect_german(file, read_file(plumbline.work() / file));
}

TEST(SpokenResults, TheTestFindsEnglish) {
  EXPECT_EQ(english_lines("The folder is whole.\n").size(), 1u);
  EXPECT_EQ(english_lines("Der Ordner ist vollständig.\n  plates: plates.csv\n").size(), 0u);
}

TEST(SpokenResults, CampaignInitAndCheck) {
  const Program plumbline;
  plumbline.write("site.yaml",
                  "plumbline: 1\nnodes:\n  site: {use: simulate.campaign, with: {floors: 1, columns: 2, photographs: "
                  "observed}}\noutputs: {campaign: site.folder}\n");
  ASSERT_EQ(plumbline({"run", "site.yaml", "--out", "made"}).code, 0);
  fs::create_directory(plumbline.work() / "ordner");
  Answer answer = plumbline({"campaign", "init", "ordner", "language=de"});
  ASSERT_EQ(answer.code, 0) << answer.err;
  expect_german("init of an empty folder", answer.out);
  EXPECT_TRUE(contains(answer.out, "Keine IFC-Datei gefunden")) << answer.out;
  expect_german_file(plumbline, "ordner/campaign.yaml");
  for (const auto& entry : fs::directory_iterator(plumbline.work() / "made/campaign"))
    if (entry.path().filename() != "campaign.yaml")
      fs::copy(entry.path(), plumbline.work() / "ordner" / entry.path().filename(), fs::copy_options::recursive);
  fs::remove(plumbline.work() / "ordner/campaign.yaml");
  answer = plumbline({"campaign", "init", "ordner", "language=de"});
  ASSERT_EQ(answer.code, 0) << answer.err;
  expect_german("init", answer.out);
  EXPECT_TRUE(contains(answer.out, "\n  plates: plates.csv\n")) << "a key of campaign.yaml is no word: " << answer.out;
  EXPECT_TRUE(contains(answer.out, "\n  control: control.csv\n")) << answer.out;
  expect_german_file(plumbline, "ordner/campaign.yaml");
  EXPECT_TRUE(contains(read_file(plumbline.work() / "ordner/campaign.yaml"), "plates: plates.csv   # welche Marke"));
  answer = plumbline({"campaign", "check", "ordner", "language=de"});
  ASSERT_EQ(answer.code, 0) << answer.err;
  expect_german("check", answer.out);
  EXPECT_TRUE(contains(answer.out, "Als Nächstes: plumbline run site_observations folder=ordner")) << answer.out;
  answer = plumbline({"campaign", "check", "ordner"});
  EXPECT_TRUE(contains(answer.out, "The folder is whole.")) << answer.out;
  EXPECT_TRUE(contains(answer.out, "Next: plumbline run site_observations folder=ordner\n")) << answer.out;
}

TEST(SpokenResults, PlanOfImages) {
  const Program plumbline;
  const Answer answer = plumbline({"run", pipeline("plan_images"), "floors=1", "language=de", "--out", "out"});
  ASSERT_EQ(answer.code, 0) << answer.err;
  expect_german_file(plumbline, "out/verdict.txt");
  EXPECT_TRUE(contains(answer.out, "zu erwartender RMSE in der Höhe 0,")) << answer.out;
}

/// Before a round is done, and what waits, for what.
TEST(SpokenResults, RoundsOfTheLoop) {
  const Program plumbline;
  for (const char* more : {"most=1", "plan.with.setting_sigma=0.004"}) {
    const Answer answer = plumbline(
        {"run", pipeline("execution_loop"), "floors=2", "columns=2", "most=3", more, "language=de", "--out", "out"});
    EXPECT_TRUE(fs::exists(plumbline.work() / "out/next.txt")) << answer.err;
    for (const char* file : {"out/next.txt", "out/summary.txt", "out/installation.txt"})
      expect_german_file(plumbline, file);
    EXPECT_TRUE(contains(answer.out, " Paneelen hängen und sind bestätigt")) << answer.out;
    if (std::string(more) == "most=1") {
      EXPECT_EQ(answer.code, 3);
      EXPECT_TRUE(contains(answer.err, "\nNOT FINISHED (exit code 3): after 1 of at most 1 rounds: ")) << answer.err;
    }
  }
}

TEST(SpokenResults, SeriesOfEpochs) {
  const Program plumbline;
  std::string survey;
  for (const char* name : {"before", "after", "later"}) {
    // "later" is "after" measured once more, distances off by less than 0.1 mm: what moved stays where it is.
    const bool later = std::string(name) == "later";
    const std::string text =
        read_file(fs::path(source_dir()) / "docs/examples" / (later ? "after.csv" : std::string(name) + ".csv"));
    plumbline.write(std::string(name) + ".csv",
                    later ? std::regex_replace(text, std::regex("([0-9]{3})(\n|\r)"), "$013$2") : text);
    survey += (survey.empty() ? "" : ", ") + std::string(name) + ".csv";
  }
  plumbline.write("campaign.yaml", "plumbline_campaign: 1\nsurvey: [" + survey + "]\n");
  const Answer answer =
      plumbline({"run", pipeline("epoch_series"), "folder=.", "profile=total_station_2arcsec", "alarm_level=0.004",
                 "movements.with.days=[0, 30, 60]", "language=de", "--out", "out"});
  ASSERT_EQ(answer.code, 0) << answer.err;
  expect_german_file(plumbline, "out/verdict.txt");
  const std::string page = read_file(plumbline.work() / "out/series.html");
  expect_german("series.html", std::regex_replace(page, std::regex("(</(p|li|td|th|text|h1|h2|strong)>)"), "$1\n"));
  EXPECT_TRUE(contains(page, "<html lang=\"de\">"));
  EXPECT_FALSE(std::regex_search(page, std::regex(">-?[0-9]+\\.[0-9]+</td>"))) << "a decimal point in a cell";
  EXPECT_TRUE(contains(answer.out, "Reihe von 3 Epochen")) << answer.out;
  EXPECT_NE(plumbline({"run", pipeline("epoch_series"), "folder=.", "page.with.units=in", "--out", "inches"}).code, 0)
      << "cells in mm below a head in inches";
}

}  // namespace test_spoken_results
}  // namespace plumbline::test

// What every reader of survey files must do, on the fixtures of all formats: read or refuse with the file's name, the
// same bytes for the same file, and nothing half.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "artifacts/file.hpp"
#include "artifacts/survey_observations.hpp"
#include "kit_fixtures.hpp"
#include "node_harness.hpp"
#include "parameter_effects.hpp"

namespace survey_reader_tests {

using namespace plumbline;
using namespace plumbline::test;
namespace fs = std::filesystem;

FileT file_of(const std::string& name, const std::string& bytes) {
  FileT file;
  file.name = name;
  file.content.assign(bytes.begin(), bytes.end());
  return file;
}

std::vector<fs::path> fixtures() {
  std::vector<fs::path> all;
  for (const auto& entry : fs::directory_iterator(kit_fixtures()))
    if (entry.is_regular_file()) all.push_back(entry.path());
  std::sort(all.begin(), all.end());
  return all;
}

NodeHarness reader(const std::string& kind, const std::string& name, const std::string& bytes) {
  NodeHarness node(kind);
  node.input<File>("file", file_of(name, bytes));
  return node;
}

class SurveyReader : public testing::TestWithParam<std::string> {};

TEST_P(SurveyReader, ReadsOrRefusesEveryFileWithItsName) {
  size_t read = 0;
  for (const fs::path& path : fixtures()) {
    NodeHarness node = reader(GetParam(), path.filename(), read_file(path));
    try {
      node.run();
    } catch (const NodeFailed& failed) {
      EXPECT_NE(std::string(failed.what()).find(path.filename()), std::string::npos) << failed.what();
      EXPECT_EQ(node.output_count("observations"), 0u);
      continue;
    }
    ++read;
    const auto survey = node.output<SurveyObservations>("observations");
    EXPECT_EQ(survey.files, std::vector<std::string>{path.filename()});
    for (const auto& observation : survey.observations) {
      EXPECT_TRUE(std::isfinite(observation->value)) << path;
      EXPECT_LT(observation->set_up, static_cast<int>(survey.set_ups.size()));
      EXPECT_FALSE(observation->to.empty());
    }
  }
  EXPECT_GE(read, 1u) << "no file in " << kit_fixtures() << " is of this reader's format";
}

TEST_P(SurveyReader, GivesTheSameBytesForTheSameFile) {
  for (const fs::path& path : fixtures()) {
    NodeHarness once = reader(GetParam(), "file", read_file(path)), again = reader(GetParam(), "file", read_file(path));
    try {
      once.run();
    } catch (const NodeFailed&) {
      continue;
    }
    again.run();
    EXPECT_EQ(once.output_bytes("observations"), again.output_bytes("observations")) << path;
  }
}

TEST_P(SurveyReader, RefusesFilesWithoutContent) {
  for (const std::string& bytes : {std::string(), std::string(1000, '\0'), std::string("\xFF\xFE"), std::string("<"),
                                   std::string(70000, 'x'), std::string(5000, '\r')}) {
    NodeHarness node = reader(GetParam(), "no-survey.txt", bytes);
    try {
      node.run();
      FAIL() << "read " << bytes.size() << " bytes of nothing";
    } catch (const NodeFailed& failed) {
      EXPECT_NE(std::string(failed.what()).find("no-survey.txt"), std::string::npos) << failed.what();
    }
  }
}

TEST_P(SurveyReader, StrictRefusesWhatIsOtherwiseSkipped) {
  for (const fs::path& path : fixtures()) {
    NodeHarness lenient = reader(GetParam(), path.filename(), read_file(path));
    try {
      lenient.run();
    } catch (const NodeFailed&) {
      continue;
    }
    NodeHarness strict = reader(GetParam(), path.filename(), read_file(path));
    strict.set("strict", "true");
    if (lenient.output<SurveyObservations>("observations").skipped.empty())
      strict.run();
    else
      EXPECT_THROW(strict.run(), NodeFailed) << path;
  }
}

/// The text cut off, and with a line that means nothing: what `strict` refuses.
std::vector<std::string> damaged(const std::string& bytes) {
  std::vector<std::string> all;
  for (const size_t tenths : {5, 9}) {
    const size_t at = bytes.size() * tenths / 10, line = std::min(bytes.find('\n', at), bytes.size() - 1) + 1;
    all.push_back(bytes.substr(0, at));
    all.push_back(bytes.substr(0, line) + "no line of any format ???\n" + bytes.substr(line));
  }
  return all;
}

TEST_P(SurveyReader, EveryDeclaredParameterHasItsEffect) {
  std::vector<std::string> texts, spoilt;
  for (const fs::path& path : fixtures()) {
    const std::string bytes = read_file(path);
    if (reader(GetParam(), "file", bytes).outcome().rfind("failed: ", 0) == 0) continue;
    texts.push_back(bytes);
    for (std::string& one : damaged(bytes)) spoilt.push_back(std::move(one));
  }
  texts.insert(texts.end(), spoilt.begin(), spoilt.end());
  std::vector<Situation> situations;
  for (const std::string& bytes : texts) situations.push_back([bytes] { return reader(GetParam(), "file", bytes); });
  EXPECT_EQ(parameters_at_fault(situations, {"files"}), "");  // `files` is for who looks for a reader
}

INSTANTIATE_TEST_SUITE_P(All, SurveyReader, testing::ValuesIn(kinds_of_role("survey_reader")), test_name);

}  // namespace survey_reader_tests

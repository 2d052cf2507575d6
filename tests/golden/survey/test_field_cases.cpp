// What went wrong in the field, as files: each folder of field/ holds the files of one job and expected.txt, which says
// what the readers and the adjustment have to say of them. One test a folder; a new case needs no code.
//   says TEXT              some warning, finding, skipped place or error holds TEXT
//   first TEXT             the first finding of the result begins with TEXT
//   silent TEXT            none does
//   skipped N              N places could not be read
//   observations N KIND    N observations of that kind were read
//   sigma0 LOW HIGH        the a posteriori sigma0 lies between
//   point ID E N H TOL     [m]
//   distance A B D TOL     between adjusted points [m]
//   rise A B D TOL         height of B over A [m]
//   worst KIND FROM TO PLACE  the observation with the largest |w| is this one
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <sstream>

#include "survey/adjust/adjust_network.hpp"
#include "survey/files/survey_format.hpp"
#include "survey/start/merge_surveys.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_field_cases {

namespace fs = std::filesystem;

/// The job read, merged and adjusted as a free network (or as its files say), and everything that was said of it.
struct Outcome {
  SurveyObservations survey;
  std::optional<NetworkResult> result;
  std::vector<std::string> said;

  std::string all() const {
    std::string text;
    for (const std::string& line : said) text += "\n  " + line;
    return text;
  }
  bool says(const std::string& what) const {
    return std::any_of(said.begin(), said.end(),
                       [&](const std::string& s) { return s.find(what) != std::string::npos; });
  }
};

Outcome run(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().filename() != "expected.txt") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  Outcome out;
  try {
    std::vector<SurveyObservations> parts;
    for (const fs::path& file : files) {
      parts.push_back(read_survey(test::read_file(file), file.filename().string()));
      for (const std::string& warning : parts.back().warnings) out.said.push_back(warning);
      for (const SkippedLine& s : parts.back().skipped)
        out.said.push_back(place(s.source) + ": found " + s.found + ", expected " + s.expected);
    }
    MergedSurvey merged = merge_surveys(parts);
    out.survey = std::move(merged.survey);
    for (const Finding& f : merged.findings) out.said.push_back(f.text);
    AdjustOptions options;
    options.profile = built_in_profile("total_station_1arcsec");
    out.result = adjust_network(out.survey, options);
    for (const Finding& f : out.result->findings) out.said.push_back(f.text);
  } catch (const std::exception& error) {
    out.said.emplace_back(error.what());
  }
  return out;
}

class Check {
 public:
  Check(const Outcome& outcome, const std::string& line) : out_(outcome), line_(line), in_(line) { in_ >> verb_; }

  void run() {
    const std::string rest = line_.size() > verb_.size() ? line_.substr(verb_.size() + 1) : "";
    if (verb_ == "says") {
      EXPECT_TRUE(out_.says(rest)) << rest << "\nwas not said; but:" << out_.all();
    } else if (verb_ == "silent") {
      EXPECT_FALSE(out_.says(rest)) << rest << "\nwas said:" << out_.all();
    } else if (verb_ == "skipped") {
      EXPECT_EQ(out_.survey.skipped.size(), number()) << out_.all();
    } else if (verb_ == "observations") {
      count();
    } else {
      ASSERT_TRUE(out_.result) << line_ << "\nbut there is no result:" << out_.all();
      of_result(rest);
    }
  }

 private:
  double number() {
    double value = 0;
    in_ >> value;
    EXPECT_FALSE(in_.fail()) << line_;
    return value;
  }
  std::string word() {
    std::string text;
    in_ >> text;
    return text;
  }
  Eigen::Vector3d position(const std::string& id) {
    for (const ResultPoint& p : out_.result->points)
      if (p.id == id) return p.position;
    ADD_FAILURE() << "no point " << id;
    return Eigen::Vector3d::Constant(kNotGiven);
  }

  void count() {
    const double wanted = number();
    const std::string kind = word();
    size_t found = 0;
    for (const Observation& o : out_.survey.observations)
      found += (o.kind == ObservationKind::height_difference && kind == "height_difference") ||
               (o.kind == ObservationKind::horizontal_distance && kind == "horizontal_distance") ||
               (o.kind == ObservationKind::slope_distance && kind == "slope_distance") ||
               (o.kind == ObservationKind::direction && kind == "direction");
    EXPECT_EQ(found, wanted) << line_;
  }

  void of_result(const std::string& rest) {
    const NetworkResult& r = *out_.result;
    if (verb_ == "first") {
      ASSERT_FALSE(r.findings.empty());
      EXPECT_EQ(r.findings.front().text.substr(0, rest.size()), rest) << out_.all();
    } else if (verb_ == "sigma0") {
      EXPECT_GE(r.sigma0, number()) << out_.all();
      EXPECT_LE(r.sigma0, number()) << out_.all();
    } else if (verb_ == "point") {
      const Eigen::Vector3d at = position(word());
      const Eigen::Vector3d expected{number(), number(), number()};  // braces: in this order
      const double tolerance = number();
      EXPECT_LT((at - expected).norm(), tolerance) << line_ << "\nis at " << at.transpose() << out_.all();
    } else if (verb_ == "distance" || verb_ == "rise") {
      const Eigen::Vector3d a = position(word()), b = position(word());
      const double found = verb_ == "rise" ? b.z() - a.z() : (b - a).norm();
      const double expected = number(), tolerance = number();
      EXPECT_NEAR(found, expected, tolerance) << line_ << out_.all();
    } else if (verb_ == "worst") {
      const auto worst = std::max_element(r.rows.begin(), r.rows.end(), [](const ResultRow& a, const ResultRow& b) {
        return std::abs(a.statistics.w) < std::abs(b.statistics.w);
      });
      const std::string kind = word(), from = word(), to = word(), where = word();  // kinds of one word only
      EXPECT_EQ(worst->kind + " " + worst->from + " " + worst->to, kind + " " + from + " " + to) << out_.all();
      EXPECT_EQ(place(worst->source).substr(0, where.size()), where);
    } else {
      ADD_FAILURE() << "'" << verb_ << "' is no check that expected.txt knows";
    }
  }

  const Outcome& out_;
  std::string line_, verb_;
  std::istringstream in_;
};

fs::path field_folder() { return fs::path(test::source_dir()) / "tests/golden/survey/field"; }

std::vector<std::string> cases() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(field_folder()))
    if (fs::exists(entry.path() / "expected.txt")) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

class FieldCase : public ::testing::TestWithParam<std::string> {};

TEST_P(FieldCase, IsSaidAsExpected) {
  const fs::path folder = field_folder() / GetParam();
  const Outcome outcome = run(folder);
  std::istringstream expected(test::read_file(folder / "expected.txt"));
  int checks = 0;
  for (std::string line; std::getline(expected, line);) {
    if (line.empty() || line[0] == '#') continue;
    Check(outcome, line).run();
    ++checks;
  }
  EXPECT_GT(checks, 0);
}

INSTANTIATE_TEST_SUITE_P(Folders, FieldCase, ::testing::ValuesIn(cases()),
                         [](const auto& folder) { return folder.param; });

}  // namespace test_field_cases
}  // namespace plumbline::survey

// verdict.js of the page against verdict_at() of the judgement, and both against a judgement at that tolerance. Node.js
// runs the file as it stands; without it the test is skipped.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "building/judgement/conformance.hpp"
#include "show/report/script_data.hpp"
#include "test_support.hpp"

namespace plumbline::report {
namespace test_verdict_rule {

using judgement::conformance;
using judgement::Conformance;
using judgement::Limited;
using judgement::verdict_at;

constexpr double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();

/// What the script answers to cases, each "[given, [pass, fail], tolerance in mm, doubt]".
std::vector<int> answers_of_script(const std::vector<std::string>& cases) {
  const test::TemporaryFolder folder;
  std::string list = "[";
  for (const std::string& one : cases) list += (list.size() > 1 ? ",\n" : "") + one;
  std::ofstream(folder.path() / "cases.json") << list << "]";
  std::ofstream(folder.path() / "ask.js")
      << "const fs = require('fs'), [rule, cases, out] = process.argv.slice(2).map(f => f);\n"
         "const verdictAt = new Function(fs.readFileSync(rule, 'utf8') + '; return verdictAt;')();\n"
         "fs.writeFileSync(out, JSON.stringify(JSON.parse(fs.readFileSync(cases, 'utf8')).map(c => "
         "verdictAt(...c))));\n";
  const std::string at = folder.path().string() + "/";
  const std::string command = "node " + at + "ask.js " + std::string(test::source_dir()) +
                              "/plugins/show/report/verdict.js " + at + "cases.json " + at + "answers.json";
  if (std::system(command.c_str()) != 0) throw std::runtime_error("failed: " + command);
  return nlohmann::json::parse(test::read_file(folder.path() / "answers.json")).get<std::vector<int>>();
}

struct Case {
  ToleranceVerdict given;
  double pass, fail, millimetres;
  bool doubt;
  std::string text() const {
    return "[" + std::to_string(static_cast<int>(given)) + ",[" + script_exact(pass) + "," + script_exact(fail) + "]," +
           script_exact(millimetres) + "," + (doubt ? "true" : "false") + "]";
  }
  int verdict() const { return static_cast<int>(verdict_at(given, pass, fail, millimetres / 1e3, doubt)); }
};

bool has_node() { return std::system("node --version >/dev/null 2>&1") == 0; }

TEST(VerdictRule, TheScriptIsTheProgram) {
  if (!has_node()) GTEST_SKIP() << "node is not installed (apt install nodejs)";
  std::vector<Case> cases;
  // The slider's steps, and borders that lie exactly on them, one bit below and one above.
  for (int step = 5; step <= 205; ++step)
    for (const double beside : {-inf, 0.0, inf}) {
      const double mm = step / 10.0, border = mm / 1e3,
                   turned = std::isinf(beside) ? std::nextafter(border, beside) : border;
      for (const bool doubt : {false, true}) {
        cases.push_back({ToleranceVerdict::undecided, turned, border / 2, mm, doubt});
        cases.push_back({ToleranceVerdict::fail, 2 * border, turned, mm, doubt});
      }
    }
  for (const auto given :
       {ToleranceVerdict::not_measured, ToleranceVerdict::pass, ToleranceVerdict::undecided, ToleranceVerdict::fail})
    for (const double pass : {0.0, 0.004, inf, nan})
      for (const double fail : {0.0, 0.004, inf, nan})
        for (const double mm : {1.0, 3.9, 4.0, 4.1, 20.0})
          for (const bool doubt : {false, true}) cases.push_back({given, pass, fail, mm, doubt});
  std::vector<std::string> texts;
  for (const Case& one : cases) texts.push_back(one.text());
  const std::vector<int> answers = answers_of_script(texts);
  ASSERT_EQ(answers.size(), cases.size());
  std::set<int> seen;
  for (size_t i = 0; i < cases.size(); ++i) {
    EXPECT_EQ(answers[i], cases[i].verdict()) << texts[i];
    seen.insert(answers[i]);
  }
  EXPECT_EQ(seen.size(), 4u) << "not every verdict was asked for";
}

// The rule itself: what turns where conformance() says it does is what a judgement at that tolerance finds.
TEST(VerdictRule, IsAJudgementAtThatTolerance) {
  constexpr double risk = 0.05;
  Eigen::Matrix3d covariance = Eigen::Vector3d(1e-6, 4e-6, 2e-6).asDiagonal();
  covariance(0, 1) = covariance(1, 0) = 1e-6;
  int verdicts[4] = {};
  for (const double offset : {0.0, 0.002, 0.006}) {
    const Eigen::Vector3d mean(offset, -0.5 * offset, 0.001);
    const auto judged = [&](double tau, bool narrow) {
      std::vector<Limited> limits;
      for (int k = 0; k < 3; ++k) limits.push_back({Eigen::Matrix3d::Identity().row(k), tau, tau, true});
      if (narrow)
        limits.push_back({Eigen::Matrix3d::Identity().row(0), 1e-6, 1e-6, false});  // fails at every tolerance
      return conformance(mean, covariance, limits, risk, tau);
    };
    for (const bool narrow : {false, true}) {
      const Conformance at_five = judged(0.005, narrow);
      for (const double border : {at_five.tau_pass, at_five.tau_fail})
        for (const double relative : {0.5, 1 - 1e-9, 1 + 1e-9, 2.0}) {
          const double tau = std::isinf(border) ? 0.01 * relative : border * relative;
          const auto there = judgement::verdict_of(judged(tau, narrow).probability, risk);
          EXPECT_EQ(verdict_at(ToleranceVerdict::undecided, at_five.tau_pass, at_five.tau_fail, tau, false), there)
              << offset << " " << narrow << " tau " << tau << " turns at " << at_five.tau_pass << " and "
              << at_five.tau_fail;
          ++verdicts[static_cast<int>(there)];
        }
    }
  }
  for (const auto one : {ToleranceVerdict::pass, ToleranceVerdict::undecided, ToleranceVerdict::fail})
    EXPECT_GT(verdicts[static_cast<int>(one)], 0);
}

}  // namespace test_verdict_rule
}  // namespace plumbline::report

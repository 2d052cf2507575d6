// What the tests of survey readers and writers share: fixtures, look-ups, random surveys and their comparison.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "survey/model/survey_observations.hpp"
#include "test_support.hpp"

namespace plumbline::survey::test_help {

inline constexpr double kGon = std::numbers::pi / 200;
inline constexpr double kDegree = std::numbers::pi / 180;

inline std::string fixture(const std::string& name) {
  return test::read_file(std::filesystem::path(plumbline::test::source_dir()) / "tests/unit/survey_files/fixtures" /
                         name);
}

/// The observation of `kind` in pointing number `pointing`; throws if there is none.
const Observation& observation(const SurveyObservations& survey, int pointing, ObservationKind kind);
double value(const SurveyObservations& survey, int pointing, ObservationKind kind);
const Point& point(const SurveyObservations& survey, const std::string& id);

/// Whether something at that place was skipped and its message holds `expected`.
bool skipped(const SurveyObservations& survey, int line, int column, const std::string& expected);

/// Text of the SurveyReadError that `read` throws.
template <typename Read>
std::string error_of(Read read) {
  try {
    read();
  } catch (const SurveyReadError& error) {
    return error.what();
  }
  return "no error";
}

/// Small generator of the tests; the standard distributions differ between libraries.
struct Random {
  unsigned long long state;
  double uniform(double low, double high) {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return low + (high - low) * static_cast<double>(state >> 11) / 9007199254740992.0;
  }
};

/// Three set-ups with 20 pointings each to eight points, names with blanks and umlauts; deterministic in `seed`.
SurveyObservations random_survey(unsigned long long seed);

/// Compares set-ups and observations (heights as they act) to `tolerance` [rad, m].
void expect_same(const SurveyObservations& a, const SurveyObservations& b, double tolerance);

}  // namespace plumbline::survey::test_help

// The analysis as text: for spreadsheets, programs, READMEs and papers.
#pragma once

#include <string>

#include "show/bench/analysis.hpp"

namespace plumbline::bench {

std::string to_csv(const Bench& bench);  ///< one line a cell, failed and missing ones too; RFC 4180
std::string to_json(const Bench& bench, const Analysis& analysis);
std::string to_markdown(const Bench& bench, const Analysis& analysis);
/// Macros: \bench{full height/adjust.ceres/rmse} prints the number in mm, and ?? if there is none of that name;
/// \benchtable is the table for booktabs, \benchparagraph what came out in words.
std::string to_tex(const Bench& bench, const Analysis& analysis);

/// "12.3": so many decimals that the half width of the interval keeps two digits; "–" for nan.
std::string number_text(double value, double uncertainty);
/// One line for each place, alternative and part of the errors of which something is stated: what was predicted over
/// what was found with its interval, NEES and the band of an honest covariance, and the words of the verdict where it
/// is one.
struct StatedPart {
  std::string place, name, part, ratio, nees, verdict;
};
std::vector<StatedPart> stated_parts(const Analysis& analysis);

std::string cost_text(double cost);  ///< six digits, "–" if it is not known
std::string interval_text(const statistics::Estimate& estimate, double scale);  ///< "0.24 (0.21–0.28)"

/// "all with private=0 of the command line"; empty without any.
std::string overrides_text(const Bench& bench);

/// What stands above every table: how many cells, trials, failures, and what was set for all of them.
std::string coverage_text(const Bench& bench, const Analysis& analysis);

}  // namespace plumbline::bench

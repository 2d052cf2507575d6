// What a paper takes in: numbers by their names, the table, and a paragraph.
#include <fmt/core.h>

#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "show/bench/sentences.hpp"
#include "show/bench/tables.hpp"

namespace plumbline::bench {

using statistics::Estimate;

namespace {

std::string one_line(std::string text) {
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  return text;
}

/// Names of places and alternatives without the characters that \csname cannot take, no two the same. One that needs
/// no change keeps itself, whatever others become.
class TexNames {
 public:
  explicit TexNames(const Analysis& analysis) {
    for (const Row& row : analysis.rows) keep(row.place), keep(row.name);
    for (const Duel& duel : analysis.duels) keep(duel.place), keep(duel.first), keep(duel.second);
  }
  std::string of(const std::string& name) {
    if (const auto known = names_.find(name); known != names_.end()) return known->second;
    const std::string plain = plain_of(name);
    std::string unique = plain;
    for (int n = 2; !taken_.insert(unique).second; ++n) unique = plain + "-" + std::to_string(n);
    return names_[name] = unique;
  }
  /// A comment line for each name that is written otherwise.
  std::string legend() const {
    std::string text;
    for (const auto& [name, written] : names_)
      if (name != written) text += "% " + one_line(name) + " is written " + written + "\n";
    return text;
  }

 private:
  static std::string plain_of(std::string name) {
    for (char& c : name)
      if (std::string("\\{}%#&~^$_\r\n").find(c) != std::string::npos) c = '-';
    for (std::size_t at; (at = name.find("·")) != std::string::npos;) name.replace(at, std::string("·").size(), "+");
    return name;
  }
  void keep(const std::string& name) {
    if (plain_of(name) == name) names_[name] = name, taken_.insert(name);
  }

  std::map<std::string, std::string> names_;
  std::set<std::string> taken_;
};

/// Text as TeX prints it, on one line.
std::string tex_text(const std::string& text) {
  static const std::map<std::string, std::string> written = {{"\\", "\\textbackslash{}"},
                                                             {"~", "\\textasciitilde{}"},
                                                             {"^", "\\textasciicircum{}"},
                                                             {"{", "\\{"},
                                                             {"}", "\\}"},
                                                             {"%", "\\%"},
                                                             {"#", "\\#"},
                                                             {"&", "\\&"},
                                                             {"$", "\\$"},
                                                             {"_", "\\_"},
                                                             {"<", "\\textless{}"},
                                                             {">", "\\textgreater{}"}};
  std::string result;
  for (const char c : one_line(text)) {
    const auto special = written.find(std::string(1, c));
    result += special == written.end() ? std::string(1, c) : special->second;
  }
  for (const auto& [sign, as] :
       {std::pair<std::string, std::string>{"–", "--"}, {"·", "\\textperiodcentered{}"}, {"²", "\\textsuperscript{2}"}})
    for (std::size_t at = 0; (at = result.find(sign, at)) != std::string::npos; at += as.size())
      result.replace(at, sign.size(), as);
  return result;
}

/// One row an alternative, places apart from each other; what was not measured has no column.
std::string table(const Bench& bench, const Analysis& analysis) {
  const bool places = bench.places().size() > 1;
  bool bias = false, predicted = false, nees = false;
  for (const Row& row : analysis.rows) {
    bias |= std::isfinite(row.summary.bias.value), predicted |= std::isfinite(row.summary.predicted.value);
    nees |= std::isfinite(row.summary.nees);
  }
  std::string text = "\\newcommand{\\benchtable}{%\n\\begin{tabular}{" + std::string(places ? "ll" : "l") + "rrr" +
                     std::string(static_cast<std::size_t>(bias + predicted + nees), 'r') + "}\n\\toprule\n" +
                     (places ? "Place & " : "") + "Alternative & Trials & Failed & RMSE [mm]" +
                     (bias ? " & Bias [mm]" : "") + (predicted ? " & Stated [mm]" : "") + (nees ? " & NEES" : "") +
                     " \\\\\n\\midrule\n";
  std::string last = analysis.rows.empty() ? "" : analysis.rows.front().place;
  bool first = true;
  for (const Row& row : analysis.rows) {
    const auto& s = row.summary;
    if (row.place != last) text += "\\addlinespace\n";
    if (places) text += (first || row.place != last ? tex_text(row.place) : "") + " & ";
    last = row.place, first = false;
    text += tex_text(row.name) + " & " + std::to_string(s.trials) + " & " + std::to_string(s.failures) + " & " +
            tex_text(interval_text(s.rmse, 1e3) + own_trials_mark(row));
    if (bias) text += " & " + tex_text(interval_text(s.bias, 1e3));
    if (predicted) text += " & " + tex_text(interval_text(s.predicted, 1e3));
    if (nees) text += " & " + tex_text(number_text(s.nees, 0.1));
    text += " \\\\\n";
  }
  return text + "\\bottomrule\n\\end{tabular}}\n";
}

/// What ran, what to choose, what covariances state, and how intervals and tests were made.
std::string paragraph(const Bench& bench, const Analysis& analysis) {
  std::string text = coverage_text(bench, analysis) + ".";
  for (const auto& sentences : {choices_to_make(bench, analysis), calibration_verdicts(analysis)})
    for (const std::string& sentence : sentences) text += " " + sentence + (sentence.ends_with('.') ? "" : ".");
  return "\\newcommand{\\benchparagraph}{%\n" + tex_text(text + " " + method_text(bench, analysis)) + "}\n";
}

}  // namespace

std::string to_tex(const Bench& bench, const Analysis& analysis) {
  std::string text =
      "% " + one_line(bench.title) +
      "\n% \\bench{place/alternative/quantity}: millimetres, seconds and plain numbers; quantities rmse, "
      "rmse-low, rmse-high,\n% bias, predicted, efficiency, nees, failures, trials, seconds. "
      "\\benchdiff{place/first/second}: mm, -low, -high.\n"
      "% \\benchtable: all rows (\\usepackage{booktabs}); \\benchparagraph: what came out, in words.\n"
      "\\makeatletter\n"
      "\\newcommand{\\bench}[1]{\\ifcsname bench@#1\\endcsname\\csname bench@#1\\endcsname\\else\\textbf{??}\\fi}\n"
      "\\newcommand{\\benchdiff}[1]{\\bench{diff/#1}}\n";
  TexNames names(analysis);
  // What is not defined prints ??, so that nothing that does not exist is quoted as a number; nor is what two things
  // would be quoted by ("a/b" with "c", "a" with "b/c").
  std::vector<std::pair<std::string, std::string>> defined;
  std::map<std::string, int> times;
  const auto define = [&](const std::string& name, const std::string& value) {
    ++times[name];
    if (value != "–") defined.emplace_back(name, value);
  };
  define("cells", std::to_string(analysis.cells));
  define("seeds", std::to_string(analysis.seeds));
  for (const Row& row : analysis.rows) {
    const auto& s = row.summary;
    const std::string name = names.of(row.place.empty() ? "all" : row.place) + "/" + names.of(row.name) + "/";
    const double half = 0.5e3 * (s.rmse.interval.upper - s.rmse.interval.lower);
    define(name + "rmse", number_text(1e3 * s.rmse.value, half));
    define(name + "rmse-low", number_text(1e3 * s.rmse.interval.lower, half));
    define(name + "rmse-high", number_text(1e3 * s.rmse.interval.upper, half));
    define(name + "bias", number_text(1e3 * s.bias.value, half));
    define(name + "predicted", number_text(1e3 * s.predicted.value, half));
    define(name + "efficiency", number_text(s.efficiency.value, 0.01));
    define(name + "nees", number_text(s.nees, 0.1));
    define(name + "trials", std::to_string(s.trials));
    define(name + "failures", std::to_string(s.failures));
    define(name + "seconds", number_text(row.seconds, 0.5 * row.seconds));
  }
  for (const Duel& duel : analysis.duels) {
    if (!duel.refused.empty() || (duel.overall && !duel.weighted)) continue;
    const Estimate& d = duel.errors.difference;
    const double half = 0.5e3 * (d.interval.upper - d.interval.lower);
    const std::string name = "diff/" + names.of(duel.overall || duel.place.empty() ? "all" : duel.place) + "/" +
                             names.of(duel.first) + "/" + names.of(duel.second);
    define(name, number_text(1e3 * d.value, half));
    define(name + "-low", number_text(1e3 * d.interval.lower, half));
    define(name + "-high", number_text(1e3 * d.interval.upper, half));
  }
  std::string definitions, ambiguous;
  for (const auto& [name, value] : defined)
    if (times.at(name) == 1) definitions += "\\expandafter\\def\\csname bench@" + name + "\\endcsname{" + value + "}\n";
  for (const auto& [name, count] : times)
    if (count > 1) ambiguous += "% " + name + " could be one or another thing here, and is neither\n";
  return text + names.legend() + ambiguous + definitions + "\\makeatother\n" + table(bench, analysis) +
         paragraph(bench, analysis);
}

}  // namespace plumbline::bench

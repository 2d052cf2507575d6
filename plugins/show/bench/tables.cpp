#include "show/bench/tables.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "base/text/csv_table.hpp"
#include "show/bench/sentences.hpp"

namespace plumbline::bench {

using Json = nlohmann::ordered_json;
using statistics::Estimate;

namespace {

std::string shortest(double value) { return std::isfinite(value) ? Json(value).dump() : ""; }

Json estimate_json(const Estimate& estimate) {
  return {{"value", estimate.value}, {"lower", estimate.interval.lower}, {"upper", estimate.interval.upper}};
}

Json calibration_json(const statistics::TrialSummary& summary) {
  Json list = Json::array();
  for (const auto& part : summary.calibration)
    list.push_back({{"part", part.mode.empty() ? "all that is measured" : part.mode},
                    {"predicted_by_found", estimate_json(part.ratio)},
                    {"nees", part.nees},
                    {"band", {part.nees_band.lower, part.nees_band.upper}},
                    {"words", in_words(part)}});
  return list;
}

Json row_json(const Row& row) {
  const auto& s = row.summary;
  Json json{{"place", row.place},
            {"choices", row.choices},
            {"trials", s.trials},
            {"failures", s.failures},
            {"missing", row.missing},
            {"did_not_run", row.unplanned},
            {"own_trials", row.own_trials},
            {"rmse", estimate_json(s.rmse)},
            {"mean", estimate_json(s.mean)},
            {"bias", estimate_json(s.bias)},
            {"predicted", estimate_json(s.predicted)},
            {"efficiency", estimate_json(s.efficiency)},
            {"nees", {{"value", s.nees}, {"band", {s.nees_band.lower, s.nees_band.upper}}}},
            {"calibration", calibration_json(s)},
            {"seconds", row.seconds},
            {"start_cost", row.start_cost},
            {"final_cost", row.final_cost}};
  json["failure_rates"] = Json::array();
  for (const auto& rate : s.failure_rates)
    json["failure_rates"].push_back({{"tau", rate.tau},
                                     {"failed", rate.failed},
                                     {"share", rate.share},
                                     {"lower", rate.interval.lower},
                                     {"upper", rate.interval.upper}});
  return json;
}

Json duel_json(const Duel& duel) {
  Json json{{"group", duel.group}, {"first", duel.first}, {"second", duel.second}};
  json["place"] = duel.overall ? Json() : Json(duel.place);
  json["words"] = duel.words;
  if (!duel.refused.empty()) {
    json["refused"] = duel.refused;
    if (duel.never_ran) json["never_ran"] = true;
    return json;
  }
  if (duel.repeated > 0) json["seeds_of_one_trial"] = duel.repeated;
  json["pairs"] = duel.errors.pairs;
  json["seeds"] = duel.errors.seeds;
  json["lost_by_first"] = duel.errors.lost_first;
  json["lost_by_second"] = duel.errors.lost_second;
  json["time_ratio"] = estimate_json(duel.times.ratio);
  json["time_confirmed"] = duel.times.confirmed;
  json["time_words"] = duel.time_words;
  if (duel.errors.spread)
    json["spread"] = {{"places", duel.errors.spread->places},
                      {"deviation", duel.errors.spread->deviation},
                      {"lowest", duel.errors.spread->lowest},
                      {"highest", duel.errors.spread->highest}};
  if (duel.overall && !duel.weighted) return json;
  json["verdict"] = to_text(duel.errors.verdict);
  if (duel.untested) json["untested"] = true;
  json["places"] = duel.errors.places;
  json["places_left_out"] = duel.errors.left_out;
  json["difference"] = estimate_json(duel.errors.difference);
  json["narrow"] = {duel.errors.narrow.lower, duel.errors.narrow.upper};
  json["improvement"] = estimate_json(duel.errors.improvement);
  json["p"] = duel.errors.p;
  json["adjusted_p"] = duel.errors.adjusted_p;
  json["share_lost"] = duel.errors.share_lost;
  json["p_lost"] = duel.errors.p_lost;
  json["adjusted_p_lost"] = duel.errors.adjusted_p_lost;
  json["standard_deviation_of_a_seed"] = duel.errors.deviation;
  return json;
}

/// `holds` is the last value at which half of the sites hold, null if they do not at the first one.
Json breakdown_json(const Breakdown& b) {
  const auto value = [&](std::size_t count) { return count == 0 ? Json() : Json(b.values[count - 1]); };
  Json json{{"variable", b.variable}, {"place", b.place},   {"name", b.name},          {"tolerance", b.tolerance},
            {"sites", b.sites},       {"values", b.values}, {"holds", value(b.median)}};
  if (!b.excluded.empty()) json["excluded"] = b.excluded;
  if (b.open > 0) json["open_sites"] = b.open, json["holds_at_most"] = value(b.at_most);
  if (b.has_interval()) json["interval"] = {value(b.lower), value(b.upper)};
  return json;
}

std::string table_cell(std::string text) {
  for (char& c : text)
    if (c == '\n' || c == '|') c = ' ';
  return text.size() > 400 ? text.substr(0, 400) + " …" : text;
}

std::string one_line(std::string text) {
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  return text;
}

std::string rate_text(const Row& row, double tau) {
  for (const auto& rate : row.summary.failure_rates)
    if (rate.tau == tau)
      return fmt::format("{:.1f} %", 100 * rate.share) + " (" + fmt::format("{:.1f}", 100 * rate.interval.lower) + "–" +
             fmt::format("{:.1f}", 100 * rate.interval.upper) + ")";
  return row.unplanned > 0 ? "did not run" : "–";
}

std::string seeds_text(const std::vector<std::uint64_t>& seeds) {
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(seeds.size(), 5); ++i)
    text += (i ? ", " : "") + std::to_string(seeds[i]);
  return seeds.size() > 5 ? text + ", …" : text;
}

}  // namespace

std::string cost_text(double cost) { return std::isfinite(cost) ? fmt::format("{:.6g}", cost) : "–"; }

std::string number_text(double value, double uncertainty) {
  if (!std::isfinite(value)) return "–";
  int decimals = 3;
  if (std::isfinite(uncertainty) && uncertainty > 0)
    decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(uncertainty))), 0, 6);
  return fmt::format("{:.{}f}", value, decimals);
}

std::string interval_text(const Estimate& estimate, double scale) {
  if (!std::isfinite(estimate.value)) return "–";
  const double half = 0.5 * scale * (estimate.interval.upper - estimate.interval.lower);
  const std::string value = number_text(scale * estimate.value, half);
  if (!std::isfinite(half)) return value;
  const char* joint = estimate.interval.lower < 0 ? " to " : "–";  // "-0.3–-0.1" is not read
  return value + " (" + number_text(scale * estimate.interval.lower, half) + joint +
         number_text(scale * estimate.interval.upper, half) + ")";
}

std::vector<StatedPart> stated_parts(const Analysis& analysis) {
  std::vector<StatedPart> parts;
  for (const Row& row : analysis.rows)
    for (const auto& c : row.summary.calibration) {
      const auto honest = statistics::honesty(c);
      std::string nees = number_text(c.nees, 0.1);
      if (std::isfinite(c.nees) && std::isfinite(c.nees_band.lower))
        nees += " (" + number_text(c.nees_band.lower, 0.1) + "–" + number_text(c.nees_band.upper, 0.1) + ")";
      parts.push_back({row.place, row.name, c.mode.empty() ? "all that is measured" : c.mode, interval_text(c.ratio, 1),
                       nees,
                       honest == statistics::Honesty::too_much     ? "too much"
                       : honest == statistics::Honesty::too_little ? "too little"
                       : honest == statistics::Honesty::honest     ? "right"
                                                                   : "not judged"});
    }
  return parts;
}

std::string overrides_text(const Bench& bench) {
  std::string text;
  for (const std::string& given : bench.overrides) text += (text.empty() ? "all with " : ", ") + one_line(given);
  return text.empty() ? "" : text + " of the command line";
}

std::string coverage_text(const Bench& bench, const Analysis& analysis) {
  std::string text = std::to_string(analysis.cells) + " cells with " + std::to_string(analysis.seeds) +
                     (analysis.seeds == 1 ? " seed: " : " different seeds: ") + std::to_string(analysis.done) +
                     " finished, " + std::to_string(analysis.failed) + " failed, " +
                     std::to_string(analysis.missing - std::min(analysis.missing, bench.behind)) + " not run yet";
  if (bench.behind > 0)
    text += "; judged at the look at the first " + std::to_string(bench.judged_seeds) + " seeds, without " +
            std::to_string(bench.behind) + " cells of later ones that have run";
  if (const std::string given = overrides_text(bench); !given.empty()) text += "; " + given;
  std::size_t excluded = 0;
  for (const Excluded& item : bench.excluded) excluded += item.cells;
  if (excluded > 0) text += "; " + std::to_string(excluded) + " excluded by the file";
  return text;
}

namespace {

/// Names of columns, no two the same: a group may have the name of a variable, or of a column that every table has.
class Columns {
 public:
  explicit Columns(std::set<std::string> fixed) : taken_(std::move(fixed)) {}
  std::string of(const std::string& name, const std::string& what) {
    std::string unique = name;
    while (!taken_.insert(unique).second) unique = what + " " + unique;
    return text::csv_field(unique);
  }

 private:
  std::set<std::string> taken_;
};

}  // namespace

std::string to_csv(const Bench& bench) {
  std::set<std::string> quantities;
  for (const Cell& cell : bench.cells)
    for (const auto& [name, value] : cell.measures) quantities.insert(name);
  const std::string given = overrides_text(bench);
  std::set<std::string> fixed = quantities;
  fixed.insert({"place", "seed", "status", "seconds", "error_text", "overrides"});
  Columns columns(fixed);
  std::string text = "place";
  for (const Variable& variable : bench.variables) text += "," + columns.of(variable.name, "variable");
  for (const Group& group : bench.groups) text += "," + columns.of(group.name, "alternative of");
  text += ",seed,status";
  for (const std::string& quantity : quantities) text += "," + text::csv_field(quantity);
  text += given.empty() ? ",seconds,error_text\r\n" : ",seconds,error_text,overrides\r\n";
  for (const Cell& cell : bench.cells) {
    text += text::csv_field(cell.place);
    for (const Variable& variable : bench.variables) text += "," + text::csv_field(cell.values.at(variable.name));
    for (const Group& group : bench.groups) text += "," + text::csv_field(cell.choices.at(group.name));
    text += "," + std::to_string(cell.seed) + "," + cell.status;
    for (const std::string& quantity : quantities) text += "," + shortest(cell.measure(quantity));
    text += "," + shortest(seconds_of(bench, cell)) + "," + text::csv_field(cell.error) +
            (given.empty() ? "" : "," + text::csv_field(given)) + "\r\n";
  }
  return text;
}

std::string to_json(const Bench& bench, const Analysis& analysis) {
  Json json;
  json["title"] = bench.title;
  json["overrides"] = bench.overrides;
  json["error"] = {{"metric", bench.error_metric}, {"unit", "m"}};
  json["rope"] = bench.rope;
  json["confidence"] = analysis.confidence;
  json["cells"] = {
      {"all", analysis.cells}, {"done", analysis.done}, {"failed", analysis.failed}, {"missing", analysis.missing}};
  json["choices"] = choices_to_make(bench, analysis);
  json["verdicts"] = Json::array();
  for (const Sentence& sentence : verdicts(bench, analysis)) json["verdicts"].push_back(sentence.text);
  json["calibration"] = calibration_verdicts(analysis);
  json["rising_costs"] = analysis.rising;
  json["breakdowns"] = Json::array();
  for (const Breakdown& b : analysis.breakdowns) json["breakdowns"].push_back(breakdown_json(b));
  json["weights"] = bench.weights;
  json["unused"] = analysis.unused;
  json["rows"] = Json::array();
  for (const Row& row : analysis.rows) json["rows"].push_back(row_json(row));
  json["comparisons"] = Json::array();
  for (const Duel& duel : analysis.duels) json["comparisons"].push_back(duel_json(duel));
  json["failures"] = Json::array();
  for (const Failure& f : analysis.failures)
    json["failures"].push_back(
        {{"place", f.place}, {"name", f.name}, {"reason", f.reason}, {"cells", f.cells}, {"seeds", f.seeds}});
  json["excluded"] = Json::array();
  for (const Excluded& item : bench.excluded)
    json["excluded"].push_back({{"what", item.what}, {"why", item.why}, {"cells", item.cells}});
  json["machine"] = bench.machine;
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string to_markdown(const Bench& bench, const Analysis& analysis) {
  std::string text = "# " + one_line(bench.title) + "\n\n" + coverage_text(bench, analysis) + ".\n\n";
  if (!bench.groups.empty()) text += "## What to choose\n\n";
  for (const std::string& sentence : choices_to_make(bench, analysis)) text += "- " + sentence + "\n";
  if (!analysis.breakdowns.empty()) text += "\n## Where they break\n\n";
  for (const std::string& sentence : breakdown_sentences(analysis.breakdowns)) text += "- " + sentence + "\n";
  if (!bench.groups.empty()) text += "\n## Verdicts\n\n";
  for (const Sentence& sentence : verdicts(bench, analysis)) text += "- " + sentence.text + "\n";
  for (const std::string& sentence : analysis.unused) text += "- " + sentence + "\n";
  const std::vector<std::string> calibration = calibration_verdicts(analysis);
  if (!calibration.empty()) text += "\n## What covariances state\n\n";
  for (const std::string& sentence : calibration) text += "- " + sentence + "\n";
  if (const auto parts = stated_parts(analysis); !parts.empty()) {
    text += std::string(calibration.empty() ? "\n## What covariances state\n" : "") +
            "\n| place | alternative | part | predicted / found | NEES / freedom (band) | stated |\n"
            "|---|---|---|---|---|---|\n";
    for (const StatedPart& p : parts)
      text += "| " + table_cell(p.place) + " | " + table_cell(p.name) + " | " + table_cell(p.part) + " | " + p.ratio +
              " | " + p.nees + " | " + p.verdict + " |\n";
  }
  if (!analysis.rising.empty()) text += "\n## Costs that go up\n\n";
  for (const std::string& sentence : analysis.rising) text += "- " + sentence + ".\n";
  const double tau = bench.tolerances.empty() ? 0 : bench.tolerances.front();
  const bool costs = std::any_of(analysis.rows.begin(), analysis.rows.end(),
                                 [](const Row& row) { return std::isfinite(row.start_cost + row.final_cost); });
  text +=
      "\n| place | alternative | trials | failed | RMSE [mm] | bias [mm] | predicted [mm] | bound²/MSE | NEES / "
      "freedom (band) | worst error above " +
      fmt::format("{:g}", 1e3 * tau) + " mm | time [s] |" + (costs ? " start cost | final cost |" : "") +
      "\n|---|---|---|---|---|---|---|---|---|---|---|" + (costs ? "---|---|" : "") + "\n";
  for (const Row& row : analysis.rows) {
    const auto& s = row.summary;
    text += "| " + table_cell(row.place) + " | " + table_cell(row.name) + " | " + std::to_string(s.trials) +
            (row.missing ? " (" + std::to_string(row.missing) + " not run)" : "") + " | " + std::to_string(s.failures) +
            " | " + interval_text(s.rmse, 1e3) + own_trials_mark(row) + " | " + interval_text(s.bias, 1e3) + " | " +
            number_text(1e3 * s.predicted.value, 1e-2) + " | " + interval_text(s.efficiency, 1) + " | " +
            number_text(s.nees, 0.1) +
            (std::isfinite(s.nees_band.lower)
                 ? " (" + number_text(s.nees_band.lower, 0.1) + "–" + number_text(s.nees_band.upper, 0.1) + ")"
                 : "") +
            " | " + rate_text(row, tau) + " | " + number_text(row.seconds, 0.5 * row.seconds) + " |" +
            (costs ? " " + cost_text(row.start_cost) + " | " + cost_text(row.final_cost) + " |" : "") + "\n";
  }
  text += "\n" + method_text(bench, analysis) + "\n";
  if (!analysis.failures.empty()) {
    text += "\n## Failed cells\n\n| place | alternative | cells | seeds | reason |\n|---|---|---|---|---|\n";
    for (const Failure& f : analysis.failures)
      text += "| " + table_cell(f.place) + " | " + table_cell(f.name) + " | " + std::to_string(f.cells) + " | " +
              seeds_text(f.seeds) + " | " + table_cell(f.reason) + " |\n";
  }
  if (!bench.excluded.empty()) {
    text += "\n## Excluded\n\n";
    for (const Excluded& item : bench.excluded)
      text += "- " + item.what + " (" + std::to_string(item.cells) + " cells)" +
              (item.why.empty() ? "" : ": " + item.why) + "\n";
  }
  text += "\n";
  for (const std::string& line : bench.machine)
    if (line.rfind("plugin ", 0) != 0 && line.rfind("libraries ", 0) != 0) text += "- " + line + "\n";
  return text;
}

}  // namespace plumbline::bench

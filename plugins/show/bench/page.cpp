#include "show/bench/page.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/text/words.hpp"
#include "base/text/xml_text.hpp"
#include "page_parts.hpp"
#include "show/bench/figures.hpp"
#include "show/bench/sentences.hpp"
#include "show/bench/tables.hpp"

namespace plumbline::bench {

using Json = nlohmann::ordered_json;
using statistics::Estimate;

namespace {

using text::xml_escaped;

/// Six digits are more than any plot shows; they halve the page.
double rounded(double value) {
  if (!std::isfinite(value) || value == 0) return value;
  const double scale = std::pow(10.0, 5 - std::floor(std::log10(std::abs(value))));
  return std::round(value * scale) / scale;
}

Json triple(const Estimate& e) { return {rounded(e.value), rounded(e.interval.lower), rounded(e.interval.upper)}; }

Json list(const std::vector<double>& values) {
  Json json = Json::array();
  for (const double value : values) json.push_back(rounded(value));
  return json;
}

/// What the script draws.
std::string data_text(const Bench& bench, const Analysis& analysis) {
  Json json;
  json["rope"] = bench.rope;
  json["tolerances"] = bench.tolerances;
  json["variables"] = Json::array();
  for (const Variable& v : bench.variables) json["variables"].push_back({{"name", v.name}, {"values", v.values}});
  json["rows"] = Json::array();
  for (const Row& row : analysis.rows) {
    const auto& s = row.summary;
    json["rows"].push_back({{"place", row.place},
                            {"name", row.name},
                            {"values", row.values},
                            {"choices", row.choices},
                            {"trials", s.trials},
                            {"failures", s.failures},
                            {"rmse", triple(s.rmse)},
                            {"efficiency", triple(s.efficiency)},
                            {"nees", rounded(s.nees)},
                            {"band", {rounded(s.nees_band.lower), rounded(s.nees_band.upper)}},
                            {"seconds", rounded(row.seconds)},
                            {"errors", list(row.errors)},
                            {"worst", list(row.worst)},
                            {"seeds", row.seeds}});
  }
  json["duels"] = Json::array();
  for (const Duel& duel : analysis.duels)
    json["duels"].push_back({{"group", duel.group},
                             {"first", duel.first},
                             {"second", duel.second},
                             {"place", duel.place},
                             {"overall", duel.overall},
                             {"shown", !duel.overall || duel.weighted},
                             {"refused", duel.refused},
                             {"words", duel.words},
                             {"pairs", duel.errors.pairs},
                             {"verdict", to_text(duel.errors.verdict)},
                             {"difference", triple(duel.errors.difference)}});
  std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  for (std::size_t at = 0; (at = text.find("</", at)) != std::string::npos; at += 3) text.insert(at + 1, "\\");
  return text;
}

std::string number_cell(const std::string& text, double value) {
  return "<td class=\"n\" data-v=\"" + (std::isfinite(value) ? std::to_string(value) : "") + "\">" + text + "</td>";
}

/// The value, and below it its interval.
std::string interval_cell(const Estimate& estimate, double scale, const std::string& mark = "") {
  std::string text = interval_text(estimate, scale) + mark;
  if (const std::size_t at = text.find(" ("); at != std::string::npos)
    text = text.substr(0, at) + mark + "<small>" + text.substr(at + 2, text.find(')', at) - at - 2) + "</small>";
  return number_cell(text, scale * estimate.value);
}

std::string rate_cell(const Row& row, double tau) {
  for (const auto& rate : row.summary.failure_rates)
    if (rate.tau == tau)
      return number_cell(number_text(100 * rate.share, 1) + " %<small>" + number_text(100 * rate.interval.lower, 1) +
                             "–" + number_text(100 * rate.interval.upper, 1) + "</small>",
                         rate.share);
  return number_cell(row.unplanned > 0 ? "did not run" : "–", NAN);
}

/// Three tolerances of the sweep: the smallest, the middle, the largest.
std::vector<double> shown_tolerances(const Bench& bench) {
  std::vector<double> shown;
  if (bench.tolerances.empty()) return shown;
  for (const std::size_t i : {std::size_t{0}, bench.tolerances.size() / 2, bench.tolerances.size() - 1})
    if (shown.empty() || bench.tolerances[i] > shown.back()) shown.push_back(bench.tolerances[i]);
  return shown;
}

std::string main_table(const Bench& bench, const Analysis& analysis) {
  std::string text =
      "<div class=\"scroll\"><table id=\"rows\"><thead><tr><th>place</th><th>alternative</th><th "
      "class=\"n\">trials</th>"
      "<th class=\"n\">failed</th><th class=\"n\">RMSE [mm]</th><th class=\"n\">bias [mm]</th>"
      "<th class=\"n\">predicted [mm]</th><th class=\"n\">bound²/MSE</th><th class=\"n\">NEES/freedom</th>";
  for (const double tau : shown_tolerances(bench))
    text += "<th class=\"n\">above " + number_text(1e3 * tau, 1) + " mm</th>";
  const bool costs = std::any_of(analysis.rows.begin(), analysis.rows.end(),
                                 [](const Row& row) { return std::isfinite(row.start_cost + row.final_cost); });
  text += "<th class=\"n\">time [ms]</th>";
  if (costs) text += "<th class=\"n\">start cost</th><th class=\"n\">final cost</th>";
  text += "</tr></thead><tbody>\n";
  for (const Row& row : analysis.rows) {
    const auto& s = row.summary;
    text += s.failures == s.trials && s.trials > 0 ? "<tr class=\"failed\">" : "<tr>";
    text += "<td>" + xml_escaped(row.place) + "</td><td>" + xml_escaped(row.name) + "</td>";
    text += number_cell(std::to_string(s.trials) + (row.missing ? " of " + std::to_string(s.trials + row.missing) : ""),
                        static_cast<double>(s.trials));
    text += number_cell(std::to_string(s.failures), static_cast<double>(s.failures));
    text += interval_cell(s.rmse, 1e3, own_trials_mark(row));
    text += interval_cell(s.bias, 1e3);
    text += number_cell(number_text(1e3 * s.predicted.value, 0.01), 1e3 * s.predicted.value);
    text += interval_cell(s.efficiency, 1);
    text += number_cell(number_text(s.nees, 0.1), s.nees);
    for (const double tau : shown_tolerances(bench)) text += rate_cell(row, tau);
    text += number_cell(number_text(1e3 * row.seconds, 500 * row.seconds), row.seconds);
    for (const double cost : {row.start_cost, row.final_cost})
      if (costs) text += number_cell(cost_text(cost), cost);
    text += "</tr>\n";
  }
  return text + "</tbody></table></div>\n";
}

std::string verdict_list(const Bench& bench, const Analysis& analysis) {
  std::string text = "<ul class=\"verdicts\">\n";
  for (const Sentence& sentence : verdicts(bench, analysis))
    text += std::string("<li class=\"") +
            (sentence.refused  ? "bad"
             : sentence.winner ? "win"
             : sentence.open   ? "open"
                               : "") +
            "\">" + xml_escaped(sentence.text) + "</li>\n";
  return text + "</ul>\n";
}

std::string plain_list(const std::vector<std::string>& sentences, const std::string& kind = "") {
  std::string text = "<ul class=\"verdicts\">\n";
  for (const std::string& sentence : sentences)
    text += "<li class=\"" + kind + "\">" + xml_escaped(sentence) + "</li>\n";
  return text + "</ul>\n";
}

std::string breakdown_table(const Bench& bench, const Analysis& analysis) {
  std::string text =
      "<p class=\"soft\">The value up to which half of the sites have a result within the tolerance, and the " +
      confidence_text(bench, analysis) +
      " interval of that median.</p><div class=\"scroll\"><table><thead><tr><th>variable</th><th>place</th>"
      "<th>alternative</th><th class=\"n\">within [mm]</th><th "
      "class=\"n\">sites</th><th>holds</th></tr></thead><tbody>\n";
  for (const Breakdown& b : analysis.breakdowns)
    text += "<tr><td>" + xml_escaped(b.variable) + "</td><td>" + xml_escaped(b.place) + "</td><td>" +
            xml_escaped(b.name) + "</td><td class=\"n\">" + number_text(1e3 * b.tolerance, 1) +
            "</td><td class=\"n\">" + std::to_string(b.sites) + "</td><td>" + xml_escaped(breakdown_text(b)) +
            (b.excluded.empty() ? "" : xml_escaped("; left out: " + text::enumerate(b.excluded))) + "</td></tr>\n";
  return text + "</tbody></table></div>\n";
}

std::string stated_table(const Analysis& analysis) {
  std::string text =
      "<div class=\"scroll\"><table><thead><tr><th>place</th><th>alternative</th><th>part</th><th "
      "class=\"n\">predicted "
      "/ found</th><th class=\"n\">NEES / freedom (band)</th><th>stated</th></tr></thead><tbody>\n";
  for (const StatedPart& p : stated_parts(analysis))
    text += "<tr><td>" + xml_escaped(p.place) + "</td><td>" + xml_escaped(p.name) + "</td><td>" + xml_escaped(p.part) +
            "</td><td class=\"n\">" + p.ratio + "</td><td class=\"n\">" + p.nees + "</td><td>" + p.verdict +
            "</td></tr>\n";
  return text + "</tbody></table></div>\n";
}

/// What a person needs first: a sentence for each group, what is wrong with the bench itself, and the picture.
std::string first_screen(const Bench& bench, const Analysis& analysis) {
  std::string text;
  if (!analysis.unused.empty()) text += plain_list(analysis.unused, "bad");
  if (!bench.groups.empty()) text += "<h2>What to choose</h2>\n";
  if (bench.groups.empty())
    text += "<div class=\"panel\">" + to_svg(figure(bench, analysis), Svg::inlined) + "</div>\n";
  const std::vector<std::string> sentences = choices_to_make(bench, analysis);
  for (std::size_t i = 0; i < bench.groups.size(); ++i)
    text += "<p class=\"answer\">" + xml_escaped(sentences[i]) + "</p>\n<div class=\"panel\">" +
            to_svg(panel(bench, analysis, bench.groups[i]), Svg::inlined) + "</div>\n";
  if (const auto broken = breakdown_sentences(analysis.breakdowns); !broken.empty())
    text += "<h2>Where they break</h2>\n" + plain_list(broken);
  return "<section>" + text + "</section>\n";
}

/// Verdicts pair by pair, what covariances state, costs that go up; folded.
std::string behind(const Bench& bench, const Analysis& analysis) {
  std::string text;
  const auto fold = [&](const std::string& title, const std::string& content) {
    text += "<details><summary>" + title + "</summary>\n" + content + "</details>\n";
  };
  if (!bench.groups.empty()) fold("Verdicts, pair by pair", verdict_list(bench, analysis));
  // With few trials there is no sentence, and the table says "not judged".
  if (!stated_parts(analysis).empty()) {
    const auto sentences = calibration_verdicts(analysis);
    fold("What covariances state against what is found",
         (sentences.empty() ? "" : plain_list(sentences)) + stated_table(analysis));
  }
  if (!analysis.breakdowns.empty()) fold("Where they break", breakdown_table(bench, analysis));
  if (!analysis.rising.empty()) fold("Costs that go up", plain_list(analysis.rising, "bad"));
  return text.empty() ? "" : "<section>" + text + "</section>\n";
}

std::string failure_table(const Bench& bench, const Analysis& analysis) {
  std::string text = "<section><h2>Failed cells</h2>\n";
  if (analysis.failures.empty())
    text += "<p class=\"soft\">None.</p>\n";
  else {
    text +=
        "<div class=\"scroll\"><table><thead><tr><th>place</th><th>alternative</th><th class=\"n\">cells</th>"
        "<th>seeds</th><th>reason</th></tr></thead><tbody>\n";
    for (const Failure& f : analysis.failures) {
      std::string seeds;
      for (std::size_t i = 0; i < std::min<std::size_t>(8, f.seeds.size()); ++i)
        seeds += (i ? ", " : "") + std::to_string(f.seeds[i]);
      if (f.seeds.size() > 8) seeds += ", …";
      text += "<tr><td>" + xml_escaped(f.place) + "</td><td>" + xml_escaped(f.name) + "</td><td class=\"n\">" +
              std::to_string(f.cells) + "</td><td>" + seeds + "</td><td class=\"reason\">" + xml_escaped(f.reason) +
              "</td></tr>\n";
    }
    text += "</tbody></table></div>\n";
  }
  if (!bench.excluded.empty()) {
    text += "<h2>Excluded by the file</h2><ul>\n";
    for (const Excluded& item : bench.excluded)
      text += "<li>" + xml_escaped(item.what) + " (" + std::to_string(item.cells) + " cells)" +
              (item.why.empty() ? "" : ": " + xml_escaped(item.why)) + "</li>\n";
    text += "</ul>\n";
  }
  return text + "</section>\n";
}

std::string figure(const std::string& id, const std::string& tools, bool with_legend) {
  return (tools.empty() ? "" : "<div class=\"tools\">" + tools + "</div>") + "<figure><div id=\"" + id + "\"></div>" +
         (with_legend ? "<div class=\"legend\" id=\"legend-" + id + "\"></div>" : "") + "</figure>\n";
}

std::string select(const std::string& id, const std::string& label) {
  return "<select id=\"" + id + "\" aria-label=\"" + label + "\"></select>";
}

std::string plots(const std::string& confidence) {
  return "<section id=\"paired\"><h2>Paired differences</h2>\n"
         "<p class=\"soft\">Each line is the difference of two alternatives on the same trials with its " +
         confidence +
         " interval. "
         "There is no winner where it covers zero.</p>\n" +
         figure("differences", select("differences-group", "group"), false) + "<h2>Trial by trial</h2>\n" +
         figure("pairs", select("pairs-duel", "pair"), false) +
         "</section>\n<section><h2>Performance profile</h2>\n<p class=\"soft\">Share of trials whose largest error "
         "stays "
         "below; failed trials never arrive. Dotted: the tolerances.</p>\n" +
         figure("profile", select("profile-place", "place"), true) +
         "</section>\n<section id=\"breakdown-section\"><h2>Breakdown curves</h2>\n" +
         figure("breakdown", select("breakdown-variable", "variable") + select("breakdown-place", "place"), true) +
         "</section>\n<section><h2>Error against time</h2>\n" + figure("times", select("times-place", "place"), true) +
         "</section>\n<section><h2>Bound and consistency</h2>\n<div class=\"tools\">" +
         select("limits-place", "place") + "</div><div class=\"two\">" + figure("bound", "", false) +
         figure("nees", "", false) + "</div></section>\n";
}

}  // namespace

std::string to_html(const Bench& bench, const Analysis& analysis) {
  std::string text =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><title>" +
      xml_escaped(bench.title) + "</title>\n<style>" + page_style + "</style></head><body>\n";
  text += "<h1>" + xml_escaped(bench.title) + "</h1>\n<p class=\"soft\">" +
          xml_escaped(coverage_text(bench, analysis)) + ". Errors are " + xml_escaped(bench.error_metric) +
          ".</p>\n<p class=\"soft\">" + xml_escaped(method_text(bench, analysis)) + "</p>\n";
  text += first_screen(bench, analysis) + behind(bench, analysis);
  text +=
      "<section><h2>Table</h2>\n<div class=\"tools\"><input id=\"filter\" type=\"search\" "
      "placeholder=\"filter: words that a row must hold\" size=\"40\"><span class=\"soft\" id=\"count\"></span>"
      "</div>\n" +
      main_table(bench, analysis) + "</section>\n";
  text += plots(confidence_text(bench, analysis)) + failure_table(bench, analysis);
  text += "<section><h2>Machine and versions</h2>\n<p class=\"soft\">";
  for (const std::string& line : bench.machine) text += xml_escaped(line) + "<br>";
  text += "</p></section>\n<script type=\"application/json\" id=\"data\">" + data_text(bench, analysis) +
          "</script>\n<script>" + page_script + "</script>\n</body></html>\n";
  return text;
}

}  // namespace plumbline::bench

#include "show/bench/bench_data.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace plumbline::bench {

using Json = nlohmann::json;

namespace {

double number(const Json& json) { return json.is_number() ? json.get<double>() : std::nan(""); }

std::string place_text(const Json& cell, const std::vector<Variable>& variables) {
  std::string text = cell.at("scenario");
  for (const Variable& variable : variables) {
    if (variable.values.size() < 2) continue;  // says nothing
    text += (text.empty() ? "" : ", ") + variable.name + "=" + cell.at("values").at(variable.name).get<std::string>();
  }
  return text;
}

Cell read_cell(const Json& json, const std::vector<Variable>& variables) {
  Cell cell;
  json.at("scenario").get_to(cell.scenario);
  cell.place = place_text(json, variables);
  json.at("values").get_to(cell.values);
  json.at("choices").get_to(cell.choices);
  json.at("seed").get_to(cell.seed);
  json.at("status").get_to(cell.status);
  cell.error = json.value("error", "");
  cell.planned = json.value("planned", true);
  cell.forbidden = json.value("forbidden", false);
  if (json.contains("measures"))
    for (const auto& [name, value] : json.at("measures").items()) cell.measures[name] = number(value);
  if (json.contains("modes"))
    for (const auto& [mode, stated] : json.at("modes").items())
      for (const auto& [name, value] : stated.items()) cell.modes[mode][name] = number(value);
  if (json.contains("inputs")) json.at("inputs").get_to(cell.inputs);
  if (json.contains("seconds")) json.at("seconds").get_to(cell.seconds);
  cell.run = json.value("run", "");
  return cell;
}

/// "equal", or numbers of the scenarios.
void read_weights(const Json& json, Bench& bench) {
  if (json.is_string()) {
    for (const std::string& place : bench.places()) bench.weights[place] = 1;
    bench.weights_text = "all places weighing alike";
    return;
  }
  bench.weights_of_scenarios = true;
  bench.weights_text = "weighing";
  for (const auto& [scenario, weight] : json.items()) {
    bench.weights[scenario] = weight.get<double>();
    const std::string text = fmt::format(" {:g}", weight.get<double>());
    bench.weights_text += (bench.weights_text == "weighing" ? " " : ", ") + scenario + text;
  }
}

Bench read(const Json& json) {
  Bench bench;
  json.at("title").get_to(bench.title);
  json.at("file").get_to(bench.file);
  if (json.contains("overrides")) json.at("overrides").get_to(bench.overrides);
  json.at("measure").get_to(bench.metrics);
  json.at("measure").at("error").get_to(bench.error_metric);
  json.at("rope").get_to(bench.rope);
  json.at("tolerances").get_to(bench.tolerances);
  json.at("scenarios").get_to(bench.scenarios);
  if (json.contains("looks")) json.at("looks").get_to(bench.looks);
  bench.judged_seeds = json.value("judged_seeds", std::size_t{0});
  bench.behind = json.value("behind", std::size_t{0});
  for (const Json& item : json.at("variables")) bench.variables.push_back({item.at("name"), item.at("values")});
  for (const Json& item : json.at("groups"))
    bench.groups.push_back({item.at("name"), item.at("alternatives"), item.at("nodes"), item.at("whole_pipelines")});
  if (json.contains("judged")) json.at("judged").get_to(bench.judged);
  for (const Json& item : json.at("excluded"))
    bench.excluded.push_back({item.at("what"), item.at("why"), item.at("cells")});
  const Json& machine = json.at("machine");
  bench.machine.push_back("plumbline " + machine.at("version").get<std::string>() + ", commit " +
                          machine.value("commit", "unknown") + ", " + machine.value("compiler", "unknown compiler"));
  // Where cells came from other machines, this one's processor is not theirs.
  const std::string here = machine.value("host", "");
  const auto& hosts = machine.at("hosts");
  const bool only_here = std::all_of(hosts.begin(), hosts.end(), [&](const Json& host) { return host == here; });
  bench.machine.push_back((only_here || here.empty() ? "" : "page made on " + here + ": ") +
                          machine.at("processor").get<std::string>() + ", " +
                          std::to_string(machine.at("processors").get<int>()) + " processors");
  for (const Json& host : hosts) bench.machine.push_back("host " + host.get<std::string>());
  if (machine.contains("libraries") && !machine.at("libraries").empty()) {
    std::string libraries;
    for (const Json& library : machine.at("libraries"))
      libraries += (libraries.empty() ? "" : " ") + library.get<std::string>();
    bench.machine.push_back("libraries " + libraries);
  }
  for (const Json& plugin : machine.at("plugins")) bench.machine.push_back("plugin " + plugin.get<std::string>());
  for (const Json& cell : json.at("cells")) bench.cells.push_back(read_cell(cell, bench.variables));
  if (json.contains("weights")) read_weights(json.at("weights"), bench);
  return bench;
}

}  // namespace

double Cell::measure(const std::string& quantity) const {
  const auto found = measures.find(quantity);
  return found == measures.end() ? std::nan("") : found->second;
}

double Bench::useless_above() const {
  if (tolerances.empty()) return std::numeric_limits<double>::infinity();
  const double largest = *std::max_element(tolerances.begin(), tolerances.end());
  const bool yardstick = std::any_of(cells.begin(), cells.end(), [&](const Cell& cell) {
    return cell.status == "done" && cell.error_size() <= largest;
  });
  return yardstick ? largest : std::numeric_limits<double>::infinity();
}

double Bench::none_within() const {
  const bool any = std::any_of(cells.begin(), cells.end(), [](const Cell& cell) { return cell.status == "done"; });
  return any && !tolerances.empty() && std::isinf(useless_above())
             ? *std::max_element(tolerances.begin(), tolerances.end())
             : std::nan("");
}

std::vector<std::string> Bench::places() const {
  std::vector<std::string> places;
  for (const Cell& cell : cells)
    if (std::find(places.begin(), places.end(), cell.place) == places.end()) places.push_back(cell.place);
  return places;
}

Bench parse_bench(const std::string& text) {
  try {
    return read(Json::parse(text));
  } catch (const Json::exception& error) {
    throw std::runtime_error(std::string("this is no table of cells as 'plumbline bench' writes it: ") + error.what());
  }
}

std::string choices_text(const std::map<std::string, std::string>& choices, const std::string& without) {
  std::string text;
  for (const auto& [group, choice] : choices)
    if (group != without) text += (text.empty() ? "" : " · ") + choice;
  return text;
}

}  // namespace plumbline::bench

// plumbline show RUN --relative A B: what two points of a run are known relative to each other.
//
// Any artifact will do that has "points" with id and position, and their joint "covariance" as a packed lower triangle.
// The program knows no more of it than its JSON: sums of four 3 x 3 blocks need no adjustment.
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "runtime/plugins/artifact_type.hpp"
#include "runtime/record/deliver.hpp"
#include "runtime/record/run_record.hpp"

namespace plumbline::cli {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// JSON has no NaN: an unknown number is null.
double number(const Json& value) { return value.is_number() ? value.get<double>() : kUnknown; }

struct Source {
  std::string output;  ///< NODE.PORT, of a round that was asked for NODE@ROUND.PORT
  Json points;
};

/// Outputs of the run that hold points with their covariance; of one of them if `wanted` names it. Of nodes that ran
/// in rounds the last counts, which is what the run handed over, unless `wanted` names another as NODE@ROUND.PORT.
std::vector<Source> outputs_with_covariance(const runtime::RecordedRun& run, const std::string& wanted,
                                            runtime::Store& store, const runtime::Registry& registry) {
  std::vector<Source> found;
  std::vector<std::string> without, names;
  for (const auto& node : run.nodes)
    for (const auto& [port, hashes] : node.outputs) {
      const bool is_last = run.find(node.name) == &node;
      const std::string by_round = node.name + "@" + std::to_string(node.round) + "." + port;
      const std::string name = is_last && wanted != by_round ? node.name + "." + port : by_round;
      const std::string type_name = node.types.at(port);
      if (hashes.size() != 1 || !type_name.starts_with("plumbline.Points/")) continue;
      names.push_back(name);
      if (wanted.empty() ? !is_last : name != wanted) continue;
      const plumbline_type* type = registry.type_of_output(node.kind, port, type_name);
      if (!type) throw UsageError("no plugin brings the type " + type_name);
      Json points = Json::parse(blob_to_json(store, *type, hashes[0]));
      if (points.value("covariance", Json::array()).empty())
        without.push_back(name);
      else
        found.push_back({name, std::move(points)});
    }
  if (!found.empty()) return found;
  std::string all;
  for (const std::string& name : without) all += (all.empty() ? "" : ", ") + name;
  if (!all.empty()) throw UsageError(run.file.string() + ": the points of " + all + " have no covariance");
  for (const std::string& name : names) all += (all.empty() ? "; it has " : ", ") + name;
  if (!wanted.empty()) throw UsageError(run.file.string() + " has no output '" + wanted + "' of points" + all);
  throw UsageError(run.file.string() + " has no points with a covariance; runs that adjust a network have");
}

/// Place of the point in the list, or -1.
int find_point(const Json& points, const std::string& id, const std::string& output) {
  int at = -1, i = 0;
  for (const Json& point : points.at("points")) {
    if (point.at("id") == id) {
      if (at >= 0) throw UsageError(output + " has two points called '" + id + "'");
      at = i;
    }
    ++i;
  }
  return at;
}

/// The output that has both points. Several that have them must be told apart by the user.
const Source& choose(const std::vector<Source>& sources, const std::array<std::string, 2>& pair) {
  const Source* chosen = nullptr;
  std::string all;
  for (const Source& source : sources) {
    if (find_point(source.points, pair[0], source.output) < 0 || find_point(source.points, pair[1], source.output) < 0)
      continue;
    all += (all.empty() ? "" : ", ") + source.output;
    if (chosen && chosen->points != source.points)
      throw UsageError("both points are in " + all + ", which differ: say which, as in RUN:" + source.output);
    if (!chosen) chosen = &source;
  }
  if (chosen) return *chosen;
  std::string where;
  for (const Source& source : sources) where += (where.empty() ? "" : ", ") + source.output;
  for (const std::string& id : pair) {
    std::vector<std::string> names;
    bool known = false;
    for (const Source& source : sources)
      for (const Json& point : source.points.at("points")) {
        names.push_back(point.at("id"));
        known = known || names.back() == id;
      }
    if (!known) throw UsageError("no point '" + id + "' in " + where + did_you_mean(id, names));
  }
  throw UsageError("no output has both points, of " + where);
}

using Vector = std::array<double, 3>;
using Matrix = std::array<Vector, 3>;

struct Difference {
  Vector d;      ///< b - a [m]
  Matrix cov{};  ///< of d [m^2]
};

Difference difference(const Json& points, int a, int b, const std::string& output) {
  const Json& packed = points.at("covariance");
  const size_t n = 3 * points.at("points").size();
  if (packed.size() != n * (n + 1) / 2)
    throw std::runtime_error("the covariance of " + output + " has " + std::to_string(packed.size()) +
                             " values, expected " + std::to_string(n * (n + 1) / 2));
  const auto element = [&](int point_i, int k, int point_j, int l) {
    const size_t i = static_cast<size_t>(3 * point_i + k), j = static_cast<size_t>(3 * point_j + l);
    return number(packed[i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i]);
  };
  Difference result;
  for (int k = 0; k < 3; ++k) {
    const auto at = [&](int point) { return number(points.at("points")[point].at("position")[k]); };
    result.d[k] = at(b) - at(a);
    for (int l = 0; l < 3; ++l)
      result.cov[k][l] = element(a, k, a, l) + element(b, k, b, l) - element(a, k, b, l) - element(b, k, a, l);
  }
  return result;
}

/// Length of the first `axes` components and its standard deviation, which a length of zero does not have.
std::pair<double, double> length(const Difference& x, int axes) {
  double square = 0, variance = 0;
  for (int k = 0; k < axes; ++k) square += x.d[k] * x.d[k];
  for (int k = 0; k < axes; ++k)
    for (int l = 0; l < axes; ++l) variance += x.d[k] * x.cov[k][l] * x.d[l] / square;
  return {std::sqrt(square), square > 0 ? std::sqrt(std::max(0.0, variance)) : kUnknown};
}

/// The first sentence of the network's own verdict where it is not sound: its coordinates are not better in pairs.
std::string reservation(const runtime::RecordedRun& run, const std::string& output, runtime::Store& store,
                        const runtime::Registry& registry) {
  const auto* node = run.find(output.substr(0, output.rfind('.')));
  if (!node) return "";
  for (const auto& [port, type_name] : node->types) {
    const plumbline_type* type = registry.type_of_output(node->kind, port, type_name);
    if (!type || !type_name.starts_with("plumbline.SurveyNetwork/") || node->outputs.at(port).size() != 1) continue;
    const Json network = Json::parse(blob_to_json(store, *type, node->outputs.at(port)[0]));
    if (network.value("validity", "sound") != "sound") return network.value("verdict", "");
  }
  return "";
}

}  // namespace

int show_relative(const Options& options) {
  const std::array<std::string, 2> pair{options.relative.at(0), options.relative.at(1)};
  if (pair[0] == pair[1]) throw UsageError("--relative " + pair[0] + " " + pair[1] + ": expected two different points");
  const size_t colon = options.name.rfind(':');
  const bool named = colon != std::string::npos && !fs::exists(options.name);
  const runtime::RecordedRun run = runtime::read_run(named ? options.name.substr(0, colon) : options.name);
  const runtime::Registry registry = discover();
  const auto store = open_store_to_read(options);
  const auto sources = outputs_with_covariance(run, named ? options.name.substr(colon + 1) : "", *store, registry);
  const Source& source = choose(sources, pair);
  const Difference x = difference(source.points, find_point(source.points, pair[0], source.output),
                                  find_point(source.points, pair[1], source.output), source.output);
  const auto [horizontal, sigma_horizontal] = length(x, 2);
  const auto [slope, sigma_slope] = length(x, 3);
  const std::string verdict = reservation(run, source.output, *store, registry);
  const auto sigma = [&](int k) { return std::sqrt(x.cov[k][k]); };
  const std::tuple<const char*, double, double> lines[] = {{"dE", x.d[0], sigma(0)},
                                                           {"dN", x.d[1], sigma(1)},
                                                           {"dH", x.d[2], sigma(2)},
                                                           {"horizontal_distance", horizontal, sigma_horizontal},
                                                           {"slope_distance", slope, sigma_slope}};
  if (options.json) {
    const auto json = [](double value) { return std::isfinite(value) ? Json(value) : Json(); };
    Json all{{"from", pair[0]}, {"to", pair[1]}, {"output", source.output}, {"verdict", verdict}};
    for (const auto& [name, value, s] : lines) all[name] = {{"value", json(value)}, {"sigma", json(s)}};
    for (int k = 0; k < 3; ++k) all["covariance"].push_back({json(x.cov[k][0]), json(x.cov[k][1]), json(x.cov[k][2])});
    std::printf("%s\n", all.dump(1).c_str());
    return 0;
  }
  std::printf("%s -> %s, from %s (1 sigma)\n", pair[0].c_str(), pair[1].c_str(), source.output.c_str());
  if (!verdict.empty()) std::printf("! the network is %s\n", verdict.c_str());
  for (const auto& [name, value, s] : lines) {
    std::string label = name;
    for (char& c : label) c = c == '_' ? ' ' : c;
    if (!std::isfinite(value))
      std::printf("  %-20s unknown: the network has no such coordinate\n", label.c_str());
    else if (!std::isfinite(s))
      std::printf("  %-20s %13.5f m\n", label.c_str(), value);
    else
      std::printf("  %-20s %13.5f m +- %8.3f mm\n", label.c_str(), value, 1e3 * s);
  }
  return 0;
}

}  // namespace plumbline::cli

// Two runs compared node by node, and where their outputs differ, number by number.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "artifacts/file.hpp"
#include "runtime/base/json_text.hpp"
#include "runtime/record/deliver.hpp"
#include "runtime/record/run_record.hpp"

namespace plumbline::runtime {

namespace {

using Json = nlohmann::ordered_json;

std::string number_text(double value) { return fmt::format("{:.9g}", value); }

/// Two digits say how large a difference is.
std::string size_text(double value) { return fmt::format("{:.2g}", value); }

constexpr const char* quaternion_keys[] = {"w", "x", "y", "z"};

bool is_quaternion(const Json& json) {
  return json.is_object() && json.size() == 4 &&
         std::all_of(std::begin(quaternion_keys), std::end(quaternion_keys),
                     [&](const char* key) { return json.contains(key) && json[key].is_number(); });
}

double dot(const Json& a, const Json& b) {
  double sum = 0;
  for (const char* key : quaternion_keys) sum += a[key].get<double>() * b[key].get<double>();
  return sum;
}

Json negative(Json json) {
  for (const char* key : quaternion_keys) json[key] = -json[key].get<double>();
  return json;
}

/// An artifact as JSON. Of a File that holds JSON its content: two of them are compared number by number, not by bytes.
Json content_of(Store& store, const plumbline_type& type, const std::string& hash) {
  Json json = Json::parse(blob_to_json(store, type, hash));
  if (type.name != std::string(artifact_traits<File>::name)) return json;
  const Blob blob = store.get(hash);
  const File* file = flatbuffers::GetRoot<File>(blob.bytes().data);
  if (!file->content() || !file->name()->str().ends_with(".json")) return json;
  const Json inside = Json::parse(file->content()->begin(), file->content()->end(), nullptr, false);
  if (inside.is_discarded()) return json;
  json["content"] = inside;
  json.erase("sha256");  // of the bytes
  json.erase("size");
  return json;
}

/// How two artifacts differ: the largest difference of numbers, and whether anything else does.
struct Comparison {
  double largest = 0;  // relative
  std::string where, other;
  size_t numbers = 0;

  void compare(const Json& a, const Json& b, const std::string& path) {
    if (a.is_number() && b.is_number()) {
      const double x = a.get<double>(), y = b.get<double>();
      const double scale = std::max(std::abs(x), std::abs(y));
      if (x == y || scale == 0) return;
      ++numbers;
      if (const double relative = std::abs(x - y) / scale; relative > largest) {
        largest = relative;
        where = path + ": " + number_text(x) + " and " + number_text(y);
      }
    } else if (is_quaternion(a) && is_quaternion(b) && dot(a, b) < 0) {
      compare(a, negative(b), path);  // q and -q turn alike
    } else if (a.is_object() && b.is_object()) {
      for (const auto& [key, value] : a.items()) {
        const auto found = b.find(key);
        found == b.end() ? differ(path + "." + key + " is only in the first")
                         : compare(value, *found, path.empty() ? key : path + "." + key);
      }
      for (const auto& [key, value] : b.items())
        if (!a.contains(key)) differ(path + "." + key + " is only in the second");
    } else if (a.is_array() && b.is_array()) {
      if (a.size() != b.size())
        differ(path + " has " + std::to_string(a.size()) + " and " + std::to_string(b.size()) + " items");
      for (size_t i = 0; i < std::min(a.size(), b.size()); ++i)
        compare(a[i], b[i], path + "[" + std::to_string(i) + "]");
    } else if (a != b) {
      const auto text = [](const Json& json) { return json_line(json).substr(0, 60); };
      differ(path + ": " + text(a) + " and " + text(b));
    }
  }
  void differ(const std::string& text) {
    if (other.empty()) other = text;
  }
};

class Comparer {
 public:
  Comparer(double tolerance, Store* store, const Registry& registry)
      : tolerance_(tolerance), store_(store), registry_(registry) {}

  NodeDifference compare(const RecordedNode& a, const RecordedNode& b) {
    NodeDifference difference{label_of(a.name, a.round), {}, true};
    const auto differ = [&](const std::string& line) {
      difference.lines.push_back(line);
      difference.within_tolerance = false;
    };
    if (a.kind != b.kind) differ("kind: " + a.kind + " -> " + b.kind);
    const auto done = [](const std::string& status) { return status == "executed" || status == "reused"; };
    if (done(a.status) != done(b.status) || (!done(a.status) && a.status != b.status))
      differ("status: " + a.status + " -> " + b.status);
    // What explains a difference is told, but only results count as one.
    for (const std::string& line : runtime::compare(a.fields, b.fields))
      if (line.rfind("kind:", 0) != 0) difference.lines.push_back(line);
    compare_metrics(a, b, difference);
    for (const auto& [port, hashes] : a.outputs) {
      const auto other = b.outputs.find(port);
      if (other == b.outputs.end()) {
        differ("output " + port + " is only in the first");
      } else if (other->second != hashes) {
        const auto type = a.types.find(port);
        compare_output(port, hashes, other->second, type == a.types.end() ? "" : type->second, difference);
      }
    }
    for (const auto& [port, hashes] : b.outputs)
      if (!a.outputs.count(port)) differ("output " + port + " is only in the second");
    return difference;
  }

 private:
  void compare_metrics(const RecordedNode& a, const RecordedNode& b, NodeDifference& difference) {
    const size_t common = std::min(a.metrics.size(), b.metrics.size());
    if (a.metrics.size() != b.metrics.size()) {
      difference.lines.push_back(std::to_string(a.metrics.size()) + " -> " + std::to_string(b.metrics.size()) +
                                 " metrics");
      difference.within_tolerance = false;
    }
    for (size_t i = 0; i < common; ++i) {
      const double x = a.metrics[i].value, y = b.metrics[i].value;
      if (x == y || (std::isnan(x) && std::isnan(y))) continue;
      const double relative = std::abs(x - y) / std::max(std::abs(x), std::abs(y));
      difference.lines.push_back("metric " + a.metrics[i].name + ": " + number_text(x) + " -> " + number_text(y) + " " +
                                 a.metrics[i].unit);
      if (a.metrics[i].name != b.metrics[i].name || !(relative <= tolerance_)) difference.within_tolerance = false;
    }
  }

  void compare_output(const std::string& port, const Hashes& a, const Hashes& b, const std::string& type_name,
                      NodeDifference& difference) {
    const std::string name = "output " + port;
    if (a.size() != b.size()) {
      difference.lines.push_back(name + ": " + std::to_string(a.size()) + " -> " + std::to_string(b.size()) + " items");
      difference.within_tolerance = false;
      return;
    }
    const plumbline_type* type = registry_.type(type_name);
    Comparison all;
    size_t differing = 0;
    for (size_t i = 0; i < a.size(); ++i) {
      if (a[i] == b[i]) continue;
      ++differing;
      try {
        if (!store_ || !type) throw std::runtime_error("its content is not at hand");
        all.compare(content_of(*store_, *type, a[i]), content_of(*store_, *type, b[i]),
                    a.size() > 1 ? "[" + std::to_string(i) + "]" : "");
      } catch (const std::exception& error) {
        all.differ(a[i].substr(0, 12) + " -> " + b[i].substr(0, 12) + " (" + error.what() + ")");
      }
    }
    std::string line =
        name + (a.size() > 1 ? " (" + std::to_string(differing) + " of " + std::to_string(a.size()) + " items)" : "");
    if (all.numbers)
      line += ": " + std::to_string(all.numbers) + " numbers differ, at most by " + size_text(all.largest) +
              " of their size, " + all.where;
    if (!all.other.empty()) line += (all.numbers ? "; and " : ": ") + all.other;
    if (!all.numbers && all.other.empty()) line += ": other bytes, the same content";
    difference.lines.push_back(line);
    if (!all.other.empty() || !(all.largest <= tolerance_)) difference.within_tolerance = false;
  }

  const double tolerance_;
  Store* store_;
  const Registry& registry_;
};

}  // namespace

std::vector<NodeDifference> compare_runs(const RecordedRun& a, const RecordedRun& b, double tolerance, Store* store,
                                         const Registry& registry) {
  std::vector<NodeDifference> all;
  Comparer comparer(tolerance, store, registry);
  for (const RecordedNode& node : a.nodes) {
    const RecordedNode* other = b.find(node.name, node.round);
    NodeDifference difference =
        other ? comparer.compare(node, *other)
              : NodeDifference{label_of(node.name, node.round), {"is only in the first run"}, false};
    if (!difference.lines.empty()) all.push_back(std::move(difference));
  }
  for (const RecordedNode& node : b.nodes)
    if (!a.find(node.name, node.round))
      all.push_back({label_of(node.name, node.round), {"is only in the second run"}, false});
  return all;
}

}  // namespace plumbline::runtime

// Two runs compared node by node, and where their outputs differ, number by number.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <tuple>

#include "artifacts/file.hpp"
#include "artifacts/folder.hpp"
#include "runtime/base/json_text.hpp"
#include "runtime/record/deliver.hpp"
#include "runtime/record/file_content.hpp"
#include "runtime/record/run_record.hpp"

namespace plumbline::runtime {

namespace {

using Json = nlohmann::ordered_json;

std::string number_text(double value) { return fmt::format("{:.9g}", value); }

/// How far two numbers lie apart: a share of the larger one, and above 1 the difference itself. A share of 5 400 000 m
/// says nothing of what two places differ by: a millionth of it is 5 m.
double apart(double x, double y) { return std::abs(x - y) / std::min(1.0, std::max(std::abs(x), std::abs(y))); }

/// "0.003", "2.5e-07 of its size"; two digits say how large a difference is.
std::string apart_text(double x, double y) {
  return fmt::format("{:.2g}", apart(x, y)) + (std::max(std::abs(x), std::abs(y)) < 1 ? " of its size" : "");
}

/// Rows of a covariance that is its lower triangle, row by row; 0: it is none.
size_t rows_of_triangle(const Json& list) {
  const auto n = static_cast<size_t>((std::sqrt(8.0 * static_cast<double>(list.size()) + 1) - 1) / 2 + 0.5);
  return n > 0 && n * (n + 1) / 2 == list.size() ? n : 0;
}

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

bool has_numbers(const Json& list, size_t size) {
  return list.is_array() && list.size() == size &&
         std::ranges::all_of(list, [](const Json& one) { return one.is_number(); });
}

/// Structs of artifacts print as arrays; a quaternion gets its names here: the first array of a Rigid, [[w, x, y, z],
/// [x, y, z]], which is like no other, and four numbers under a key that says rotation. Of anything else nothing.
Json with_named_rotation(const Json& json, const std::string& path) {
  const bool rigid = json.is_array() && json.size() == 2 && has_numbers(json[0], 4) && has_numbers(json[1], 3);
  if (!rigid && !(has_numbers(json, 4) && path.ends_with("rotation"))) return {};
  Json rotation;
  for (size_t i = 0; i < 4; ++i) rotation[quaternion_keys[i]] = (rigid ? json[0] : json)[i];
  return rigid ? Json{{"rotation", rotation}, {"translation", json[1]}} : rotation;
}

/// "before -> now" of texts of many lines, such as what a whole pipeline does: the lines that the other has not.
std::string changed_lines(const std::string& before, const std::string& now) {
  const auto lines_of = [](const std::string& text) {
    std::set<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines.insert(line);
    return lines;
  };
  const auto only_in = [](const std::set<std::string>& lines, const std::set<std::string>& others) {
    std::string text;
    for (const std::string& line : lines)
      if (!others.count(line)) text += (text.empty() ? "" : " | ") + line;
    return text.empty() ? std::string("(nothing)") : text;
  };
  const auto old = lines_of(before), current = lines_of(now);
  return only_in(old, current) + " -> " + only_in(current, old);
}

/// What explains that two nodes gave other results. Another kind is another binary with other libraries, as a matter of
/// course.
std::vector<std::string> explained(const RecordedNode& a, const RecordedNode& b) {
  std::vector<std::string> lines;
  KeyFields before = a.fields, now = b.fields;
  for (const auto& [name, value] : a.fields) {
    const auto other = now.find(name);
    if (other == now.end() || value == other->second || (value + other->second).find('\n') == std::string::npos)
      continue;
    lines.push_back(name + ": " + changed_lines(value, other->second));
    before.erase(name);
    now.erase(other);
  }
  for (const std::string& line : compare(before, now))
    if (!line.starts_with("kind:") &&
        (a.kind == b.kind || !(line.starts_with("library ") || line.starts_with("plugin "))))
      lines.push_back(line);
  return lines;
}

/// An artifact as JSON; of a File what it holds, of a Folder its files, not where they lie.
Json content_of(Store& store, const plumbline_type& type, const std::string& hash) {
  Json json = Json::parse(blob_to_json(store, type, hash));
  if (type.name == std::string(artifact_traits<Folder>::name)) json.erase("uri");  // each file has its own hash
  if (type.name != std::string(artifact_traits<File>::name)) return json;
  constexpr uintmax_t most = 64u << 20;
  const Blob blob = store.get(hash);
  const File* file = flatbuffers::GetRoot<File>(blob.bytes().data);
  const std::string name = file->name()->str();
  if (file->uri() && file->uri()->size() > 0) {
    json.erase("uri");
    const std::filesystem::path path = store.resolve(file->uri()->str());
    std::error_code error;
    if (const auto size = std::filesystem::file_size(path, error); error || size > most) return json;  // sha256 tells
    std::ifstream stream(path, std::ios::binary);
    json["content"] = content_of_file(name, std::string(std::istreambuf_iterator<char>(stream), {}));
  } else {
    const auto* content = file->content();
    json["content"] = content_of_file(name, {reinterpret_cast<const char*>(content->data()), content->size()});
  }
  json.erase("sha256");  // of the bytes
  return json;
}

/// How two artifacts differ: the largest difference of numbers, and whether anything else does.
struct Comparison {
  double largest = 0;  // as apart() has it
  std::string where, other;
  size_t numbers = 0, others = 0;

  void compare(const Json& a, const Json& b, const std::string& path) {
    if (a.is_number() && b.is_number()) {
      const double x = a.get<double>(), y = b.get<double>();
      if (x == y) return;
      ++numbers;
      if (const double off = apart(x, y); off > largest) {
        largest = off;
        where = apart_text(x, y) + ", " + path + ": " + number_text(x) + " and " + number_text(y);
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
    } else if (const Json x = with_named_rotation(a, path), y = with_named_rotation(b, path);
               x.is_object() && y.is_object()) {
      compare(x, y, path);
    } else if (a.is_array() && b.is_array()) {
      if (a.size() != b.size())
        differ(path + " has " + std::to_string(a.size()) + " and " + std::to_string(b.size()) + " items");
      if (path.ends_with("covariance") && a.size() == b.size() && has_numbers(a, a.size()) &&
          has_numbers(b, b.size()) && rows_of_triangle(a) > 0)
        return compare_covariances(a, b, path);
      for (size_t i = 0; i < std::min(a.size(), b.size()); ++i)
        compare(a[i], b[i], path + "[" + std::to_string(i) + "]");
    } else if (a != b) {
      const auto text = [](const Json& json) { return json_line(json).substr(0, 60); };
      differ(path + ": " + text(a) + " and " + text(b));
    }
  }
  /// The size of a covariance is what the two standard deviations make of it: next to nothing beside them is nothing.
  void compare_covariances(const Json& a, const Json& b, const std::string& path) {
    const size_t rows = rows_of_triangle(a);
    std::vector<double> sigmas(rows);
    for (size_t r = 0; r < rows; ++r) {
      const size_t at = r * (r + 1) / 2 + r;
      sigmas[r] = std::sqrt(std::max(std::abs(a[at].get<double>()), std::abs(b[at].get<double>())));
    }
    for (size_t r = 0, i = 0; r < rows; ++r)
      for (size_t c = 0; c <= r; ++c, ++i) {
        const double x = a[i].get<double>(), y = b[i].get<double>();
        if (x == y) continue;
        ++numbers;
        const double size = std::max({sigmas[r] * sigmas[c], std::abs(x), std::abs(y)});
        if (const double off = std::abs(x - y) / std::min(1.0, size); off > largest) {
          largest = off;
          where = fmt::format("{:.2g}", off) + (size < 1 ? " of its variances, " : ", ") + path + "[" +
                  std::to_string(i) + "]: " + number_text(x) + " and " + number_text(y);
        }
      }
  }

  void differ(const std::string& text) {
    if (++others == 1) other = text;
  }
};

class Comparer {
 public:
  Comparer(double tolerance, Store* store, const Registry& registry)
      : tolerance_(tolerance), store_(store), registry_(registry) {}

  NodeDifference compare(const RecordedNode& a, const RecordedNode& b) {
    NodeDifference difference{label_of(a.name, a.round), {}, true};
    const std::vector<std::string> reasons = explained(a, b);
    const auto differ = [&](const std::string& line) {
      difference.lines.push_back(line);
      difference.within_tolerance = false;
    };
    if (a.kind != b.kind) difference.lines.push_back("kind: " + a.kind + " -> " + b.kind);  // a reason as those below
    const auto done = [](const std::string& status) { return status == "executed" || status == "reused"; };
    if (done(a.status) != done(b.status) || (!done(a.status) && a.status != b.status))
      differ("status: " + a.status + " -> " + b.status);
    // What did not run has nothing to be compared: no key, no parameter, no output.
    if (a.status != b.status && (a.status == "skipped" || b.status == "skipped")) return difference;
    difference.lines.insert(difference.lines.end(), reasons.begin(), reasons.end());  // only results count
    compare_metrics(a, b, difference);
    for (const auto& [port, hashes] : a.outputs) {
      const auto other = b.outputs.find(port);
      if (other == b.outputs.end()) {
        differ("output " + port + " is only in the first");
      } else if (const std::string type = type_of(a, port), now = type_of(b, port); type != now) {
        differ("output " + port + " is another artifact: " + type + " -> " + now);
      } else if (other->second != hashes) {
        compare_output(port, {&hashes, type_at_hand(a, port)}, {&other->second, type_at_hand(b, port)}, difference);
      }
    }
    for (const auto& [port, hashes] : b.outputs)
      if (!a.outputs.count(port)) differ("output " + port + " is only in the second");
    return difference;
  }

 private:
  /// What a run has of an output: its artifacts, and the type that they are read by (nullptr: nobody brings it).
  struct Given {
    const Hashes* hashes;
    const plumbline_type* type;
  };

  static std::string type_of(const RecordedNode& node, const std::string& port) {
    const auto type = node.types.find(port);
    return type == node.types.end() ? "no type that is told" : type->second;
  }
  const plumbline_type* type_at_hand(const RecordedNode& node, const std::string& port) const {
    return registry_.type_of_output(node.kind, port, type_of(node, port));
  }

  /// "; x is only in the first" of the metrics that `b` has none of.
  static std::string only_in(const char* words, const RecordedNode& a, const RecordedNode& b) {
    std::string text;
    for (const Metric& metric : a.metrics)
      if (std::ranges::none_of(b.metrics, [&](const Metric& other) { return other.name == metric.name; }))
        text += "; " + metric.name + words;
    return text;
  }

  void compare_metrics(const RecordedNode& a, const RecordedNode& b, NodeDifference& difference) {
    const size_t common = std::min(a.metrics.size(), b.metrics.size());
    if (a.metrics.size() != b.metrics.size()) {
      difference.lines.push_back(std::to_string(a.metrics.size()) + " -> " + std::to_string(b.metrics.size()) +
                                 " metrics" + only_in(" is only in the first", a, b) +
                                 only_in(" is only in the second", b, a));
      difference.within_tolerance = false;
    }
    for (size_t i = 0; i < common; ++i) {
      const double x = a.metrics[i].value, y = b.metrics[i].value;
      if (a.metrics[i].name != b.metrics[i].name) {
        difference.lines.push_back("metric " + a.metrics[i].name + " in the place of " + b.metrics[i].name);
        difference.within_tolerance = false;
        continue;
      }
      if (x == y || (std::isnan(x) && std::isnan(y))) continue;
      const double off = apart(x, y);
      const std::string unit = a.metrics[i].unit == "1" ? "" : " " + a.metrics[i].unit;
      difference.lines.push_back("metric " + a.metrics[i].name + ": " + number_text(x) + " -> " + number_text(y) +
                                 unit + (std::isnan(off) ? "" : ", by " + apart_text(x, y)));
      if (!(off <= tolerance_)) difference.within_tolerance = false;
    }
  }

  void compare_output(const std::string& port, const Given& one, const Given& other, NodeDifference& difference) {
    const Hashes &a = *one.hashes, &b = *other.hashes;
    const std::string name = "output " + port;
    if (a.size() != b.size()) {
      difference.lines.push_back(name + ": " + std::to_string(a.size()) + " -> " + std::to_string(b.size()) + " items");
      difference.within_tolerance = false;
      return;
    }
    Comparison all;
    size_t differing = 0;
    for (size_t i = 0; i < a.size(); ++i) {
      if (a[i] == b[i]) continue;
      ++differing;
      try {
        if (!store_ || !one.type || !other.type) throw std::runtime_error("its content is not at hand");
        all.compare(content_of(*store_, *one.type, a[i]), content_of(*store_, *other.type, b[i]),
                    a.size() > 1 ? "[" + std::to_string(i) + "]" : "");
      } catch (const std::exception& error) {
        all.differ(a[i].substr(0, 12) + " -> " + b[i].substr(0, 12) + " (" + error.what() + ")");
      }
    }
    std::string line =
        name + (a.size() > 1 ? " (" + std::to_string(differing) + " of " + std::to_string(a.size()) + " items)" : "");
    if (all.numbers) line += ": " + std::to_string(all.numbers) + " numbers differ, at most by " + all.where;
    if (!all.other.empty()) line += (all.numbers ? "; and " : ": ") + all.other;
    if (all.others > 1) line += " (and " + std::to_string(all.others - 1) + " more that are no numbers)";
    if (!all.numbers && all.other.empty()) line += ": other bytes, the same content";
    difference.lines.push_back(line);
    if (!all.other.empty() || !(all.largest <= tolerance_)) difference.within_tolerance = false;
  }

  const double tolerance_;
  Store* store_;
  const Registry& registry_;
};

/// What a node was computed from before the node, and else by name: the record has them as they ended, which is another
/// order each time.
std::vector<const RecordedNode*> by_dependence(const RecordedRun& run) {
  std::map<std::string, std::set<std::string>> before;
  for (const RecordedNode& node : run.nodes)
    for (const auto& [port, from] : node.connections) before[node.name].insert(from.substr(0, from.rfind('.')));
  std::map<std::string, size_t> depths;
  const std::function<size_t(const std::string&)> depth = [&](const std::string& name) {
    const auto [known, added] = depths.try_emplace(name, 0);  // 0 meanwhile: rounds lead back to their beginning
    if (!added) return known->second;
    size_t deepest = 0;
    for (const std::string& from : before[name]) deepest = std::max(deepest, 1 + depth(from));
    return depths[name] = deepest;
  };
  std::set<std::string> names;
  for (const RecordedNode& node : run.nodes) names.insert(node.name);
  for (const std::string& name : names) depth(name);
  std::vector<const RecordedNode*> nodes;
  for (const RecordedNode& node : run.nodes) nodes.push_back(&node);
  std::stable_sort(nodes.begin(), nodes.end(), [&](const RecordedNode* x, const RecordedNode* y) {
    return std::tuple(x->round, depths[x->name], x->name) < std::tuple(y->round, depths[y->name], y->name);
  });
  return nodes;
}

}  // namespace

std::vector<NodeDifference> compare_runs(const RecordedRun& a, const RecordedRun& b, double tolerance, Store* store,
                                         const Registry& registry) {
  std::vector<NodeDifference> all;
  Comparer comparer(tolerance, store, registry);
  for (const RecordedNode* node : by_dependence(a)) {
    const RecordedNode* other = b.find(node->name, node->round);
    NodeDifference difference =
        other ? comparer.compare(*node, *other)
              : NodeDifference{label_of(node->name, node->round), {"is only in the first run"}, false};
    if (!difference.lines.empty()) all.push_back(std::move(difference));
  }
  for (const RecordedNode* node : by_dependence(b))
    if (!a.find(node->name, node->round))
      all.push_back({label_of(node->name, node->round), {"is only in the second run"}, false});
  return all;
}

}  // namespace plumbline::runtime

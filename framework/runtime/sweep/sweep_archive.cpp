#include "runtime/sweep/sweep_archive.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <stdexcept>

#include "runtime/base/child_process.hpp"
#include "runtime/base/digest.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

void write(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream stream(path, std::ios::binary | std::ios::trunc);
  stream << text;
  stream.close();
  if (!stream) throw std::runtime_error("cannot write " + path.string() + "; check space and rights");
}

std::string content_of(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream || fs::is_directory(path)) throw std::runtime_error("cannot read " + path.string());
  return text.str();
}

fs::path absolute(const std::string& path) { return fs::absolute(path).lexically_normal(); }

/// The folder that all lie in.
fs::path common_folder(const std::vector<SourceFile>& sources) {
  fs::path common = absolute(sources.front().path).parent_path();
  for (const SourceFile& source : sources)
    while (absolute(source.path).lexically_relative(common).string().rfind("..", 0) == 0) common = common.parent_path();
  return common;
}

/// Files and folders that parameters name.
std::set<std::string> input_paths(const SweepPlan& plan) {
  std::set<std::string> paths;
  std::set<const CellGraph*> seen;
  for (const SweepCell& cell : plan.cells) {
    if (!cell.graph || !seen.insert(cell.graph.get()).second) continue;
    for (const GraphNode& node : cell.graph->graph.nodes)
      for (uint32_t i = 0; i < node.kind.node->param_count; ++i) {
        const plumbline_param& param = *node.kind.node->params[i];
        if (param.kind != PLUMBLINE_FILE && param.kind != PLUMBLINE_FOLDER) continue;
        const auto value = node.parameters.find(param.name);
        if (value == node.parameters.end()) continue;
        std::istringstream list(value->second);
        for (std::string path; std::getline(list, path, '\x1f');)
          if (!path.empty()) paths.insert(path);
      }
  }
  return paths;
}

Json inputs_of_plan(const SweepPlan& plan, FileHashes& hashes) {
  Json inputs = Json::array();
  for (const std::string& path : input_paths(plan)) inputs.push_back({{"path", path}, {"sha256", hashes.of(path)}});
  return inputs;
}

Json machine_json(const SweepPlan& plan, const Registry& registry, const BuildFacts& build) {
  std::set<const Plugin*> used;
  for (const Graph* graph : graphs_of(plan))
    for (const GraphNode& node : graph->nodes) used.insert(node.kind.plugin);
  Json plugins = Json::array();
  for (const auto& plugin : registry.plugins()) {
    plugins.push_back(
        {{"name", plugin->identity.name}, {"version", plugin->identity.version}, {"sha256", plugin->sha256}});
    // Of every build of what cells compute with; of the others their own hash is enough.
    if (used.count(plugin.get()) > 0) plugins.back()["linked"] = plugin->linked_build_ids;
  }
  return {{"version", build.version},
          {"commit", build.commit},
          {"compiler", build.compiler},
          {"libraries", libraries_of(plan, build)},
          {"plugins", plugins}};
}

bool alike(const nlohmann::json& a, const nlohmann::json& b, double tolerance) {
  if (!a.is_number() || !b.is_number()) return a == b;
  const double x = a.get<double>(), y = b.get<double>();
  return x == y || std::abs(x - y) <= tolerance * std::max(std::abs(x), std::abs(y));
}

}  // namespace

void require_place_for_archive(const fs::path& folder, const SweepFile& file) {
  std::error_code ignored;
  if (!fs::exists(folder)) return;
  if (fs::is_regular_file(folder / "archive.json")) {
    const auto json = Json::parse(content_of(folder / "archive.json"), nullptr, false);
    const std::string title = json.is_object() ? json.value("title", "") : "";
    if (title == file.title) return;
    throw std::runtime_error(folder.string() + " is the archive of another bench, '" + title +
                             "', which would be replaced by '" + file.title + "'; give --archive a folder of its own");
  }
  if (fs::is_directory(folder) && fs::is_empty(folder, ignored)) return;
  throw std::runtime_error(folder.string() +
                           " is there and no archive of a bench, and what is in it would be replaced; give --archive a "
                           "folder of its own");
}

void write_archive(const fs::path& folder, const SweepPlan& plan, const Overrides& overrides,
                   const CellRecords& records, const Registry& registry, FileHashes& hashes, const BuildFacts& build) {
  require_place_for_archive(folder, plan.file);
  std::vector<SourceFile> sources = sources_of(plan);
  sources.insert(sources.begin(), {plan.file.path.string(), plan.file.text});
  const fs::path common = common_folder(sources);
  fs::remove_all(folder / "files");
  Json files = Json::array();
  for (const SourceFile& source : sources) {
    const std::string place = "files/" + absolute(source.path).lexically_relative(common).generic_string();
    write(folder / place, source.text);
    files.push_back({{"path", place}, {"sha256", sha256_of(source.text.data(), source.text.size())}});
  }
  std::string cells;
  size_t archived = 0;
  for (const SweepCell& cell : plan.cells)
    if (const auto record = records.find(cell.key)) {
      cells += Json{{"cell", cell.label()}, {"result", Json::parse(CellRecords::result_text(*record))}}.dump() + "\n";
      ++archived;
    }
  write(folder / "cells.jsonl", cells);
  Json scenarios = Json::array();  // those that ran: --scenario may have left some of the file's away
  for (const SweepScenario& scenario : plan.file.scenarios) scenarios.push_back(scenario.name);
  const Json json{{"plumbline_archive", 1},
                  {"title", plan.file.title},
                  {"bench", files[0]["path"]},
                  {"overrides", overrides},
                  {"seeds", plan.file.seeds},
                  {"scenarios", scenarios},
                  {"cells", {{"of_the_bench", plan.cells.size()}, {"archived", archived}}},
                  {"machine", machine_json(plan, registry, build)},
                  {"files", files},
                  {"inputs", inputs_of_plan(plan, hashes)},
                  {"cells_sha256", sha256_of(cells.data(), cells.size())}};
  write(folder / "archive.json", json.dump(1) + "\n");
}

Archive read_archive(const fs::path& folder) {
  Archive archive;
  const std::string cells = content_of(folder / "cells.jsonl");
  try {
    const auto json = nlohmann::json::parse(content_of(folder / "archive.json"));
    if (json.at("plumbline_archive") != 1)
      throw std::runtime_error(folder.string() + " is an archive of a form that this program does not know");
    for (const auto& file : json.at("files")) {
      const std::string path = file.at("path"), text = content_of(folder / path);
      if (sha256_of(text.data(), text.size()) != file.at("sha256"))
        throw std::runtime_error((folder / path).string() + " is not what was archived: it has been changed");
      const fs::path its = (folder / path).parent_path();
      if (std::find(archive.folders.begin(), archive.folders.end(), its) == archive.folders.end())
        archive.folders.push_back(its);
    }
    if (sha256_of(cells.data(), cells.size()) != json.at("cells_sha256"))
      throw std::runtime_error((folder / "cells.jsonl").string() + " is not what was archived: it has been changed");
    archive.bench = folder / json.at("bench").get<std::string>();
    json.at("overrides").get_to(archive.overrides);
    json.at("seeds").get_to(archive.seeds);
    if (json.contains("scenarios")) json.at("scenarios").get_to(archive.scenarios);
    archive.commit = json.at("machine").at("commit");
    if (json.contains("cells")) json.at("cells").at("of_the_bench").get_to(archive.planned);
    for (const auto& input : json.at("inputs")) archive.inputs[input.at("path")] = input.at("sha256");
    std::istringstream lines(cells);
    for (std::string line; std::getline(lines, line);) {
      const auto cell = nlohmann::json::parse(line);
      const std::string label = cell.at("cell");
      if (!archive.results.emplace(label, cell.at("result").dump()).second)
        throw std::runtime_error((folder / "cells.jsonl").string() + " has the cell '" + label + "' twice");
    }
    if (json.contains("cells"))
      if (const auto archived = json.at("cells").at("archived").get<std::size_t>(); archived != archive.results.size())
        throw std::runtime_error((folder / "cells.jsonl").string() + " has " + std::to_string(archive.results.size()) +
                                 " cells, and " + std::to_string(archived) + " were archived: it has been changed");
  } catch (const nlohmann::json::exception& error) {
    throw std::runtime_error(folder.string() + " is no archive of a bench: " + error.what());
  }
  return archive;
}

namespace {

/// Nothing if it cannot be read.
std::optional<std::string> hash_of(const std::string& path, FileHashes& hashes) {
  try {
    return hashes.of(path);
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

}  // namespace

std::vector<std::string> changed_inputs(const Archive& archive, const SweepPlan& plan, FileHashes& hashes) {
  std::set<std::string> now;  // a disk, a folder of programs may be another: what counts is what is read
  for (const std::string& path : input_paths(plan))
    if (const auto hash = hash_of(path, hashes)) now.insert(*hash);
  std::vector<std::string> changed;
  for (const auto& [path, sha256] : archive.inputs) {
    if (now.count(sha256)) continue;
    const auto there = hash_of(path, hashes);
    changed.push_back(path + (!there ? " is not there, and nothing that the cells are made from now has its bytes"
                              : *there == sha256 ? " is as it was, and the cells are made from something else now"
                                                 : " is not what the cells were made from: it has been changed"));
  }
  return changed;
}

namespace {

/// A word of a sentence as the numbers in it and what is around them.
struct Word {
  std::string around;  ///< with '#' for each number
  std::vector<std::string> numbers;
};

Word parts_of(const std::string& text) {
  static const std::regex number(R"([0-9]+(\.[0-9]+)?(e[-+]?[0-9]+)?)");
  Word word;
  auto at = text.begin();
  for (std::sregex_iterator found(text.begin(), text.end(), number), end; found != end; ++found) {
    word.around.append(at, text.begin() + found->position());
    word.around += '#';
    word.numbers.push_back(found->str());
    at = text.begin() + found->position() + found->length();
  }
  word.around.append(at, text.end());
  return word;
}

/// What the last digit that is written is worth; 0 of a whole number, which counts something.
double last_place(const std::string& number) {
  const auto point = number.find('.'), exponent = number.find('e');
  if (point == std::string::npos) return 0;
  const auto digits = (exponent == std::string::npos ? number.size() : exponent) - point - 1;
  const int power = exponent == std::string::npos ? 0 : std::atoi(number.c_str() + exponent + 1);
  return std::pow(10.0, power - static_cast<double>(digits));
}

/// Equal, or numbers with decimals that are rounded to one or the other side: they agree to one in their last place.
bool alike_in_words(const std::string& a, const std::string& b) {
  const Word of_a = parts_of(a), of_b = parts_of(b);
  if (of_a.around != of_b.around) return false;
  for (std::size_t k = 0; k < of_a.numbers.size(); ++k) {
    const double unit = std::max(last_place(of_a.numbers[k]), last_place(of_b.numbers[k]));
    const double x = std::strtod(of_a.numbers[k].c_str(), nullptr), y = std::strtod(of_b.numbers[k].c_str(), nullptr);
    if (of_a.numbers[k] != of_b.numbers[k] && !(std::abs(x - y) <= 1.001 * unit)) return false;
  }
  return true;
}

/// Why a cell failed, in its first line, without what a process took; files, which an archive has in another folder,
/// are without their names.
std::string reason_of(const nlohmann::json& result) {
  const std::string text = without_peaks(result.value("error", ""));
  std::istringstream words(text.substr(0, text.find('\n')));
  std::string reason;
  for (std::string word; words >> word;) {
    const bool file = word.find('/') != std::string::npos || word.find(".yaml") != std::string::npos;
    reason += (reason.empty() ? "" : " ") + (file ? "FILE" : word);
  }
  return reason;
}

}  // namespace

std::string difference_of(const std::string& archived, const std::string& again, double tolerance) {
  const auto a = nlohmann::json::parse(archived), b = nlohmann::json::parse(again);
  if (a.at("status") != b.at("status"))
    return "it was " + a.at("status").get<std::string>() + ", now it is " + b.at("status").get<std::string>() +
           (b.contains("error") ? ": " + b.at("error").get<std::string>() : "");
  if (a.value("failed_node", "") != b.value("failed_node", "") || !alike_in_words(reason_of(a), reason_of(b)))
    return "it failed for another reason: " + reason_of(a) + "; now: " + reason_of(b);
  std::set<std::string> names;
  for (const auto& side : {a, b})
    for (const auto& [name, metric] : side.at("metrics").items()) names.insert(name);
  for (const std::string& name : names) {
    const auto &of_a = a.at("metrics"), &of_b = b.at("metrics");
    if (!of_a.contains(name) || !of_b.contains(name)) return "the metric " + name + " is there only once";
    const auto &x = of_a.at(name).at("value"), &y = of_b.at(name).at("value");
    if (!alike(x, y, tolerance)) return name + " was " + x.dump() + ", now it is " + y.dump();
    const auto &unit = of_a.at(name).at("unit"), &now = of_b.at(name).at("unit");
    if (unit != now) return name + " was in " + unit.dump() + ", now it is in " + now.dump();
  }
  return "";
}

}  // namespace plumbline::runtime

// Where pipelines, plugins and the store are found.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <set>

#include "commands.hpp"
#include "runtime/base/printable.hpp"
#include "runtime/base/quantities.hpp"

namespace plumbline::cli {

namespace fs = std::filesystem;

std::vector<fs::path> pipeline_folders() {
  std::vector<fs::path> folders{"pipelines"};
  std::error_code failed;
  const fs::path self = fs::read_symlink("/proc/self/exe", failed);
  if (!failed) folders.push_back(self.parent_path().parent_path() / "share" / "plumbline" / "pipelines");
  folders.push_back(PLUMBLINE_SOURCE_PIPELINES);
  return folders;
}

runtime::Graph load(const Options& options, const runtime::Registry& registry) {
  runtime::Graph graph =
      load_pipeline(find_pipeline(options.pipeline), options.overrides, registry, pipeline_folders());
  warn_of_kinds_offered_twice(graph, registry);
  return graph;
}

std::string offered_too_by(const runtime::Registry& registry, const std::string& kind) {
  std::string files;
  const auto others = registry.offered_twice_by(kind);
  for (const fs::path& other : others) files += (files.empty() ? "" : " and ") + other.string();
  if (others.empty()) return "";
  return files + (others.size() > 1 ? " have" : " has") + " one of that name, too, which is not used";
}

void warn_of_kinds_offered_twice(const runtime::Graph& graph, const runtime::Registry& registry) {
  warn_of_kinds_offered_twice(std::vector{&graph}, registry);
}

void warn_of_kinds_offered_twice(const std::vector<const runtime::Graph*>& graphs, const runtime::Registry& registry) {
  std::set<std::string> told;
  for (const runtime::Graph* graph : graphs)
    for (const auto& node : graph->nodes) {
      const std::string others = offered_too_by(registry, node.kind.node->kind);
      if (others.empty() || !told.insert(node.kind.node->kind).second) continue;
      std::fprintf(stderr, "warning: node '%s' is the %s of %s; %s\n", runtime::printable_line(node.name).c_str(),
                   node.kind.node->kind, node.kind.plugin->identity.path.c_str(), others.c_str());
    }
}

std::string did_you_mean(const std::string& wanted, const std::vector<std::string>& candidates) {
  std::string text;
  for (const std::string& near : runtime::near_names(wanted, candidates))
    text += (text.empty() ? " — did you mean '" : " or '") + near + "'";
  return text.empty() ? "" : text + "?";
}

fs::path find_pipeline(const std::string& name) {
  if (fs::is_regular_file(name)) return name;
  std::vector<std::string> names;
  for (const fs::path& folder : pipeline_folders()) {
    for (const fs::path& candidate : {folder / (name + ".yaml"), folder / name})
      if (fs::is_regular_file(candidate)) return candidate;
    std::error_code failed;
    for (const auto& entry : fs::directory_iterator(folder, failed))
      if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  const std::string wanted = fs::path(name).stem().string();
  std::string text = "there is no pipeline file '" + name + "'" + did_you_mean(wanted, names);
  if (!names.empty()) {
    text += "\nPipelines that can be run by name:";
    for (const std::string& known : names) text += " " + known;
  }
  throw UsageError(text);
}

std::string find_bench(const std::string& name) {
  if (fs::is_regular_file(name)) return name;
  std::vector<std::string> names;
  for (const fs::path& pipelines : pipeline_folders()) {
    const fs::path folder = pipelines.parent_path() / "benchmarks";
    std::error_code failed;
    for (const auto& entry : fs::recursive_directory_iterator(folder, failed)) {
      std::ifstream stream(entry.path());
      std::string line;
      if (entry.path().extension() != ".yaml") continue;
      while (std::getline(stream, line) && (line.empty() || line[0] == '#')) continue;
      if (line.rfind("bench:", 0) != 0) continue;
      if (entry.path().stem() == name || entry.path().filename() == name) return entry.path().string();
      names.push_back(entry.path().stem().string());
    }
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  std::string text = "there is no bench file '" + name + "'" + did_you_mean(fs::path(name).stem().string(), names);
  if (!names.empty()) {
    text += "\nBench files that can be run by name:";
    for (const std::string& known : names) text += " " + known;
  }
  throw UsageError(text);
}

runtime::Registry discover() { return runtime::Registry::discover(runtime::Registry::search_path()); }

runtime::Store open_store(const Options& options) {
  return runtime::Store(options.store.empty() ? runtime::Store::default_folder() : fs::path(options.store),
                        options.durable);
}

std::unique_ptr<runtime::Store> open_store_to_read(const Options& options) {
  return runtime::Store::for_reading(options.store.empty() ? runtime::Store::default_folder()
                                                           : fs::path(options.store));
}

uint64_t parse_size(const std::string& text) {
  const auto bytes = runtime::parse_bytes(text);
  if (!bytes) throw UsageError("'" + text + "' is no size of memory; write for example 3GiB or 500MB");
  return *bytes;
}

}  // namespace plumbline::cli

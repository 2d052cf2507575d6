// plumbline doctor: what works here, what does not, and what to do about it.
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "commands.hpp"
#include "linked_licences.hpp"
#include "runtime/base/memory_budget.hpp"
#include "runtime/base/trust.hpp"
#include "runtime/plugins/programs.hpp"
#include "runtime/run/workers.hpp"
#include "terminal.hpp"

namespace plumbline::cli {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

struct Finding {
  enum Level { good, note, bad } level;
  std::string subject, text;
};

void check_search_path(std::vector<Finding>& findings) {
  const auto folders = runtime::Registry::search_path();
  for (const fs::path& folder : folders) {
    std::error_code failed, unreadable;
    const bool there = fs::is_directory(folder, failed);
    fs::directory_iterator(folder, unreadable);
    if (there && unreadable)
      findings.push_back(
          {Finding::bad, "search path",
           folder.string() + " cannot be read (" + unreadable.message() +
               "), so no plugin of it is found; give it the rights, or take it off PLUMBLINE_PLUGIN_PATH"});
    else
      findings.push_back(
          {there ? Finding::good : Finding::note, "search path",
           folder.string() +
               (there ? "" : " is not there; plugins go into it, or into a folder of PLUMBLINE_PLUGIN_PATH")});
  }
}

/// "story 0.1.0, 22 of 23 nodes": those that are not hidden by another plugin.
std::string nodes_text(const runtime::Registry& registry, const runtime::Plugin& plugin) {
  const size_t all = plugin.table->node_count;
  const auto taken = static_cast<size_t>(
      std::ranges::count_if(registry.kinds(), [&](const auto& kind) { return kind.second.plugin == &plugin; }));
  return plugin.identity.name + " " + plugin.identity.version + ", " +
         (taken < all ? std::to_string(taken) + " of " : "") + std::to_string(all) + " nodes";
}

void check_plugins(const runtime::Registry& registry, std::vector<Finding>& findings) {
  std::map<fs::path, size_t> of_one_name;  // files in several folders are told apart by the whole path
  for (const auto& plugin : registry.plugins()) ++of_one_name[plugin->identity.path.filename()];
  for (const auto& refused : registry.refused()) ++of_one_name[refused.path.filename()];
  for (const auto& plugin : registry.plugins()) {
    const fs::path& path = plugin->identity.path;
    findings.push_back(
        {Finding::good, "plugin",
         (of_one_name[path.filename()] > 1 ? path : path.filename()).string() + ": " + nodes_text(registry, *plugin)});
  }
  std::map<std::string, std::string> loaded_by;  // "libjbig.so.0 (GPL-2.0-or-later)" -> plugins
  for (const auto& plugin : registry.plugins())
    for (const LinkedLicence& linked : copyleft_libraries(*plugin)) {
      std::string& names = loaded_by[linked.library + " (" + linked.licence + ")"];
      names += (names.empty() ? "" : ", ") + plugin->identity.name;
    }
  for (const auto& [library, plugins] : loaded_by)
    findings.push_back({Finding::note, "licence",
                        library + " is loaded by " + plugins +
                            ": who passes them on with it does so under that licence; see NOTICE.md"});
  for (const auto& refused : registry.refused())
    findings.push_back(
        {Finding::bad, "plugin",
         refused.path.string() + (refused.hidden_by.empty() ? " is refused: it " : " ") + refused.problem});
  if (registry.plugins().empty())
    findings.push_back({Finding::bad, "plugin", "no plugin was found; build the project or set PLUMBLINE_PLUGIN_PATH"});
}

/// Programs that nodes start (COLMAP): whoever has no use for those nodes needs none of them.
void check_programs(const runtime::Registry& registry, std::vector<Finding>& findings) {
  std::map<std::string, std::string> needed_by;
  for (const auto& [name, kind] : registry.kinds())
    for (uint32_t i = 0; i < kind.node->param_count; ++i) {
      const plumbline_param& param = *kind.node->params[i];
      if (!runtime::names_program(param)) continue;
      std::string& kinds = needed_by[param.default_text];
      kinds += (kinds.empty() ? "" : ", ") + name;
    }
  for (const auto& [program, kinds] : needed_by) {
    const std::string path = runtime::find_program(program);
    const bool there = path.find('/') != std::string::npos;
    const bool script = there && runtime::is_script(path);
    findings.push_back({there && !script ? Finding::good : Finding::note, "program",
                        script ? path + ", for " + kinds +
                                     ": a script; of what it starts only what it prints when called with -h is part of "
                                     "results' keys"
                        : there ? path + ", for " + kinds
                                : program + " is not there; only " + kinds + " need" +
                                      (kinds.find(',') == std::string::npos ? "s" : "") + " it: apt-get install " +
                                      program});
  }
}

void check_worker(std::vector<Finding>& findings) {
  const fs::path program = runtime::worker_program();
  if (access(program.c_str(), X_OK) != 0)
    findings.push_back({Finding::note, "worker", program.string() + " is not there; only isolated nodes need it"});
  else if (const std::string problem = runtime::distrust(program); !problem.empty())
    findings.push_back({Finding::bad, "worker", "isolated nodes are not run: " + problem});
}

void check_store(const Options& options, std::vector<Finding>& findings) {
  try {
    runtime::Store store = open_store(options);
    static const std::string probe = "plumbline doctor\n";
    store.get(store.put(probe.data(), probe.size()));
    struct statvfs disk {};
    double free_bytes = 0;
    if (statvfs(store.folder().c_str(), &disk) == 0)
      free_bytes = static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize);
    const bool little = free_bytes < 2e9;
    findings.push_back(
        {little ? Finding::note : Finding::good, "store",
         store.folder().string() + ", " + size_text(free_bytes) + " free" +
             (little ? "; a campaign of photographs needs more: choose another place with --store" : "")});
  } catch (const std::exception& error) {
    findings.push_back({Finding::bad, "store", error.what()});
  }
}

/// Nodes in Python run with this interpreter; one that comes first in PATH may lack Debian's modules.
void check_python(std::vector<Finding>& findings) {
  if (access("/usr/bin/python3", X_OK) != 0) {
    findings.push_back({Finding::note, "python3", "/usr/bin/python3 is not there; only nodes in Python need it"});
    return;
  }
  for (const std::string module : {"flatbuffers", "numpy"}) {
    const bool there = std::system(("/usr/bin/python3 -c 'import " + module + "' >/dev/null 2>&1").c_str()) == 0;
    findings.push_back(
        {there ? Finding::good : Finding::note, "python3",
         there ? "has " + module : "lacks " + module + "; nodes in Python need it: apt-get install python3-" + module});
  }
}

/// Painted when the columns are measured: codes have no width.
void print_marked(const std::string& text, const char* const (&marks)[3], const Colour (&colours)[3]) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    for (size_t i = 0; i < 3; ++i)
      if (const std::string mark = marks[i]; line.rfind(mark + " ", 0) == 0)
        line.replace(0, mark.size(), paint(colours[i], mark));
    std::printf("%s\n", line.c_str());
  }
}

}  // namespace

int doctor(const Options& options) {
  std::vector<Finding> findings;
  check_search_path(findings);
  const auto registry = runtime::Registry::discover(runtime::Registry::search_path(), true);
  check_plugins(registry, findings);
  check_programs(registry, findings);
  check_worker(findings);
  check_store(options, findings);
  findings.push_back({Finding::good, "memory",
                      size_text(static_cast<double>(runtime::MemoryBudget::default_limit())) +
                          " for nodes that announce what they need; --memory changes it"});
  check_python(findings);
  bool healthy = true;
  Json json = Json::array();
  std::vector<std::vector<std::string>> rows;
  static constexpr const char* marks[] = {"ok", "note", "wrong"};
  static constexpr Colour colours[] = {Colour::green, Colour::yellow, Colour::red};
  for (const Finding& finding : findings) {
    healthy &= finding.level != Finding::bad;
    json.push_back({{"level", marks[finding.level]}, {"subject", finding.subject}, {"text", finding.text}});
    rows.push_back({marks[finding.level], finding.subject + ": " + finding.text});
  }
  if (options.json)
    std::printf("%s\n", json.dump(1).c_str());
  else
    print_marked(columns(rows), marks, colours);
  return healthy ? 0 : 1;
}

}  // namespace plumbline::cli

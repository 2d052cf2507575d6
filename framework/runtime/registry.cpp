#include "runtime/registry.hpp"

#include <dlfcn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "runtime/artifact_type.hpp"
#include "runtime/digest.hpp"
#include "runtime/elf.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

const plumbline_port* find_port(const plumbline_port* const* ports, uint32_t count, const std::string& name) {
  for (uint32_t i = 0; i < count; ++i)
    if (name == ports[i]->name) return ports[i];
  return nullptr;
}

std::string abi_problem(uint32_t major, uint32_t minor) {
  const std::string host = std::to_string(PLUMBLINE_ABI_MAJOR) + "." + std::to_string(PLUMBLINE_ABI_MINOR);
  const std::string plugin = std::to_string(major) + "." + std::to_string(minor);
  if (major != PLUMBLINE_ABI_MAJOR)
    return "is built for plugin ABI " + plugin + ", this host has " + host +
           "; rebuild the plugin against this host's plugin.h";
  if (minor > PLUMBLINE_ABI_MINOR)
    return "needs plugin ABI " + plugin + ", this host has only " + host + "; update plumbline or rebuild the plugin";
  return "";
}

using Entry = const plumbline_plugin_table* (*)();

/// Loads the library and calls its one function. Throws with the loader's own words.
const plumbline_plugin_table* open_table(const fs::path& library) {
  void* handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle) throw std::runtime_error(std::string("cannot be loaded: ") + dlerror());
  const auto entry = reinterpret_cast<Entry>(dlsym(handle, "plumbline_plugin"));
  if (!entry) throw std::runtime_error("does not export plumbline_plugin(); use plumbline_add_plugin() in CMake");
  const plumbline_plugin_table* table = entry();
  if (!table || table->magic != PLUMBLINE_MAGIC)
    throw std::runtime_error("returns a table without Plumbline's magic number");
  if (const std::string problem = abi_problem(table->abi_major, table->abi_minor); !problem.empty())
    throw std::runtime_error(problem);
  return table;
}

fs::path accepted_marker(const std::string& sha256) {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  if (cache && *cache) return fs::path(cache) / "plumbline" / "accepted" / sha256;
  if (home && *home) return fs::path(home) / ".cache" / "plumbline" / "accepted" / sha256;
  return {};
}

/// Runs the library's loading once in a child process, so that a crash in a static initialiser is a message and not the
/// end. A library that has passed is remembered by its hash. Returns what went wrong.
std::string try_in_child(const fs::path& library, const std::string& sha256) {
  const fs::path marker = accepted_marker(sha256);
  std::error_code ignored;
  if (!marker.empty() && fs::exists(marker, ignored)) return "";
  int ends[2];
  if (pipe(ends) != 0) return "";
  const pid_t child = fork();
  if (child < 0) return "";
  if (child == 0) {
    close(ends[0]);
    std::string problem;
    try {
      alarm(20);  // a library that hangs while it is loaded
      open_table(library);
    } catch (const std::exception& error) {
      problem = error.what();
    } catch (...) {
      problem = "throws while it is loaded";
    }
    if (write(ends[1], problem.data(), problem.size()) < 0) _exit(2);
    _exit(problem.empty() ? 0 : 1);
  }
  close(ends[1]);
  std::string problem;
  char buffer[512];
  for (ssize_t got; (got = read(ends[0], buffer, sizeof buffer)) > 0;) problem.append(buffer, static_cast<size_t>(got));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    return signal == SIGALRM
               ? "hangs while it is loaded (20 s)"
               : "dies while it is loaded: signal " + std::to_string(signal) + " (" + strsignal(signal) + ")";
  }
  if (problem.empty() && !marker.empty()) {
    fs::create_directories(marker.parent_path(), ignored);
    if (FILE* file = std::fopen(marker.c_str(), "w")) std::fclose(file);
  }
  return problem;
}

}  // namespace

const plumbline_port* Kind::input(const std::string& name) const {
  return find_port(node->inputs, node->input_count, name);
}
const plumbline_port* Kind::output(const std::string& name) const {
  return find_port(node->outputs, node->output_count, name);
}
const plumbline_param* Kind::param(const std::string& name) const {
  for (uint32_t i = 0; i < node->param_count; ++i)
    if (name == node->params[i]->name) return node->params[i];
  return nullptr;
}

PluginIdentity read_identity(const fs::path& library) {
  PluginIdentity identity;
  identity.path = library;
  try {
    const std::string note = read_elf_note(library, "plumbline", 1);
    if (note.size() < 8) throw std::runtime_error("has a 'plumbline' note that is too short");
    std::memcpy(&identity.abi_major, note.data(), 4);
    std::memcpy(&identity.abi_minor, note.data() + 4, 4);
    std::string* const parts[] = {&identity.name, &identity.version, &identity.licence, &identity.build_id};
    size_t at = 8;
    for (std::string* part : parts) {
      const size_t end = std::min(note.find('\0', at), note.size());
      *part = note.substr(at, end - at);
      at = std::min(end + 1, note.size());
    }
    identity.problem = abi_problem(identity.abi_major, identity.abi_minor);
  } catch (const std::exception& error) {
    identity.problem = error.what();
  }
  return identity;
}

std::vector<fs::path> Registry::search_path(const fs::path& program) {
  std::vector<fs::path> folders;
  const auto add = [&](const fs::path& folder) {
    if (!folder.empty() && std::find(folders.begin(), folders.end(), folder) == folders.end())
      folders.push_back(folder);
  };
  if (const char* set = std::getenv("PLUMBLINE_PLUGIN_PATH")) {
    std::string rest = set;
    while (!rest.empty()) {
      const size_t colon = rest.find(':');
      add(rest.substr(0, colon));
      rest = colon == std::string::npos ? "" : rest.substr(colon + 1);
    }
  }
  std::error_code failed;
  const fs::path self = program.empty() ? fs::read_symlink("/proc/self/exe", failed) : program;
  if (!failed) add(self.parent_path().parent_path() / "lib" / "plumbline");
  return folders;
}

Registry Registry::discover(const std::vector<fs::path>& folders) {
  Registry registry;
  for (const fs::path& folder : folders) {
    std::vector<fs::path> libraries;
    std::error_code failed;
    for (const auto& entry : fs::directory_iterator(folder, failed))
      if (entry.path().extension() == ".so") libraries.push_back(entry.path());
    std::sort(libraries.begin(), libraries.end());
    for (const fs::path& library : libraries) registry.load(library);
  }
  return registry;
}

bool Registry::load(const fs::path& library) {
  auto plugin = std::make_unique<Plugin>();
  plugin->identity = read_identity(library);
  std::string& problem = plugin->identity.problem;
  try {
    if (problem.empty()) {
      plugin->sha256 = sha256_of_file(library);
      problem = try_in_child(library, plugin->sha256);
    }
    if (problem.empty()) {
      plugin->table = open_table(library);
      plugin->linked_build_ids = linked_build_ids(plugin->table);
    }
  } catch (const std::exception& error) {
    problem = error.what();
  }
  for (uint32_t i = 0; problem.empty() && i < plugin->table->node_count; ++i) {
    const char* kind = plugin->table->nodes[i]->kind;
    if (const auto found = kinds_.find(kind); found != kinds_.end())
      problem = std::string("offers the node '") + kind + "', which " + found->second.plugin->identity.path.string() +
                " offers already; rename one of them or take one library off the search path";
  }
  for (uint32_t i = 0; problem.empty() && i < plugin->table->type_count; ++i) {
    const plumbline_type& type = *plugin->table->types[i];
    if (const auto found = types_.find(type.name); found != types_.end()) {
      const std::string difference = compare_types(*found->second, type);
      if (!difference.empty()) problem = "and an earlier plugin disagree on a type: " + difference;
    }
  }
  if (!problem.empty()) {
    refused_.push_back(plugin->identity);
    return false;
  }
  for (uint32_t i = 0; i < plugin->table->type_count; ++i)
    types_.emplace(plugin->table->types[i]->name, plugin->table->types[i]);
  for (uint32_t i = 0; i < plugin->table->node_count; ++i)
    kinds_[plugin->table->nodes[i]->kind] = {plugin->table->nodes[i], plugin.get()};
  plugins_.push_back(std::move(plugin));
  return true;
}

const Kind* Registry::find(const std::string& kind) const {
  const auto found = kinds_.find(kind);
  return found == kinds_.end() ? nullptr : &found->second;
}

const plumbline_type* Registry::type(const std::string& name) const {
  const auto found = types_.find(name);
  return found == types_.end() ? nullptr : found->second;
}

namespace {

/// Edits (insert, delete, replace, swap neighbours) between two words.
size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<size_t>> d(a.size() + 1, std::vector<size_t>(b.size() + 1));
  for (size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (size_t i = 1; i <= a.size(); ++i)
    for (size_t j = 1; j <= b.size(); ++j) {
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

}  // namespace

std::vector<std::string> near_names(const std::string& wanted, const std::vector<std::string>& candidates) {
  std::vector<std::pair<size_t, std::string>> ranked;
  if (wanted.size() > 200) return {};
  for (const std::string& candidate : candidates) {
    size_t distance = edit_distance(wanted, candidate);
    // "opengv" for "pose.opengv": a whole part of a dotted name counts as near.
    if (distance > 1 && wanted.size() > 2 && candidate.find(wanted) != std::string::npos) distance = 1;
    if (distance <= std::max<size_t>(1, wanted.size() / 3)) ranked.emplace_back(distance, candidate);
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<std::string> names;
  for (size_t i = 0; i < ranked.size() && i < 3; ++i) names.push_back(ranked[i].second);
  return names;
}

}  // namespace plumbline::runtime

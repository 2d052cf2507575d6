#include "runtime/plugins/registry.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <stdexcept>

#include "runtime/base/digest.hpp"
#include "runtime/base/trust.hpp"
#include "runtime/plugins/elf.hpp"
#include "runtime/plugins/executable_node.hpp"
#include "runtime/plugins/library.hpp"
#include "runtime/plugins/linked_files.hpp"
#include "runtime/plugins/plugin_check.hpp"
#include "runtime/plugins/plugin_scan.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

const plumbline_port* find_port(const plumbline_port* const* ports, uint32_t count, const std::string& name) {
  for (uint32_t i = 0; i < count; ++i)
    if (name == ports[i]->name) return ports[i];
  return nullptr;
}

}  // namespace

/// The library behind a plugin, loaded when it is first needed.
struct Plugin::Library {
  fs::path path;
  std::string identity, sha256;     // of the file when it was scanned
  std::vector<std::string> linked;  // build ids of its libraries then, each in a process of its own
  std::vector<std::string> linked_files;
  std::unique_ptr<PluginTable> description;
  struct Node {
    Library* library;
    uint32_t index;
  };
  std::vector<Node> nodes;
  std::once_flag once;
  const plumbline_plugin_table* table = nullptr;
  std::string problem;

  const plumbline_plugin_table& load() {
    std::call_once(once, [this] {
      try {
        // Linked anew, but to the same bytes: nothing that was said of it is wrong.
        if (const std::string now = runtime::file_identity(path); now != identity && sha256_of_file(path) == sha256)
          identity = now;
        if (runtime::file_identity(path) != identity) throw std::runtime_error(changed());
        table = open_table(path);
        if (!table || table->magic != PLUMBLINE_MAGIC || serialise(*table) != serialise(description->table()))
          throw std::runtime_error(path.string() + " offers something else than when it was looked at; rebuild it");
        refuse_other_libraries();
      } catch (const std::exception& error) {
        // Of a file that is just being written the loader says all kinds of things.
        problem = runtime::file_identity(path) != identity ? changed() : error.what();
      }
    });
    if (!problem.empty()) throw std::runtime_error(problem);
    return *table;
  }

  /// Of two libraries of one name a process has the one that was loaded first, whoever asked for it. What a node
  /// computed with another one's would stand under a key that names its own.
  void refuse_other_libraries() const {
    for (const std::string& now : runtime::linked_build_ids(table)) {
      if (now.ends_with(kNoPartOfKeys) || std::find(linked.begin(), linked.end(), now) != linked.end()) continue;
      const std::string name = now.substr(0, now.rfind(':'));
      const auto own = std::find_if(linked.begin(), linked.end(),
                                    [&](const std::string& id) { return id.substr(0, id.rfind(':')) == name; });
      throw std::runtime_error(
          path.string() + " needs " + (own == linked.end() ? name : *own) +
          ", and what this process has by that name is " + now +
          ", which another plugin brought; give its nodes processes of their own (isolate: process, "
          "or run --isolate), or build both plugins with one " +
          name);
    }
  }

  std::string changed() const { return path.string() + " is not the file any more that was looked at; run again"; }

  /// run() of every entry of the description.
  static int run(const plumbline_host* host, const plumbline_node* entry) {
    const auto& node = *static_cast<const Node*>(entry->user_data);
    const plumbline_node* loaded = nullptr;
    try {
      loaded = node.library->load().nodes[node.index];
    } catch (const std::exception& error) {
      host->fail(host->context, error.what());
      return 1;
    }
    return loaded->run(host, loaded);
  }
};

void Registry::describe(Plugin& plugin) {
  Plugin::Library& library = *plugin.library;
  plugin.table = &library.description->table();
  const PluginIdentity& note = plugin.identity;
  if (note.name != plugin.table->name || note.version != plugin.table->version)
    throw std::runtime_error("says in its note that it is " + note.name + " " + note.version + ", and in its table " +
                             plugin.table->name + " " + plugin.table->version + "; use PLUMBLINE_PLUGIN()");
  std::vector<void*> user_data;
  for (uint32_t i = 0; i < plugin.table->node_count; ++i) library.nodes.push_back({&library, i});
  for (Plugin::Library::Node& node : library.nodes) user_data.push_back(&node);
  library.description->run_by(&Plugin::Library::run, user_data);
}

Plugin::Plugin() = default;
Plugin::~Plugin() = default;

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

const plumbline_type& Kind::type_of(const plumbline_port& port) const {
  const plumbline_type* type = type_of_port(*plugin->table, port);
  if (!type) throw std::logic_error(std::string("no type ") + port.type);  // check_table() has seen to it
  return *type;
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

Registry Registry::discover(const std::vector<fs::path>& folders, bool look_again) {
  Registry registry;
  std::set<fs::path> looked_at;
  for (const fs::path& folder : folders) {
    std::error_code unreadable;
    if (!looked_at.insert(fs::weakly_canonical(folder, unreadable)).second) continue;  // by another name
    std::vector<fs::path> libraries;
    std::error_code failed;
    for (const auto& entry : fs::directory_iterator(folder, failed))
      if (entry.path().extension() == ".so") libraries.push_back(entry.path());
    std::sort(libraries.begin(), libraries.end());
    for (const fs::path& library : libraries) registry.load(library, look_again);
  }
  // After all libraries, which bring the types.
  for (const fs::path& folder : folders) {
    std::vector<fs::path> manifests;
    std::error_code failed;
    for (const auto& entry : fs::directory_iterator(folder, failed))
      if (entry.path().filename().string().ends_with(".node.yaml")) manifests.push_back(entry.path());
    std::sort(manifests.begin(), manifests.end());
    for (const fs::path& manifest : manifests) registry.load_manifest(manifest);
  }
  return registry;
}

void Registry::add_roles_of(const fs::path& folder) {
  if (!role_folders_.insert(folder).second) return;
  std::vector<fs::path> files;
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(folder / "roles", failed))
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) try {
      roles_.add(file);
    } catch (const std::exception& error) {
      PluginIdentity refused;
      refused.path = file;
      refused.problem = error.what();
      refused_.push_back(refused);
    }
}

/// What a plugin does it does with the user's rights.
static std::string plugin_distrust(const fs::path& library) {
  std::string problem = distrust(library);
  if (problem.empty()) problem = distrust(fs::absolute(library).parent_path());
  return problem.empty() ? "" : "is not believed: " + problem;
}

bool Registry::load(const fs::path& library, bool look_again) {
  add_roles_of(library.parent_path());
  auto plugin = std::make_unique<Plugin>();
  plugin->identity = read_identity(library);
  std::string& problem = plugin->identity.problem;
  if (problem.empty()) problem = plugin_distrust(library);
  try {
    if (problem.empty()) {
      auto behind = std::make_unique<Plugin::Library>();
      behind->path = fs::absolute(library);
      behind->identity = plugin->file_identity = file_identity(behind->path);
      behind->sha256 = plugin->sha256 = sha256_of_file(library);
      PluginScan scan = scan_plugin(behind->path, plugin->sha256, roles_, look_again);
      problem = scan.problem;
      behind->description = std::move(scan.table);
      plugin->linked_build_ids = behind->linked = std::move(scan.linked_build_ids);
      behind->linked_files = std::move(scan.linked_files);
      plugin->library = std::move(behind);
    }
    if (problem.empty()) describe(*plugin);
  } catch (const std::exception& error) {
    problem = error.what();
  }
  return add(std::move(plugin));
}

std::vector<std::string> linked_files(const Plugin& plugin) {
  if (plugin.library) return plugin.library->linked_files;
  if (!plugin.executable) return {};
  std::error_code ignored;
  return {fs::weakly_canonical(plugin.executable->command[0], ignored).filename().string()};
}

void Registry::describe_manifest(Plugin& plugin) {
  const fs::path& manifest = plugin.identity.path;
  if (const std::string problem = plugin_distrust(manifest); !problem.empty()) throw std::runtime_error(problem);
  plugin.executable = read_manifest(manifest, [this](const std::string& name) { return type(name); });
  const ExecutableNode& node = *plugin.executable;
  std::vector<fs::path> files = node.files;
  files.emplace_back(node.command[0]);
  for (const fs::path& file : files)
    if (const std::string problem = plugin_distrust(file); !problem.empty()) throw std::runtime_error(problem);
  for (const fs::path& file : files) plugin.executable->identities[file] = file_identity(file);
  plugin.table = &node.table->table();
  if (const std::string problem = check_table(plugin.table, roles_); !problem.empty())
    throw std::runtime_error(problem);
  plugin.identity.name = plugin.table->name;
  plugin.identity.version = node.version;
  plugin.identity.licence = node.licence;
  std::string hashes;
  for (const fs::path& file : files) hashes += sha256_of_file(file);
  plugin.sha256 = sha256_of(hashes.data(), hashes.size());
  // Many nodes run without it, in other languages; but it is on every one's PYTHONPATH.
  const fs::path module = python_folder() / "plumbline_artifacts.py";
  if (fs::exists(module)) plugin.linked_build_ids.push_back("plumbline_artifacts.py:" + sha256_of_file(module));
}

bool Registry::load_manifest(const fs::path& manifest) {
  add_roles_of(manifest.parent_path());
  auto plugin = std::make_unique<Plugin>();
  plugin->identity.path = manifest;
  try {
    describe_manifest(*plugin);
  } catch (const std::exception& error) {
    plugin->identity.problem = error.what();
  }
  return add(std::move(plugin));
}

static bool is_shipped(const Plugin& plugin) {
  std::error_code failed;
  const fs::path self = fs::read_symlink("/proc/self/exe", failed);
  return !failed && fs::weakly_canonical(plugin.identity.path, failed).parent_path() ==
                        fs::weakly_canonical(self.parent_path().parent_path() / "lib" / "plumbline", failed);
}

bool Registry::add(std::unique_ptr<Plugin> plugin) {
  if (!plugin->identity.problem.empty()) {
    refused_.push_back(plugin->identity);
    return false;
  }
  plugin->shipped = is_shipped(*plugin);
  size_t taken = 0;
  std::map<const Plugin*, std::vector<std::string>> not_taken, replaced;  // by the plugin on the other side
  for (uint32_t i = 0; i < plugin->table->node_count; ++i) {
    const plumbline_node* node = plugin->table->nodes[i];
    const auto [found, fresh] = kinds_.try_emplace(node->kind, Kind{node, plugin.get()});
    const Plugin* other = found->second.plugin;
    const bool in_its_place = !fresh && plugin->shipped && !other->shipped;
    if (in_its_place) found->second = {node, plugin.get()};
    if (fresh || in_its_place) ++taken;
    if (!fresh) (in_its_place ? replaced : not_taken)[other].emplace_back(node->kind);
  }
  for (const auto& [by, kinds] : not_taken) tell_hidden(*plugin, *by, kinds);
  for (const auto& [hidden, kinds] : replaced) tell_hidden(*hidden, *plugin, kinds);
  if (taken == 0 && plugin->table->node_count > 0) return false;
  add_types(*plugin);
  plugins_.push_back(std::move(plugin));
  return true;
}

/// "'a', 'b' and 5 more": `plumbline describe` tells of each by itself.
static std::string quoted_names(const std::vector<std::string>& names) {
  constexpr size_t most = 6;
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), most); ++i)
    text += (i == 0 ? "'" : i + 1 == names.size() ? " and '" : ", '") + names[i] + "'";
  return names.size() > most ? text + " and " + std::to_string(names.size() - most) + " more" : text;
}

void Registry::tell_hidden(const Plugin& hidden, const Plugin& by, const std::vector<std::string>& kinds) {
  for (const std::string& kind : kinds) offered_twice_[kind].push_back(hidden.identity.path);
  const bool has_more =
      std::any_of(hidden.table->nodes, hidden.table->nodes + hidden.table->node_count, [&](const plumbline_node* node) {
        const Kind* kind = find(node->kind);
        return kind && kind->plugin == &hidden;
      });
  PluginIdentity refused = hidden.identity;
  refused.hidden_by = by.identity.path;
  refused.problem = std::string("offers the node") + (kinds.size() > 1 ? "s " : " ") + quoted_names(kinds) +
                    ", which " + by.identity.path.string() + " offers already and which " +
                    (kinds.size() > 1 ? "are" : "is") + " taken from there; rename one of them or take one " +
                    "library off the search path" + (has_more ? "; its other nodes are taken" : "");
  refused_.push_back(refused);
}

/// Of two types of one name each plugin keeps its own, and nodes of the two cannot be connected. By name it is the one
/// that came with the program, else the first.
void Registry::add_types(const Plugin& plugin) {
  for (uint32_t i = 0; i < plugin.table->type_count; ++i) {
    const plumbline_type* type = plugin.table->types[i];
    const auto [found, fresh] = types_.try_emplace(type->name, type);
    const Plugin*& by = brought_by_.try_emplace(type->name, &plugin).first->second;
    const plumbline_type* other = type;
    const Plugin* hidden = &plugin;
    if (plugin.shipped && !by->shipped) std::swap(found->second, other), std::swap(by, hidden);
    if (fresh || std::strcmp(found->second->fingerprint, other->fingerprint) == 0) continue;
    PluginIdentity refused = hidden->identity;
    refused.hidden_by = by->identity.path;
    refused.problem = "brings the type " + std::string(type->name) + " (" + other->fingerprint + "), and " +
                      refused.hidden_by.string() + " another one of that name (" + found->second->fingerprint +
                      "): nodes of the two cannot be connected; build both with one schema, or rename a type";
    refused_.push_back(refused);
  }
}

std::vector<fs::path> Registry::offered_twice_by(const std::string& kind) const {
  const auto found = offered_twice_.find(kind);
  return found == offered_twice_.end() ? std::vector<fs::path>() : found->second;
}

const Kind* Registry::find(const std::string& kind) const {
  const auto found = kinds_.find(kind);
  return found == kinds_.end() ? nullptr : &found->second;
}

const plumbline_type* Registry::type(const std::string& name) const {
  const auto found = types_.find(name);
  return found == types_.end() ? nullptr : found->second;
}

const plumbline_type* Registry::type_of_output(const std::string& kind, const std::string& port,
                                               const std::string& name) const {
  if (const Kind* made_by = find(kind))
    if (const plumbline_port* output = made_by->output(port); output && name == output->type)
      return &made_by->type_of(*output);
  return type(name);
}

}  // namespace plumbline::runtime

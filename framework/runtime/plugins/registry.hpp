// The plugins that are there, and their nodes and types by name.
//
// Discovery looks in $PLUMBLINE_PLUGIN_PATH (folders separated by ':'), in the build tree beside the program
// (../lib/plumbline of the program's folder, which is also where an installation has them). A library is never loaded
// here to see what it offers: a child process does that and tells (plugin_scan.hpp), so that one that crashes, hangs or
// lies costs nothing but itself. Of two libraries that offer a kind of one name the one beside the program has it, else
// the first; all other kinds of the second are taken. What is refused stays in the list with the reason and the mend,
// for `plumbline doctor` and for whoever misses a node. Libraries are never unloaded.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "plumbline/plugin.h"
#include "runtime/base/near_names.hpp"
#include "runtime/plugins/roles.hpp"

namespace plumbline::runtime {

struct ExecutableNode;

/// Identity of a plugin as its ELF note tells it; `problem` is empty if the host accepts it.
struct PluginIdentity {
  std::filesystem::path path;
  std::string name, version, licence, build_id;
  uint32_t abi_major = 0, abi_minor = 0;
  std::string problem;  ///< what was found, what was expected, what to do
  /// Of a library that is sound: another one that offers nodes or types of the same names, which are taken instead.
  std::filesystem::path hidden_by;
};

/// Reads the note of a shared library from the file, without running any code of it.
PluginIdentity read_identity(const std::filesystem::path& library);

/// A plugin as its scan described it. Its library is loaded into this process when the first of its nodes runs.
struct Plugin {
  PluginIdentity identity;
  std::string sha256;                         ///< of the library's file
  std::string file_identity;                  ///< which file it was, to see that it is still the same
  std::vector<std::string> linked_build_ids;  ///< "libceres.so.3:9f3c…" of the libraries it was linked with, sorted
  const plumbline_plugin_table* table = nullptr;  ///< a copy; run() of its nodes loads the library and goes on there

  Plugin();
  ~Plugin();
  struct Library;
  std::unique_ptr<Library> library;
  bool shipped = false;  ///< it came with the program: nothing on a path that somebody sets stands in its place
  std::unique_ptr<ExecutableNode> executable;  ///< in place of a library: a node in another language
};

/// A node kind that can be used in a pipeline.
struct Kind {
  const plumbline_node* node = nullptr;
  const Plugin* plugin = nullptr;

  const plumbline_port* input(const std::string& name) const;   ///< nullptr if it has none of that name
  const plumbline_port* output(const std::string& name) const;  ///< likewise
  const plumbline_param* param(const std::string& name) const;  ///< likewise
  /// The type of one of its ports as its own plugin was built with it: what its bytes mean.
  const plumbline_type& type_of(const plumbline_port& port) const;
};

class Registry {
 public:
  /// The folders that discovery looks in, in order, for a program that lies at `program` (empty: this process's own).
  static std::vector<std::filesystem::path> search_path(const std::filesystem::path& program = {});

  /// Takes every plugin of the folders. Never throws for a bad plugin: see refused(). `look_again`: trust nothing that
  /// was remembered of them.
  static Registry discover(const std::vector<std::filesystem::path>& folders, bool look_again = false);

  /// Takes one library. False if it is refused; then refused() has it with the reason.
  bool load(const std::filesystem::path& library, bool look_again = false);

  /// Takes a node that is an executable, by its manifest (executable_node.hpp). The types of its ports must be known.
  bool load_manifest(const std::filesystem::path& manifest);

  const Kind* find(const std::string& kind) const;
  const std::map<std::string, Kind>& kinds() const { return kinds_; }
  const plumbline_type* type(const std::string& name) const;
  /// The type of what a node gave, as its own plugin has it: another one may call something else by that name. nullptr
  /// if no plugin brings it.
  const plumbline_type* type_of_output(const std::string& kind, const std::string& port, const std::string& type) const;
  const std::map<std::string, const plumbline_type*>& types() const { return types_; }
  const std::vector<std::unique_ptr<Plugin>>& plugins() const { return plugins_; }
  /// What cannot be used: a plugin as a whole, or, where `hidden_by` is set, the nodes and types that another one has.
  const std::vector<PluginIdentity>& refused() const { return refused_; }
  const Roles& roles() const { return roles_; }
  /// The libraries that offer this kind too, and whose nodes of that name are not taken.
  std::vector<std::filesystem::path> offered_twice_by(const std::string& kind) const;

 private:
  static void describe(Plugin& plugin);
  void describe_manifest(Plugin& plugin);
  bool add(std::unique_ptr<Plugin> plugin);
  void tell_hidden(const Plugin& hidden, const Plugin& by, const std::vector<std::string>& kinds);
  void add_types(const Plugin& plugin);
  void add_roles_of(const std::filesystem::path& folder);

  Roles roles_ = Roles::builtin();
  std::set<std::filesystem::path> role_folders_;
  std::vector<std::unique_ptr<Plugin>> plugins_;
  std::vector<PluginIdentity> refused_;
  std::map<std::string, Kind> kinds_;
  std::map<std::string, const plumbline_type*> types_;
  std::map<std::string, const Plugin*> brought_by_;  // types by name
  std::map<std::string, std::vector<std::filesystem::path>> offered_twice_;
};

}  // namespace plumbline::runtime

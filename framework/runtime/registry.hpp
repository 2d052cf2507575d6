// The plugins that are there: found, checked without running them, loaded, and their nodes and types by name.
//
// Discovery looks in $PLUMBLINE_PLUGIN_PATH (folders separated by ':'), in the build tree beside the program
// (../lib/plumbline of the program's folder, which is also where an installation has them). A library that is refused
// stays in the list with the reason, so that `plumbline doctor` can name it. Libraries are never unloaded.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "plumbline/plugin.h"

namespace plumbline::runtime {

/// Identity of a plugin as its ELF note tells it; `problem` is empty if the host accepts it.
struct PluginIdentity {
  std::filesystem::path path;
  std::string name, version, licence, build_id;
  uint32_t abi_major = 0, abi_minor = 0;
  std::string problem;  ///< what was found, what was expected, what to do
};

/// Reads the note of a shared library from the file, without running any code of it.
PluginIdentity read_identity(const std::filesystem::path& library);

struct Plugin {
  PluginIdentity identity;
  std::string sha256;                         ///< of the library's file
  std::vector<std::string> linked_build_ids;  ///< "libceres.so.3:9f3c…" of the libraries it was linked with, sorted
  const plumbline_plugin_table* table = nullptr;
};

/// A node kind that can be used in a pipeline.
struct Kind {
  const plumbline_node* node = nullptr;
  const Plugin* plugin = nullptr;

  const plumbline_port* input(const std::string& name) const;   ///< nullptr if it has none of that name
  const plumbline_port* output(const std::string& name) const;  ///< likewise
  const plumbline_param* param(const std::string& name) const;  ///< likewise
};

class Registry {
 public:
  /// The folders that discovery looks in, in order, for a program that lies at `program` (empty: this process's own).
  static std::vector<std::filesystem::path> search_path(const std::filesystem::path& program = {});

  /// Loads every plugin of the folders. Never throws for a bad plugin: see refused().
  static Registry discover(const std::vector<std::filesystem::path>& folders);

  /// Loads one library. False if it is refused; then refused() has it with the reason.
  bool load(const std::filesystem::path& library);

  const Kind* find(const std::string& kind) const;
  const std::map<std::string, Kind>& kinds() const { return kinds_; }
  const plumbline_type* type(const std::string& name) const;
  const std::map<std::string, const plumbline_type*>& types() const { return types_; }
  const std::vector<std::unique_ptr<Plugin>>& plugins() const { return plugins_; }
  const std::vector<PluginIdentity>& refused() const { return refused_; }

 private:
  std::vector<std::unique_ptr<Plugin>> plugins_;
  std::vector<PluginIdentity> refused_;
  std::map<std::string, Kind> kinds_;
  std::map<std::string, const plumbline_type*> types_;
};

/// Up to three of `candidates` that are near `wanted` (optimal string alignment distance), best first.
std::vector<std::string> near_names(const std::string& wanted, const std::vector<std::string>& candidates);

}  // namespace plumbline::runtime

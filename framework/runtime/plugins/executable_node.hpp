// A node that is an executable in any language, declared by a manifest NAME.node.yaml in a folder of plugins.
//
// It is started once for each run with one argument more than its manifest says, a folder:
//
//   call.json             {"kind", "parameters": {name: value}, "references": {uri of an artifact: path}, "seed"}; the
//                         seed only if the manifest says `seed: true`
//   inputs/PORT/000000    the artifacts of every connected input, in their order
//   schemas/NAME.bfbs     the binary schema of every type of its ports: plumbline.Points/1 is plumbline.Points-1.bfbs
//   outputs/PORT/         where it writes its artifacts; they are taken in the order of their names
//   used                  if it writes it: files that its results depend on and the manifest does not name, a path a
//                         line, or "absent:" and the path of one that was looked for and is not there;
//                         plumbline_artifacts.py writes all modules that were imported, and those that would have been
//                         taken before them
//
// Inputs are verified before it sees them and outputs before anybody else does. It ends with exit code 0; with any
// other the last lines it printed are the error. A printed line that begins with "warning: " is a warning.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "runtime/base/quantities.hpp"
#include "runtime/plugins/plugin_table.hpp"

namespace plumbline::runtime {

struct ExecutableNode {
  std::filesystem::path manifest;
  std::vector<std::string> command;          ///< absolute where it names files beside the manifest
  std::vector<std::filesystem::path> files;  ///< what its results depend on: manifest, program, scripts, `needs`
  bool wants_seed = false;
  Limits limits;
  std::string version, licence;
  std::unique_ptr<PluginTable> table;  ///< of the one node
  /// Of `files` and the program, before they were hashed: whether they are still what the key says.
  std::map<std::filesystem::path, std::string> identities;

  /// One run. `limits`: where they say something, in place of the manifest's; `used`: gets what it says of that.
  /// Returns 0, or 1 after fail().
  int run(const plumbline_host& host, const plumbline_node& entry, const Limits& limits,
          std::vector<std::string>& used) const;
};

/// `type_of`: the types that are known, by name. Throws std::runtime_error with what is wrong with the manifest, its
/// line, and the mend.
std::unique_ptr<ExecutableNode> read_manifest(const std::filesystem::path& manifest,
                                              const std::function<const plumbline_type*(const std::string&)>& type_of);

/// The folder of the Python module plumbline_artifacts, which a node's PYTHONPATH gets: that of the installation, or of
/// the tree that was built.
std::filesystem::path python_folder();

}  // namespace plumbline::runtime

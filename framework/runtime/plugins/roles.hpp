// Roles: what the nodes that can stand in for each other have in common. One file a role: those of schemas/roles are
// compiled in; a folder of plugins may bring its own in roles/*.yaml beside the libraries.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "plumbline/plugin.h"

namespace plumbline::runtime {

struct RolePort {
  std::string name, type, frames, doc;
  uint32_t cardinality = PLUMBLINE_ONE;
  /// A kind may do without this input: a scan needs no photographs. What a pipeline connects to it is left out then, so
  /// that the kinds are swapped by one word.
  bool may_lack = false;
};

/// What `plumbline bench` computes of a node of the role by a node that belongs to neither of those it compares.
struct RoleMeasure {
  std::string quantity;                       ///< "start_cost"
  std::string use, metric;                    ///< kind of the node that computes it, and which of its metrics it is
  std::map<std::string, std::string> inputs;  ///< its port -> "in.PORT" or "out.PORT" of the node that is judged
  std::map<std::string, std::string> parameters = {};  ///< its parameter -> that of the node, where it has it
};

struct Role {
  std::string name, doc;
  std::vector<RolePort> inputs, outputs;
  std::vector<RoleMeasure> measures;
};

class Roles {
 public:
  /// Those of schemas/roles.
  static Roles builtin();

  /// Adds the role of a file. Throws std::runtime_error with what is wrong: not a role, or another one of that name.
  void add(const std::filesystem::path& file);

  const std::map<std::string, Role>& all() const { return roles_; }

  /// Whether the node's role has that input and lets its kinds do without it.
  bool may_lack(const plumbline_node& node, const std::string& input) const;

  /// Why a node has not the ports of the role it claims, naming the port; "" if it has, or claims none. Frame variables
  /// may be named otherwise.
  std::string problem_of(const plumbline_node& node) const;

 private:
  void add(const std::string& yaml, const std::string& where);
  std::map<std::string, Role> roles_;
};

const char* cardinality_text(uint32_t cardinality);  ///< "one", "optional", "list", "each"

}  // namespace plumbline::runtime

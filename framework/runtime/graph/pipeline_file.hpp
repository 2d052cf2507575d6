// A pipeline as written: YAML with its positions, includes merged, variables replaced, overrides of the command line
// applied. What the names mean (kinds, ports, parameters) is the business of graph.cpp.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "runtime/graph/graph.hpp"

namespace plumbline::runtime {

/// A scalar after replacement of variables, with where it was written.
struct Scalar {
  std::string text;
  Position at;
  std::filesystem::path base;  ///< folder that a relative path in it is relative to
  bool unresolved = false;     ///< a variable in it has no value, which was told; the text says nothing
  Position given_at = {};      ///< of the variable that is all of it; no file: it was written here
};

struct ParameterSpec {
  std::vector<Scalar> values;
  bool is_list = false;
  Position at;  ///< of the parameter's name
};

struct NodeSpec {
  std::string name;
  Position at;
  Scalar use;
  std::vector<std::pair<std::string, Scalar>> inputs;  ///< port -> "node.port"; Scalar::at is that of the port's name
  std::vector<std::pair<std::string, ParameterSpec>> parameters;
  using Condition = std::pair<std::string, Scalar>;
  std::vector<Condition> conditions = {};  ///< how it is run: "isolate", "time_limit", "memory_limit"
  Scalar each = {};                        ///< an input for each of whose items it runs, though its port takes one
  Scalar for_each = {};                    ///< the role of whose kinds it stands for each (role_expansion.hpp)
};

/// `rounds:` as written; a scalar without text was not given.
struct RoundsSpec {
  struct Carry {
    std::string name;
    Position at;
    Scalar first, next;
  };
  bool given = false;
  Position at;
  std::vector<Carry> carry;
  Scalar until, most;
};

struct PipelineSpec {
  std::vector<NodeSpec> nodes;                          ///< in the file's order, included files first
  std::vector<std::pair<std::string, Scalar>> outputs;  ///< file -> "node.port"
  RoundsSpec rounds;
  std::map<std::string, std::string> variables;  ///< final values
  std::vector<SourceFile> sources;               ///< the file itself, then what it includes
};

/// A pipeline written by hand has some kilobytes. What is larger is no pipeline, and would take minutes to find out.
constexpr std::uintmax_t largest_pipeline_file = std::uintmax_t{16} << 20;

/// Reads `file` and what it includes, each file once. What an include names is looked for beside the file that names it
/// and then in `include_folders`, with or without ".yaml". Everything wrong with the text goes to `problems`; what
/// could be read is returned. `registry`: what nodes with `for_each` stand for; without one they are left out.
PipelineSpec read_pipeline(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                           const std::vector<std::filesystem::path>& include_folders, std::vector<Problem>& problems,
                           const Registry* registry = nullptr);

/// True if the override is about a node (`poses.use=…`), not about a variable.
bool is_node_override(const std::string& text);

}  // namespace plumbline::runtime

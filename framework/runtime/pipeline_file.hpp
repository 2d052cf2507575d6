// A pipeline as written: YAML with its positions, includes merged, variables replaced, overrides of the command line
// applied. What the names mean (kinds, ports, parameters) is the business of graph.cpp.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "runtime/graph.hpp"

namespace plumbline::runtime {

/// A scalar after replacement of variables, with where it was written.
struct Scalar {
  std::string text;
  Position at;
  std::filesystem::path base;  ///< folder that a relative path in it is relative to
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
};

struct PipelineSpec {
  std::vector<NodeSpec> nodes;                          ///< in the file's order, included files first
  std::vector<std::pair<std::string, Scalar>> outputs;  ///< file -> "node.port"
  std::map<std::string, std::string> variables;         ///< final values
  std::string text;                                     ///< of the file itself
};

/// Reads `file` and what it includes. Everything wrong with the text goes to `problems`; what could be read is
/// returned.
PipelineSpec read_pipeline(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                           std::vector<Problem>& problems);

}  // namespace plumbline::runtime

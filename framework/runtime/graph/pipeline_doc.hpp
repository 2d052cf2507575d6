// What a pipeline file tells of itself, without being given its variables: for people who look what there is.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace plumbline::runtime {

struct VariableDoc {
  std::string name, value;  ///< the default; empty if required
  bool required = false;    ///< has to be given on the command line
  std::string comment;      ///< that stands behind it in the file
  /// Where it goes as a whole value: node.parameter, and the node's kind, which has the parameter's doc.
  struct Use {
    std::string node, kind, parameter;
  };
  std::vector<Use> uses;
};

struct PipelineDoc {
  std::string summary;  ///< the comment at the head of the file, lines joined by line ends
  std::vector<VariableDoc> variables;
  std::vector<std::string> outputs;
};

/// Reads `file` and what it includes (beside it, then in `include_folders`). What is wrong with it is not its business.
/// Throws std::runtime_error if the file cannot be read as YAML.
PipelineDoc read_pipeline_doc(const std::filesystem::path& file,
                              const std::vector<std::filesystem::path>& include_folders);

}  // namespace plumbline::runtime

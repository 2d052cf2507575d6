#include "runtime/graph/pipeline_doc.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>

#include "base/text/one_document.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw std::runtime_error("cannot read " + file.string());
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

/// The comments before the first line of YAML, but the one that tells editors of the schema.
std::string head_of(const std::string& text) {
  std::istringstream lines(text);
  std::string head;
  for (std::string line; std::getline(lines, line) && !line.empty() && line[0] == '#';) {
    if (line.rfind("# yaml-language-server:", 0) == 0) continue;
    head += (head.empty() ? "" : "\n") +
            line.substr(std::min<size_t>(line.size(), line.size() > 1 && line[1] == ' ' ? 2 : 1));
  }
  return head;
}

/// Of variables on one line, `vars: {a: 1, b: 2}   # a: what it is; b: that`.
std::string comment_in_line(const std::string& line, const std::string& name) {
  const size_t mark = line.find(" # ", line.rfind('}'));
  if (mark == std::string::npos) return "";
  std::istringstream parts(line.substr(mark + 3));
  for (std::string part; std::getline(parts, part, ';');) {
    const size_t start = part.find_first_not_of(' ');
    if (start != std::string::npos && part.compare(start, name.size() + 2, name + ": ") == 0)
      return part.substr(start + name.size() + 2);
  }
  return "";
}

/// What stands behind '#' in the line of a variable that has a line of its own.
std::string comment_of(const std::string& text, const std::string& name) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("vars: {", 0) == 0) return comment_in_line(line, name);
    const size_t start = line.find_first_not_of(' ');
    if (start == std::string::npos || start == 0 || line.compare(start, name.size() + 1, name + ":") != 0) continue;
    const size_t mark = line.find(" # ");
    return mark == std::string::npos ? "" : line.substr(mark + 3);
  }
  return "";
}

class Reader {
 public:
  explicit Reader(const std::vector<fs::path>& folders) : folders_(folders) {}

  PipelineDoc read(const fs::path& file) {
    PipelineDoc doc;
    doc.summary = head_of(text_of(file));
    collect(file);
    for (const std::string& name : order_) {
      VariableDoc variable = variables_.at(name);
      for (const auto& [node, with] : parameters_)
        for (const auto& [parameter, value] : with)
          if (value == "${" + name + "}") variable.uses.push_back({node, kinds_[node], parameter});
      doc.variables.push_back(std::move(variable));
    }
    // What somebody must give stands first.
    std::stable_partition(doc.variables.begin(), doc.variables.end(), [](const auto& v) { return v.required; });
    doc.outputs = outputs_;
    return doc;
  }

 private:
  void collect(const fs::path& file) {
    std::error_code ignored;
    if (!read_.insert(fs::weakly_canonical(file, ignored)).second) return;
    const std::string text = text_of(file);
    YAML::Node root;
    try {
      root = text::load_one_document(text);
    } catch (const YAML::Exception& error) {
      throw std::runtime_error(file.string() + ": " + error.what());
    }
    if (!root.IsMap()) return;
    const YAML::Node includes = root["include"];
    if (includes && includes.IsScalar()) include(file, includes.Scalar());
    if (includes && includes.IsSequence())
      for (const auto& item : includes)
        if (item.IsScalar()) include(file, item.Scalar());
    if (root["vars"] && root["vars"].IsMap())
      for (const auto& item : root["vars"]) add_variable(item.first.as<std::string>(""), item.second, text);
    if (root["nodes"] && root["nodes"].IsMap())
      for (const auto& item : root["nodes"]) add_node(item.first.as<std::string>(""), item.second);
    if (root["outputs"] && root["outputs"].IsMap())
      for (const auto& item : root["outputs"]) outputs_.push_back(item.first.as<std::string>(""));
  }

  void include(const fs::path& file, const std::string& name) {
    std::vector<fs::path> folders{file.parent_path()};
    folders.insert(folders.end(), folders_.begin(), folders_.end());
    for (const fs::path& folder : folders)
      for (const fs::path& candidate : {folder / name, folder / (name + ".yaml")})
        if (fs::is_regular_file(candidate)) return collect(candidate);
  }

  void add_variable(const std::string& name, const YAML::Node& value, const std::string& text) {
    if (!variables_.count(name)) order_.push_back(name);
    const std::string comment = comment_of(text, name);
    VariableDoc& variable = variables_[name];
    variable.name = name, variable.required = !value.IsScalar();
    variable.value = value.IsScalar() ? value.Scalar() : "";
    if (!comment.empty()) variable.comment = comment;
    if (name == "seed" && variable.comment.empty()) variable.comment = "of all that is random in the run";
  }

  /// A scalar, or the one that a list holds: `rules: ["${rule}"]` takes a rule as `rules` does.
  static std::string only_value(const YAML::Node& value) {
    if (value.IsSequence() && value.size() == 1 && value[0].IsScalar()) return value[0].Scalar();
    return value.IsScalar() ? value.Scalar() : "";
  }

  void add_node(const std::string& name, const YAML::Node& node) {
    if (!node.IsMap()) return;
    if (node["use"] && node["use"].IsScalar()) kinds_[name] = node["use"].Scalar();
    if (node["with"] && node["with"].IsMap())
      for (const auto& item : node["with"]) parameters_[name][item.first.as<std::string>("")] = only_value(item.second);
  }

  const std::vector<fs::path>& folders_;
  std::set<fs::path> read_;
  std::vector<std::string> order_, outputs_;
  std::map<std::string, VariableDoc> variables_;
  std::map<std::string, std::string> kinds_;                              // by node
  std::map<std::string, std::map<std::string, std::string>> parameters_;  // by node, then parameter
};

}  // namespace

PipelineDoc read_pipeline_doc(const fs::path& file, const std::vector<fs::path>& include_folders) {
  return Reader(include_folders).read(file);
}

}  // namespace plumbline::runtime

// The variables of a pipeline: declared under `vars`, given there or on the command line, and put in place of ${name}.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "runtime/graph/pipeline_file.hpp"

namespace plumbline::runtime {

class PipelineVariables {
 public:
  /// What is wrong goes to `problems`.
  explicit PipelineVariables(std::vector<Problem>& problems) : problems_(problems) {}

  /// A later declaration replaces an earlier one, as an including file may. Not `given`: it has to be on the command
  /// line.
  void declare(const std::string& name, const Scalar& value, bool given) {
    variables_[name] = {value, given, value.at};
  }
  /// Every value of the files, also one that an including file or the command line replaces: what it names is used.
  void mention(const std::string& text);
  /// Tells of variables that no value of the files or of the overrides names: what they say would be without effect.
  void tell_unused(const std::vector<std::string>& overrides);
  /// KEY=VALUE of the command line; those for nodes are passed over.
  void apply(const std::vector<std::string>& overrides);
  /// Replaces what variables hold of other variables.
  void resolve();
  /// Replaces every ${name}; a path that came with a variable stays relative to where the variable was given.
  void replace(Scalar& scalar);

  bool has(const std::string& name) const { return variables_.count(name) != 0; }
  std::map<std::string, std::string> values() const;

 private:
  struct Variable {
    Scalar value;
    bool given = false;  ///< has a value
    Position declared;
    enum { open, busy, done } state = open;
  };

  void problem(const Position& at, const std::string& message) { problems_.push_back({at, message}); }
  std::string did_you_mean(const std::string& wanted) const;
  /// Near names, or all there are and how parameters are set.
  std::string near_or_all(const std::string& wanted) const;
  void resolve(Variable& variable);

  std::vector<Problem>& problems_;
  std::map<std::string, Variable> variables_;
  std::set<std::string> mentioned_;
  std::set<std::string> told_;  // variables without a value that were told of
};

}  // namespace plumbline::runtime

// What every kind declares is held: an input or a parameter that is missing, a value out of its range or of another
// sort is named with what was found, what is expected and where, before anything runs; and each value counts in the
// key.
#include <cmath>
#include <fstream>

#include "node_by_node.hpp"
#include "runtime/run/key.hpp"

namespace plumbline::test {
namespace declarations_tests {

using runtime::Problem;

/// What is wrong with one node of the kind that has these parameters and no inputs.
std::vector<Problem> problems_of(const std::string& kind, const std::string& with) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "p.yaml";
  std::ofstream(file) << "plumbline: 1\nnodes:\n  n:\n    use: " << kind << "\n    with: {" << with << "}\n";
  try {
    runtime::load_pipeline(file, {}, built_registry(), {folder.path()});
  } catch (const runtime::InvalidPipeline& invalid) {
    return invalid.problems();
  }
  return {};
}

/// The place and text of the first problem that has this in it; empty: none has.
std::string problem_with(const std::vector<Problem>& problems, const std::string& part) {
  for (const Problem& problem : problems)
    if (problem.message.find(part) != std::string::npos) return problem.at.text() + ": " + problem.message;
  return "";
}

bool is_number(const plumbline_param& param) {
  return param.kind == PLUMBLINE_NUMBER || param.kind == PLUMBLINE_INTEGER;
}

/// Values that it must refuse, and a part of what it must say is expected.
std::vector<std::pair<std::string, std::string>> refused_values(const plumbline_param& param) {
  std::vector<std::pair<std::string, std::string>> values;
  const bool whole = param.kind == PLUMBLINE_INTEGER;
  if (is_number(param)) {
    for (const char* const text : {"nan", "inf", "much", ""})
      values.emplace_back(text, whole ? "a whole number" : "a number");
    if (whole) values.emplace_back("1.5", "a whole number");
    const auto beyond = [&](double bound, double sign) {
      return detail::number_text(bound + sign * (whole ? 1 : std::max(1e-3, 1e-3 * std::abs(bound))), whole);
    };
    if (std::isfinite(param.minimum))
      values.emplace_back(beyond(param.minimum, -1), std::isfinite(param.maximum) ? "between " : "at least ");
    if (std::isfinite(param.maximum))
      values.emplace_back(beyond(param.maximum, 1), std::isfinite(param.minimum) ? "between " : "at most ");
  }
  if (param.default_text)  // what nobody knows may be a default
    std::erase_if(values, [&](const auto& value) { return value.first == param.default_text; });
  if (param.kind == PLUMBLINE_BOOLEAN) values = {{"maybe", "true or false"}, {"", "true or false"}};
  if (param.choice_count > 0) values = {{"no such choice", std::string("one of ") + param.choices[0]}};
  if (param.kind == PLUMBLINE_FILE || param.kind == PLUMBLINE_FOLDER)
    values = {{"/nowhere/at/all",
               param.kind == PLUMBLINE_FILE ? "there is no file /nowhere" : "there is no folder /nowhere"}};
  return values;
}

template <typename Look>
void for_each_parameter(const Look& look) {
  for (const auto& [name, kind] : built_registry().kinds())
    for (uint32_t i = 0; i < kind.node->param_count; ++i) look(name, *kind.node->params[i]);
}

TEST(Declarations, WhatIsMissingIsNamedWithItsPlace) {
  ASSERT_GT(built_registry().kinds().size(), 100u);
  for (const auto& [name, kind] : built_registry().kinds()) {
    const std::vector<Problem> problems = problems_of(name, "");
    for (uint32_t i = 0; i < kind.node->input_count; ++i) {
      const plumbline_port& port = *kind.node->inputs[i];
      if (port.cardinality == PLUMBLINE_OPTIONAL) continue;
      const std::string told =
          problem_with(problems, "input '" + std::string(port.name) + "' of 'n' (" + name + ") is not connected");
      EXPECT_NE(told.find("p.yaml:3:3: "), std::string::npos) << name << " " << port.name << ": " << told;
      EXPECT_NE(told.find(std::string(port.type) + ": " + port.doc), std::string::npos) << name << ": " << told;
    }
    for (uint32_t i = 0; i < kind.node->param_count; ++i) {
      const plumbline_param& param = *kind.node->params[i];
      if (param.default_text) continue;
      const std::string told = problem_with(problems, std::string("with: {") + param.name + ": ");
      EXPECT_NE(told.find("p.yaml:3:3: node 'n' "), std::string::npos) << name << " " << param.name << ": " << told;
      EXPECT_NE(told.find(param.doc), std::string::npos) << name << " " << param.name << ": " << told;
    }
  }
}

TEST(Declarations, AValueThatAParameterDoesNotTakeIsRefusedWithWhatItTakes) {
  for_each_parameter([](const std::string& kind, const plumbline_param& param) {
    for (const auto& [value, expected] : refused_values(param)) {
      const std::string written = param.is_list ? "['" + value + "']" : "'" + value + "'";
      const std::string told = problem_with(problems_of(kind, std::string(param.name) + ": " + written),
                                            "parameter '" + std::string(param.name) + "' of '" + kind + "'");
      EXPECT_NE(told.find(expected), std::string::npos) << kind << " " << param.name << ": " << written << ": " << told;
      EXPECT_NE(told.find("p.yaml:5:"), std::string::npos) << kind << " " << param.name << ": " << told;
      const bool path = param.kind == PLUMBLINE_FILE || param.kind == PLUMBLINE_FOLDER;
      if (!path) {
        EXPECT_NE(told.find("found '" + value + "'"), std::string::npos) << kind << " " << param.name << ": " << told;
      }
    }
  });
}

/// A default that its own declaration would refuse can be had only by not writing it.
TEST(Declarations, DefaultsMayBeWritten) {
  for_each_parameter([](const std::string& kind, const plumbline_param& param) {
    if (!param.default_text || param.kind == PLUMBLINE_FILE || param.kind == PLUMBLINE_FOLDER) return;
    std::string written;
    for (const char* c = param.default_text; *c; ++c) written += *c == '\x1f' ? "', '" : std::string(1, *c);
    written = param.is_list ? (*param.default_text ? "['" + written + "']" : "[]") : "'" + written + "'";
    EXPECT_EQ(problem_with(problems_of(kind, std::string(param.name) + ": " + written),
                           "parameter '" + std::string(param.name) + "' of "),
              "")
        << written;
  });
}

TEST(Declarations, EveryValueCountsInTheKey) {
  const TemporaryFolder folder;
  runtime::FileHashes files("/dev/null");
  const std::string file = folder.path() / "file", tree = folder.path() / "tree";
  std::ofstream(file) << "content";
  std::filesystem::create_directory(tree);
  for (const auto& [name, kind] : built_registry().kinds()) {
    runtime::GraphNode node;
    node.kind = kind;
    for (uint32_t i = 0; i < kind.node->param_count; ++i) {
      const plumbline_param& param = *kind.node->params[i];
      node.parameters[param.name] = param.default_text ? param.default_text : "";
      if (param.kind == PLUMBLINE_FILE || param.kind == PLUMBLINE_FOLDER) node.parameters[param.name] = "";
    }
    const std::string by_default = runtime::key_of(runtime::key_fields(node, files));
    for (auto& [parameter, text] : node.parameters) {
      const plumbline_param& param = *kind.param(parameter);
      const std::string before = text;
      std::vector<std::string> others = detail::other_values(param, before);
      if (param.kind == PLUMBLINE_FILE) others = {file};
      if (param.kind == PLUMBLINE_FOLDER) others = {tree};
      EXPECT_TRUE(!others.empty() || param.choice_count == 1) << name << " " << parameter << " takes one value only";
      for (const std::string& other : others) {
        text = other;
        EXPECT_NE(runtime::key_of(runtime::key_fields(node, files)), by_default) << name << " " << parameter << other;
      }
      text = before;
    }
  }
}

}  // namespace declarations_tests
}  // namespace plumbline::test

// What the alternatives of a bench fill: a node of the name of their group, or the nodes of the role of that name.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "runtime/sweep/sweep_file.hpp"

namespace plumbline::runtime {

/// One way to fill every place of a bench, without the seed.
struct Combination {
  const SweepScenario* scenario = nullptr;
  std::map<std::string, std::string> values;               ///< of the matrix, by variable
  std::map<std::string, const SweepAlternative*> choices;  ///< by group
};

/// The file's pipeline, or that of the scenario or of one of the alternatives.
std::filesystem::path pipeline_of(const SweepFile& file, const Combination& way);

/// The node of the pipeline that a list of kinds fills: the one of that name, else the one of that role. Throws
/// std::runtime_error where there is none, or several.
std::string node_for(const std::filesystem::path& pipeline, const std::string& group, const Overrides& overrides,
                     const Registry& registry);

/// Refuses what would make every cell of an alternative, or of the whole bench, fail one by one: a pipeline that takes
/// no seed, and a kind in a place that no pipeline has, or that another role fills. Throws InvalidPipeline.
void refuse_what_cannot_run(const SweepFile& file, const Overrides& overrides, const Registry& registry);

/// Refuses kinds of lists that no plugin brings, as KEY=VALUE with such a kind is: a slip of the pen is none of the
/// alternatives. Of an archive, whose plugins may be elsewhere, such cells are planned and told one by one. Throws
/// InvalidPipeline.
void refuse_unknown_kinds(const SweepFile& file, const Registry& registry);

}  // namespace plumbline::runtime

// Which file an `include` of a pipeline means: its name, with values of variables in it, beside the file or in the
// folders of pipelines.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace plumbline::runtime {

/// Value of a variable; nothing where none is given.
using ValueOfVariable = std::function<std::optional<std::string>(const std::string& name)>;

/// `name` with each ${variable} replaced. `unknown`: the first one without a value; empty if there is none.
std::string with_values(const std::string& name, const ValueOfVariable& value_of, std::string& unknown);

/// The file of that name, ".yaml" may be left out: beside `file`, else in `folders`; empty if there is none.
std::filesystem::path find_include(const std::filesystem::path& file, const std::string& name,
                                   const std::vector<std::filesystem::path>& folders);

/// Where it was looked for, and, of a `name` with variables, the files beside that other values would name.
std::string included_places(const std::filesystem::path& file, const std::string& name, const std::string& replaced,
                            const std::vector<std::filesystem::path>& folders);

}  // namespace plumbline::runtime

// The command that runs a pipeline, as one types it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace plumbline::runtime {

/// "plumbline run building shape=flat floors=5": the pipeline by its name where it lies in one of `folders`, else by
/// its path; what a shell would take apart stands in single quotes.
std::string command_words(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                          const std::vector<std::filesystem::path>& folders);

}  // namespace plumbline::runtime

// Names under the output folder that a pipeline may give.
#pragma once

#include <string>

namespace plumbline::runtime {

/// Why `name` cannot be the name of an output, as a sentence; empty: it can.
std::string output_name_problem(const std::string& name);

}  // namespace plumbline::runtime

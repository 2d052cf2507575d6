// What of the world outside a run read, in words: for pipelines whose result does not say it itself.
#pragma once

#include <string>
#include <vector>

#include "runtime/graph/graph.hpp"
#include "runtime/run/executor.hpp"

namespace plumbline::cli {

/// Whether a line of a result says what took part, as nodes do that know what of it they used.
bool says_what_took_part(const std::string& line);

/// "Read: 6 images of the 7 files in photos; 1 file (board.yaml)." Files that parameters name, and of folders how many
/// files lie in them and what lists were made of these. Empty where the run read nothing from outside.
std::string what_was_read(const runtime::Graph& graph, const runtime::RunResult& result, bool german);

}  // namespace plumbline::cli

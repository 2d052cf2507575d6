// A journal that lies where a run delivers to is not replaced by one that lacks what was reported to it.
#pragma once

#include <filesystem>
#include <istream>
#include <string>
#include <vector>

#include "runtime/run/executor.hpp"

namespace plumbline::runtime {

/// What outputs named journal.jsonl would lose in `out`, in words with what to do; empty: nothing. Lost are lines that
/// say who did something and when (`by` and `at`), and that no line of the new journal has (`kind`, `item`, `by`,
/// `at`). What is simulated has no date, and may be run anew.
std::string lost_reports(const Graph& graph, Store& store, const RunResult& result, const std::filesystem::path& out);

/// Of two journals, one JSON object a line, the reports of `there` that `now` lacks, as "ITEM by WHO at WHEN".
std::vector<std::string> missing_reports(std::istream& there, std::istream& now);

}  // namespace plumbline::runtime

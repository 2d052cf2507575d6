// A bench as a supplement of a paper: a folder from which any cell can be made again and compared.
//
//   archive.json   {"plumbline_archive": 1, "bench", "overrides", "seeds", "scenarios", "cells", "machine", "files",
//                  "inputs"}: the bench file, how many cells it has and how many of them are archived, what was given
//                  on the command line, version, commit, compiler and libraries of the program and of the plugins that
//                  cells run, plugins with their hashes and build ids of what they are linked with; hashes of the files
//                  beside, and of files that parameters of nodes name
//   files/...      the bench file, its pipelines and all that they include, as they lie to each other
//   cells.jsonl    a line a cell: {"cell", "result"}; "result" as in the store, without host and times
//
// Inputs are not copied, they may be photographs of many gigabytes: they are named with their hashes.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "runtime/sweep/sweep_table.hpp"

namespace plumbline::runtime {

/// Throws std::runtime_error if the folder has something in it and is no archive: that would be replaced.
void require_place_for_archive(const std::filesystem::path& folder, const SweepFile& file);

/// Replaces what an earlier one wrote into the folder. Throws std::runtime_error.
void write_archive(const std::filesystem::path& folder, const SweepPlan& plan, const Overrides& overrides,
                   const CellRecords& records, const Registry& registry, FileHashes& hashes, const BuildFacts& build);

struct Archive {
  std::filesystem::path bench;                 ///< the file in the archive
  std::vector<std::filesystem::path> folders;  ///< of its files: where pipelines are found by name, and nowhere else
  Overrides overrides;
  std::vector<uint64_t> seeds;
  std::vector<std::string> scenarios;  ///< of the file's, those that ran
  std::string commit;
  std::size_t planned = 0;                     ///< cells of the bench, archived or not; 0: not told
  std::map<std::string, std::string> results;  ///< by label of the cell
  std::map<std::string, std::string> inputs;   ///< hashes, by path
};
/// Throws std::runtime_error that says what of it is missing, damaged or changed.
Archive read_archive(const std::filesystem::path& folder);

/// Files, folders and programs that the archived cells were made from and those of `plan` are not, in words. They are
/// known by their bytes, wherever they lie.
std::vector<std::string> changed_inputs(const Archive& archive, const SweepPlan& plan, FileHashes& hashes);

/// Metrics of two results that differ by more than `tolerance` of themselves, another status, another reason of a
/// failure, or a metric that one lacks; empty if they agree. Hashes of inputs are not compared, nor names of files in
/// reasons; numbers with decimals in reasons agree to one in their last place.
std::string difference_of(const std::string& archived, const std::string& again, double tolerance);

}  // namespace plumbline::runtime

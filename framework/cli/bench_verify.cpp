#include "bench_verify.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <set>

#include "build_info.hpp"
#include "commands.hpp"
#include "runtime/sweep/sweep_archive.hpp"
#include "runtime/sweep/sweep_run.hpp"
#include "terminal.hpp"

namespace plumbline::cli {

namespace fs = std::filesystem;

namespace {

/// Results that were not there before are what is asked for, so the store is one that is thrown away.
class PassingFolder {
 public:
  PassingFolder() {
    std::string name = (fs::temp_directory_path() / "plumbline-verify-XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("cannot make a folder " + name);
    folder_ = name;
  }
  PassingFolder(const PassingFolder&) = delete;
  PassingFolder& operator=(const PassingFolder&) = delete;
  ~PassingFolder() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  const fs::path& path() const { return folder_; }

 private:
  fs::path folder_;
};

/// `count` of the cells that the archive has results of, spread evenly; whole trials are not asked for.
std::vector<size_t> spread_over(const runtime::SweepPlan& plan, const runtime::Archive& archive, size_t count) {
  std::vector<size_t> known, chosen;
  for (size_t i = 0; i < plan.cells.size(); ++i)
    if (archive.results.count(plan.cells[i].label())) known.push_back(i);
  if (count == 0 || count >= known.size()) return known;
  for (size_t k = 0; k < count; ++k) chosen.push_back(known[k * known.size() / count]);
  return chosen;
}

/// Archived cells that are none of the plan: kinds that are not here, in a list that says `all`.
std::vector<std::string> without_cell(const runtime::SweepPlan& plan, const runtime::Archive& archive) {
  std::set<std::string> planned;
  for (const runtime::SweepCell& cell : plan.cells) planned.insert(cell.label());
  std::vector<std::string> gone;
  for (const auto& [label, result] : archive.results)
    if (planned.count(label) == 0) gone.push_back(label);
  return gone;
}

/// What is given here holds in place of what the bench was run with.
void put_in_place(const std::vector<std::string>& given, runtime::Overrides& overrides) {
  const auto key_of = [](const std::string& text) { return text.substr(0, text.find('=')); };
  for (const std::string& one : given) {
    std::erase_if(overrides, [&](const std::string& other) { return key_of(other) == key_of(one); });
    overrides.push_back(one);
  }
}

/// `bench verify ARCHIVE [KEY=VALUE ...]`
void require_archive_and_settings(const BenchOptions& options) {
  if (!options.seeds.empty() || !options.scenarios.empty())
    throw UsageError(
        "'plumbline bench verify' makes cells again that lie spread over all of the archive: --seeds and --scenario "
        "choose none of them; leave them out, and give --cells 0 for all cells");
  if (options.overrides.empty() || options.overrides[0].find('=') != std::string::npos)
    throw UsageError(
        "'plumbline bench verify' takes a folder that --archive wrote, and KEY=VALUE for inputs and programs that lie "
        "elsewhere here");
  for (size_t i = 1; i < options.overrides.size(); ++i)
    if (options.overrides[i].find('=') == std::string::npos)
      throw UsageError("'plumbline bench verify' takes one folder; '" + options.overrides[i] + "' is no KEY=VALUE");
}

}  // namespace

void keep_only(runtime::SweepFile& file, const std::vector<std::string>& wanted) {
  const auto unwanted = [&](const std::string& name) {
    return std::find(wanted.begin(), wanted.end(), name) == wanted.end();
  };
  std::erase_if(file.scenarios, [&](const auto& scenario) { return unwanted(scenario.name); });
  std::erase_if(file.weights, [&](const auto& weight) { return unwanted(weight.first); });
  std::erase_if(file.exclude, [&](const auto& exclusion) {
    const auto named = exclusion.where.find("scenario");
    return named != exclusion.where.end() && unwanted(named->second);
  });
}

int verify_bench(const BenchOptions& options) {
  constexpr double tolerance = 1e-9;
  require_archive_and_settings(options);
  const std::string folder = options.overrides.at(0);
  if (!std::filesystem::is_regular_file(std::filesystem::path(folder) / "cells.jsonl"))
    throw UsageError(folder + " is no archive of a bench: plumbline bench FILE --archive DIR makes one");
  runtime::Archive archive = runtime::read_archive(folder);
  put_in_place({options.overrides.begin() + 1, options.overrides.end()}, archive.overrides);
  const runtime::Registry registry = discover();
  runtime::SweepFile file = read_sweep(archive.bench, registry, archive.folders);
  file.seeds = archive.seeds;
  if (!archive.scenarios.empty()) keep_only(file, archive.scenarios);
  const PassingFolder passing;
  runtime::Store store(passing.path());
  const runtime::SweepPlan plan = plan_sweep(file, archive.overrides, registry, store.file_hashes());
  warn_of_kinds_offered_twice(graphs_of(plan), registry);
  const std::vector<size_t> chosen = spread_over(plan, archive, static_cast<size_t>(options.cells));
  const std::vector<std::string> gone = without_cell(plan, archive);
  for (const std::string& label : gone)
    std::printf("differs: %s: it is archived, and no cell that this program makes of the bench\n", label.c_str());
  const std::vector<std::string> changed = changed_inputs(archive, plan, store.file_hashes());
  for (const std::string& input : changed) std::printf("differs: the input %s\n", input.c_str());
  if (chosen.empty()) throw std::runtime_error(folder + " has no result of a cell that this program would run");
  if (archive.commit != build_commit())
    std::printf("archived by commit %s, made again by %s\n", archive.commit.c_str(), build_commit().c_str());
  runtime::SweepRunOptions run;
  run.workers = options.workers;
  run.limit = options.limit;
  const auto progress = run_cells(plan, chosen, registry, store, run, [](const runtime::SweepProgress&) {});
  if (progress.cancelled) return 130;
  const runtime::CellRecords records(store);
  size_t different = 0;
  for (const size_t index : chosen) {
    const runtime::SweepCell& cell = plan.cells[index];
    const auto record = records.find(cell.key);
    const std::string difference = record
                                       ? runtime::difference_of(archive.results.at(cell.label()),
                                                                runtime::CellRecords::result_text(*record), tolerance)
                                       : "it gave no result";
    if (difference.empty()) continue;
    ++different;
    std::printf("differs: %s: %s\n", cell.label().c_str(), difference.c_str());
  }
  std::printf("%s: %zu of %zu archived cells made again, %zu agree to %g, %zu differ\n", folder.c_str(), chosen.size(),
              archive.results.size(), chosen.size() - different, tolerance, different);
  if (archive.planned > archive.results.size())
    std::printf("the bench has %zu cells: %zu had not run when it was archived\n", archive.planned,
                archive.planned - archive.results.size());
  const bool as_planned = archive.planned == 0 || archive.planned == plan.cells.size();
  if (!as_planned)
    std::printf("differs: the bench had %zu cells when it was archived, what the archive says makes %zu\n",
                archive.planned, plan.cells.size());
  return different == 0 && gone.empty() && changed.empty() && as_planned ? 0 : 1;
}

}  // namespace plumbline::cli

#include "bench.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "bench_summary.hpp"
#include "bench_verify.hpp"
#include "build_info.hpp"
#include "runtime/base/near_names.hpp"
#include "runtime/base/printable.hpp"
#include "runtime/record/deliver.hpp"
#include "runtime/record/record.hpp"
#include "runtime/sweep/sweep_archive.hpp"
#include "runtime/sweep/sweep_dispatch.hpp"
#include "runtime/sweep/sweep_places.hpp"
#include "runtime/sweep/sweep_run.hpp"
#include "runtime/sweep/sweep_table.hpp"
#include "terminal.hpp"

namespace plumbline::cli {

namespace fs = std::filesystem;
using runtime::SweepPlan;
using runtime::SweepProgress;

namespace {

std::atomic<bool> cancel = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler sets it");

extern "C" void stop_bench(int signal) {
  cancel = true;
  std::signal(signal, SIG_DFL);
}

std::string counts_text(const SweepProgress& p) {
  std::string text = std::to_string(p.done) + " of " + std::to_string(p.cells) + " cells";
  if (p.found > 0) text += ", " + std::to_string(p.found) + " of them from before";
  if (p.failed > 0) text += ", " + std::to_string(p.failed) + " failed";
  return text;
}

/// One line that replaces itself on a terminal, a line every half minute elsewhere.
class Ticker {
 public:
  explicit Ticker(bool silent) : silent_(silent), terminal_(can_rewrite_lines()) {}
  Ticker(const Ticker&) = delete;
  Ticker& operator=(const Ticker&) = delete;
  ~Ticker() {
    if (shown_ && terminal_) std::fprintf(stderr, "\r\033[K");
  }
  void operator()(const SweepProgress& progress) {
    const auto now = std::chrono::steady_clock::now();
    if (silent_ || now - last_ < (terminal_ ? std::chrono::milliseconds(200) : std::chrono::seconds(30))) return;
    last_ = now;
    std::string text = counts_text(progress);
    const double seconds = std::chrono::duration<double>(now - start_).count();
    const size_t ran = progress.done - progress.found;
    if (ran > 0) {
      text += fmt::format(", about {:.0f} s left",
                          seconds / static_cast<double>(ran) * static_cast<double>(progress.cells - progress.done));
    }
    std::fprintf(stderr, terminal_ ? "\r\033[K%s" : "%s\n", text.c_str());
    shown_ = true;
  }

 private:
  bool silent_, terminal_, shown_ = false;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), last_ = start_;
};

/// The cells of the first `seeds` of the file's seeds.
std::vector<size_t> cells_of_first(const SweepPlan& plan, size_t seeds) {
  const auto& all = plan.file.seeds;
  const std::set<uint64_t> wanted(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(std::min(seeds, all.size())));
  std::vector<size_t> indices;
  for (size_t i = 0; i < plan.cells.size(); ++i)
    if (wanted.count(plan.cells[i].seed)) indices.push_back(i);
  return indices;
}

/// Counts from the records alone.
SweepProgress progress_in_store(const SweepPlan& plan, const runtime::CellRecords& records) {
  SweepProgress progress;
  progress.cells = plan.cells.size();
  for (const auto& cell : plan.cells)
    if (const auto record = records.find(cell.key))
      ++progress.done, progress.failed += !failure_of(cell, *record, plan.file).empty();
  return progress;
}

struct AlternativeCount {
  size_t cells = 0, done = 0, failed = 0;
  size_t impossible = 0;  ///< of which no pipeline could be made
  std::string reason;     ///< of its first failed cell
};
using AlternativeCounts = std::map<std::pair<std::string, std::string>, AlternativeCount>;  // by group and name
constexpr const char* kScenario = "scenario";                                               // in the place of a group

AlternativeCounts count_alternatives(const SweepPlan& plan, const runtime::CellRecords& records) {
  AlternativeCounts counts;
  for (const auto& cell : plan.cells) {
    const auto record = records.find(cell.key);
    std::map<std::string, std::string> choices = cell.choices;
    if (!cell.scenario.empty()) choices.emplace(kScenario, cell.scenario);
    for (const auto& choice : choices) {
      AlternativeCount& count = counts[choice];
      ++count.cells;
      count.impossible += !cell.graph;
      if (!record) continue;
      ++count.done;
      const std::string failure = failure_of(cell, *record, plan.file);
      if (failure.empty()) continue;
      ++count.failed;
      if (count.reason.empty()) count.reason = failure;
    }
  }
  return counts;
}

/// Failed cells are results, of which the tables tell. An alternative that failed in all of its own was not measured:
/// "method=mine". A scenario may be made to fail, so of that only one that could not run at all counts. Without
/// alternatives: all cells of the bench.
std::string without_any_result(const SweepPlan& plan, const runtime::CellRecords& records,
                               const SweepProgress& progress) {
  std::string names;
  for (const auto& [alternative, count] : count_alternatives(plan, records))
    if (count.cells > 0 && count.failed == count.cells &&
        (alternative.first != kScenario || count.impossible == count.cells))
      names += (names.empty() ? "" : ", ") + alternative.first + "=" + alternative.second;
  if (names.empty() && progress.failed > 0 && progress.failed == progress.cells) names = "the bench";
  return names;
}

/// Scenarios that ran and gave nothing, which may be what they are for: told, no error.
void tell_of_failed_scenarios(const SweepPlan& plan, const runtime::CellRecords& records) {
  for (const auto& [alternative, count] : count_alternatives(plan, records))
    if (alternative.first == kScenario && count.failed == count.cells && count.impossible < count.cells)
      std::fprintf(
          stderr,
          "scenario=%s gave no result: all its %zu cells failed, the first: %s; bench.md has the reasons (this "
          "alone leaves the exit code 0: a scenario may be made to fail)\n",
          alternative.second.c_str(), count.cells, count.reason.c_str());
}

/// Every alternative that the file names, also one that ran nothing.
void print_alternatives(const SweepPlan& plan, const runtime::CellRecords& records) {
  AlternativeCounts counts = count_alternatives(plan, records);
  for (const auto& group : plan.file.groups)
    for (const auto& alternative : group.alternatives) {
      const AlternativeCount& count = counts[{group.name, alternative.name}];
      const std::string text =
          fmt::format("  {}={}: {} of {} cells, {} failed{}", group.name, alternative.name, count.done, count.cells,
                      count.failed, count.cells == 0 ? " (all its cells are excluded)" : "");
      const std::string reason = count.reason.empty() || count.cells == 0 ? "" : "; the first: " + count.reason;
      std::printf("%s\n", hanging_lines(text + reason, terminal_columns()).c_str());
    }
}

/// What to choose of each group, in the words of the pages: a bench ends with its result, as a pipeline does.
void print_choices(const fs::path& out) {
  std::ifstream stream(out / "bench.json");
  const auto bench = nlohmann::json::parse(stream, nullptr, false);
  if (!bench.is_object() || !bench.contains("choices") || !bench["choices"].is_array()) return;
  for (const auto& choice : bench["choices"])
    if (choice.is_string())
      std::printf("%s\n", hanging_lines(runtime::printable(choice.get<std::string>()), terminal_columns()).c_str());
}

void print_end(const BenchOptions& options, const SweepPlan& plan, const SweepProgress& progress,
               const runtime::CellRecords& records, const fs::path& out) {
  if (options.json) {
    nlohmann::ordered_json json{{"plan", plan.id},
                                {"cells", progress.cells},
                                {"found", progress.found},
                                {"done", progress.done},
                                {"failed", progress.failed},
                                {"node_runs", progress.nodes},
                                {"merged", progress.merged_nodes},
                                {"executed", progress.executed},
                                {"out", out.string()}};
    std::printf("%s\n", json.dump().c_str());
    return;
  }
  if (options.quiet) return;
  std::printf("%s: %s\n", plan.file.path.c_str(), counts_text(progress).c_str());
  if (progress.nodes > 0)
    std::printf("  %zu node runs one by one, %zu after merging, %zu of them executed\n", progress.nodes,
                progress.merged_nodes, progress.executed);
  print_alternatives(plan, records);
  if (!options.archive.empty()) std::printf("  %s\n", options.archive.c_str());
  if (out.empty()) return;
  for (const char* name : {"bench.html", "bench.csv", "bench.json", "bench.md", "bench.tex", "bench.svg", "bench.pdf"})
    if (fs::exists(out / name)) std::printf("  %s\n", (out / name).c_str());
  print_choices(out);
}

/// What had not run is not in it, which whoever gets the archive could not see of the cells alone.
void archive(const BenchOptions& options, const SweepPlan& plan, const runtime::CellRecords& records,
             const runtime::Registry& registry, runtime::Store& store) {
  write_archive(options.archive, plan, options.overrides, records, registry, store.file_hashes(), build_facts());
  const auto missing =
      std::count_if(plan.cells.begin(), plan.cells.end(), [&](const auto& cell) { return !records.find(cell.key); });
  if (missing > 0)
    std::fprintf(stderr, "warning: %s lacks %td of %zu cells, which have not run\n", options.archive.c_str(), missing,
                 plan.cells.size());
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');)
    if (!part.empty()) parts.push_back(part);
  return parts;
}

int send(const BenchOptions& options, const SweepPlan& plan, runtime::Store& store) {
  runtime::DispatchOptions dispatch;
  dispatch.executor = options.executor;
  dispatch.cells_per_task = static_cast<size_t>(options.cells_per_task);
  dispatch.hosts = split(options.hosts);
  dispatch.scheduler_options = options.scheduler_options;
  dispatch.retry = options.retry;
  dispatch.command = {fs::read_symlink("/proc/self/exe").string(), "bench", fs::absolute(options.file).string()};
  dispatch.command.insert(dispatch.command.end(), options.overrides.begin(), options.overrides.end());
  for (const std::string& seeds : options.seeds) dispatch.command.insert(dispatch.command.end(), {"--seeds", seeds});
  for (const std::string& name : options.scenarios)
    dispatch.command.insert(dispatch.command.end(), {"--scenario", name});
  dispatch.command.insert(dispatch.command.end(), {"--store", store.folder().string(), "--plan", plan.id, "--workers",
                                                   std::to_string(std::max(1, options.workers)), "--cells-per-task",
                                                   std::to_string(options.cells_per_task)});
  if (options.limit > 0) dispatch.command.insert(dispatch.command.end(), {"--limit", std::to_string(options.limit)});
  if (options.retry) dispatch.command.emplace_back("--retry");
  const runtime::Dispatched sent = runtime::dispatch(plan, store, dispatch);
  std::printf("%s", sent.text.c_str());
  return sent.exit_code == 0 ? 0 : 1;
}

std::vector<size_t> cells_of_task(const BenchOptions& options, const SweepPlan& plan) {
  if (!options.plan.empty() && options.plan != plan.id)
    throw std::runtime_error("this task was sent for plan " + options.plan + ", but here the file makes plan " +
                             plan.id + ": the bench file, a pipeline or a plugin differs from the one that submitted");
  const auto chunks = runtime::chunks_of(plan, runtime::task_size(plan, static_cast<size_t>(options.cells_per_task)));
  if (static_cast<size_t>(options.task) >= chunks.size())
    throw std::runtime_error("there is no task " + std::to_string(options.task) + "; the plan has " +
                             std::to_string(chunks.size()));
  return chunks[options.task];
}

/// "--seeds 1 floors=2": a list takes what follows it, and what has a '=' is an override.
void part_seeds_from_overrides(BenchOptions& options) {
  const auto first = std::stable_partition(options.seeds.begin(), options.seeds.end(),
                                           [](const std::string& word) { return word.find('=') == std::string::npos; });
  options.overrides.insert(options.overrides.end(), first, options.seeds.end());
  options.seeds.erase(first, options.seeds.end());
}

/// The same, of names that somebody typed.
void keep_scenarios(runtime::SweepFile& file, const std::vector<std::string>& wanted) {
  std::vector<std::string> known;
  for (const auto& scenario : file.scenarios)
    if (!scenario.name.empty()) known.push_back(scenario.name);
  for (const std::string& name : wanted) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    std::string names;
    for (const std::string& one : known) names += (names.empty() ? "'" : ", '") + one + "'";
    throw UsageError("--scenario: " + file.path.string() + " has no scenario '" + name + "'" +
                     runtime::did_you_mean(name, known) +
                     (known.empty() ? "; it has none at all" : "; it has " + names));
  }
  keep_only(file, wanted);
}

/// The file with the seeds and scenarios of the command line.
runtime::SweepFile asked_of(const BenchOptions& options, const runtime::Registry& registry) {
  runtime::SweepFile file = read_sweep(options.file, registry, pipeline_folders());
  if (!options.seeds.empty()) {
    const auto seeds = runtime::seeds_of(options.seeds);
    if (!seeds) throw UsageError("--seeds takes whole numbers and ranges, such as 1-20");
    if (!file.looks.empty())
      std::fprintf(stderr,
                   "warning: --seeds takes away the 'stop:' of %s, which is of its own seeds: all of these run, and "
                   "intervals are 95 %% as of one look; do not stop by what they show\n",
                   options.file.c_str());
    file.looks.clear();
    file.seeds = *seeds;
  }
  if (!options.scenarios.empty()) keep_scenarios(file, options.scenarios);
  return file;
}

void require_archive_can_be(const BenchOptions& options, const runtime::SweepFile& file) {
  if (options.archive.empty()) return;
  if (options.executor != "local" && !options.status)
    throw UsageError("--archive takes results that are there: give it with --status once the tasks have ended");
  runtime::require_place_for_archive(options.archive, file);
}

/// Runs the cells, or those of one task. `stopped` says that it ended before all seeds, because everything was decided.
SweepProgress run_what_is_asked(const BenchOptions& options, const SweepPlan& plan, const runtime::Registry& registry,
                                runtime::Store& store, SummaryWriter* writer, bool& stopped) {
  runtime::SweepRunOptions run;
  run.workers = options.workers;
  run.memory = options.memory.empty() ? 0 : parse_size(options.memory);
  run.limit = options.limit;
  run.retry = options.retry;
  run.cancel = &cancel;
  std::signal(SIGINT, stop_bench);
  std::signal(SIGTERM, stop_bench);
  Ticker ticker(options.quiet || options.json);
  SweepProgress progress;
  // Looks before the last: where everything is decided, the other seeds are not run.
  for (size_t k = 0; options.task < 0 && writer && k + 1 < plan.file.looks.size() && !stopped; ++k) {
    const std::vector<size_t> first = cells_of_first(plan, plan.file.looks[k]);
    progress = run_cells(plan, first, registry, store, run, std::ref(ticker));
    stopped = !progress.cancelled && !cancel && writer->write(plan.file.looks[k]) && writer->all_decided();
    if (stopped && !options.quiet && !options.json)
      std::printf("stopped after %zu of %zu seeds: everything is decided\n", plan.file.looks[k],
                  plan.file.seeds.size());
  }
  if (!stopped && !cancel)
    progress = run_cells(plan, options.task < 0 ? all_cells(plan) : cells_of_task(options, plan), registry, store, run,
                         std::ref(ticker));
  return progress;
}

}  // namespace

int bench(const BenchOptions& given) {
  BenchOptions options = given;
  part_seeds_from_overrides(options);
  if (options.file == "verify" && !fs::exists(options.file)) return verify_bench(options);
  options.file = find_bench(given.file);
  const runtime::Registry registry = discover();
  Options for_store;
  for_store.store = options.store;
  runtime::Store store = open_store(for_store);
  const runtime::SweepFile file = asked_of(options, registry);
  refuse_unknown_kinds(file, registry);
  const SweepPlan plan = plan_sweep(file, options.overrides, registry, store.file_hashes());
  warn_of_kinds_offered_twice(graphs_of(plan), registry);
  if (plan.cells.empty()) throw UsageError(options.file + ": everything is excluded, there is nothing to run");
  require_archive_can_be(options, plan.file);
  if (options.executor != "local" && !options.status && options.task < 0) return send(options, plan, store);

  const runtime::CellRecords records(store);
  fs::path out;
  std::unique_ptr<SummaryWriter> writer;
  if (options.task < 0 && !(options.status && options.out.empty())) {
    out = options.out.empty() ? fs::path("out") / fs::path(options.file).stem() : fs::path(options.out);
    writer = std::make_unique<SummaryWriter>(out, plan, registry, store, options);
  }
  bool stopped = false;
  SweepProgress progress = options.status ? progress_in_store(plan, records)
                                          : run_what_is_asked(options, plan, registry, store, writer.get(), stopped);
  // What this file measures may be missing in cells that ran well.
  if (options.task < 0) progress.failed = progress_in_store(plan, records).failed;
  const bool written = stopped || !writer || writer->write();
  if (!options.archive.empty() && options.task < 0) archive(options, plan, records, registry, store);
  print_end(options, plan, progress, records, out);
  for (const std::string& warning : writer ? writer->warnings() : std::vector<std::string>())
    std::fprintf(stderr, "warning: %s\n", warning.c_str());
  if (progress.cancelled || cancel) {
    std::fprintf(stderr, "cancelled; what was finished is kept and the next run goes on from there\n");
    return 130;
  }
  const bool complete = written && progress.done == progress.cells;
  // A task has done its work when every cell has a result; a failed one is a result, and not worth a second try.
  if (options.task >= 0) return complete ? 0 : 1;
  const std::string nothing = without_any_result(plan, records, progress);
  if (!nothing.empty())
    std::fprintf(stderr, "%s gave no result: all cells failed; bench.md has the reasons\n", nothing.c_str());
  if (progress.failed < progress.cells) tell_of_failed_scenarios(plan, records);
  return complete && nothing.empty() ? 0 : 1;
}

}  // namespace plumbline::cli

// plumbline run
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <thread>

#include "commands.hpp"
#include "progress.hpp"
#include "result_screen.hpp"
#include "runtime/base/memory_budget.hpp"
#include "runtime/base/printable.hpp"
#include "runtime/record/deliver.hpp"
#include "runtime/record/journal_guard.hpp"
#include "runtime/run/executor.hpp"
#include "stopping.hpp"
#include "terminal.hpp"
#include "took_part.hpp"

namespace plumbline::cli {

namespace fs = std::filesystem;
using runtime::NodeStatus;

namespace {

void print_summary(const runtime::Graph& graph, const runtime::RunResult& result,
                   const std::vector<runtime::Delivery>& deliveries, const fs::path& out) {
  std::string counts;
  for (const NodeStatus status :
       {NodeStatus::executed, NodeStatus::reused, NodeStatus::failed, NodeStatus::skipped, NodeStatus::cancelled}) {
    const size_t count = result.count(status);
    if (count == 0 && (status == NodeStatus::skipped || status == NodeStatus::cancelled)) continue;
    counts += (counts.empty() ? "" : ", ") + std::to_string(count) + " " + to_text(status);
  }
  const size_t rounds = result.rounds.rounds;
  const std::string in_rounds = rounds > 0 ? std::to_string(rounds) + (rounds > 1 ? " rounds, " : " round, ") : "";
  std::printf("%s\n", hanging_lines(graph.file + ": " + in_rounds + counts, terminal_columns()).c_str());
  for (const auto& delivery : deliveries)
    if (delivery.problem.empty()) std::printf("  %s\n", (out / delivery.file).c_str());
  std::printf("  %s\n", (out / "run.jsonl").c_str());
}

/// An output named verdict.txt or summary.txt is what a pipeline says to the person in front of it: it is shown too.
/// `kept` rows of the screen are for what follows; `read` is said where it does not say what took part.
void print_verdict(const std::vector<runtime::Delivery>& deliveries, const fs::path& out, size_t kept,
                   const std::string& read) {
  for (const auto& delivery : deliveries) {
    if ((delivery.file != "verdict.txt" && delivery.file != "summary.txt") || !delivery.problem.empty()) continue;
    std::ifstream stream(out / delivery.file);
    std::vector<std::string> lines;
    for (std::string line; std::getline(stream, line);) lines.push_back(runtime::printable(line));
    if (!read.empty() && std::ranges::none_of(lines, says_what_took_part)) lines.push_back(read);
    for (const std::string& line :
         in_a_screen(lines, terminal_columns(), terminal_rows() > kept ? terminal_rows() - kept : terminal_rows(),
                     (out / delivery.file).string()))
      std::printf("%s\n", paint_verdict(line).c_str());
  }
}

/// `record` has all of them.
std::string metrics_text(const runtime::NodeResult& node, const fs::path& record) {
  constexpr size_t most = 8;
  std::string text;
  size_t shown = 0;
  for (const auto& metric : node.metrics) {
    if (metric.name == "invalid" && !(metric.value > 0)) continue;
    if (shown++ == most) return text + ", more in " + record.string();
    // Lengths below a decimetre are of the kind that people read in millimetres; counts are shown whole.
    const bool small = metric.unit == "m" && std::abs(metric.value) < 0.1;
    const double value = small ? 1e3 * metric.value : metric.value;
    text += (text.empty() ? "" : ", ") + metric.name + " " +
            (value == std::round(value) && std::abs(value) < 1e9 ? fmt::format("{:.0f}", value)
                                                                 : fmt::format("{:.4g}", value)) +
            (metric.unit == "1" ? ""
             : small            ? " mm"
                                : " " + metric.unit);
  }
  return text;
}

/// A pipeline without such an output ends with what its nodes say of themselves, in at most a screen, and with `read`,
/// unless a node says what took part.
void print_result(const runtime::Graph& graph, const runtime::RunResult& result,
                  const std::vector<runtime::Delivery>& deliveries, const fs::path& record, const std::string& read) {
  constexpr size_t most_lines = 16;
  for (const auto& delivery : deliveries)
    if (delivery.file == "verdict.txt" || delivery.file == "summary.txt") return;
  // What is handed over, and what nothing else takes: the ends of a pipeline.
  std::vector<bool> ends(graph.nodes.size(), true);
  for (const auto& node : graph.nodes)
    for (const auto& [port, source] : node.inputs) ends[source.node] = false;
  for (const auto& output : graph.outputs) ends[output.from.node] = true;
  bool said = read.empty();
  std::vector<std::vector<std::string>> rows;
  const auto tell = [&](size_t i, const runtime::NodeResult& node) {
    if (!is_good(node) || graph.nodes[i].maps) return;
    for (const std::string& message : node.messages) {
      rows.push_back({"  " + runtime::label_of(graph.nodes[i].name, node.round), message});
      said = said || says_what_took_part(message);
    }
  };
  // What was done to the result in a round before the last stands nowhere else, such as whom a search left out.
  for (const auto& earlier : result.earlier) tell(earlier.node, earlier.result);
  for (size_t i = 0; i < graph.nodes.size(); ++i) {
    const runtime::NodeResult& node = result.nodes[i];
    if (!is_good(node)) continue;
    if (const std::string text = metrics_text(node, record); ends[i] && !text.empty())
      rows.push_back({"  " + runtime::label_of(graph.nodes[i].name, node.round), text});
    tell(i, node);
  }
  if (rows.size() > most_lines) {
    const size_t more = rows.size() - most_lines;
    rows.resize(most_lines);
    rows.push_back({"", std::to_string(more) + " more in " + record.string()});
  }
  if (!rows.empty()) std::printf("Result\n%s", columns(rows).c_str());
  if (!said) std::printf("%s\n", lines(read).c_str());
}

/// What was done, what came out of it, and what took part.
void print_whole(const runtime::Graph& graph, const runtime::RunResult& result,
                 const std::vector<runtime::Delivery>& deliveries, const Options& options, const fs::path& out,
                 size_t kept) {
  const bool german = std::ranges::find(options.overrides, "language=de") != options.overrides.end();
  const std::string read = result.ok() ? what_was_read(graph, result, german) : "";
  print_summary(graph, result, deliveries, out);
  print_verdict(deliveries, out, kept, read);
  print_result(graph, result, deliveries, out / "run.jsonl", read);
}

/// The nodes that have a result which must not be used: they say so with the metric `invalid`.
std::string invalid_nodes(const runtime::Graph& graph, const runtime::RunResult& result) {
  std::string names;
  for (size_t i = 0; i < result.nodes.size(); ++i)
    for (const auto& metric : result.nodes[i].metrics)
      if (metric.name == "invalid" && metric.value > 0)
        names += (names.empty() ? "'" : ", '") + graph.nodes[i].name + "'";
  return names;
}

void print_last(const std::string& head, const std::string& rest) {
  const std::string text = lines(head + rest);
  std::fprintf(stderr, "%s%s\n", paint_error(Colour::red, head).c_str(), text.substr(head.size()).c_str());
}

/// The last lines of a run that is done and must not be used as it is, or whose rounds came to their end too early.
void print_invalid(const std::string& nodes, const std::string& unfinished) {
  if (!unfinished.empty()) print_last("NOT FINISHED", " (exit code 3): " + unfinished);
  if (!nodes.empty()) print_last("NOT TO BE USED", " as it is (exit code 3): see the warnings of " + nodes);
}

/// The last lines of a run that failed: what failed, why, what follows from it in one line, and what to do.
void print_failure(const runtime::Graph& graph, const runtime::RunResult& result,
                   const std::vector<runtime::Delivery>& deliveries) {
  size_t failed = 0, skipped = 0;
  std::string missing;
  for (size_t i = 0; i < deliveries.size(); ++i) {
    if (deliveries[i].problem.empty()) continue;
    const NodeStatus source = result.nodes[graph.outputs[i].from.node].status;
    const bool stays = deliveries[i].problem.find(';') != std::string::npos;  // somebody's file at its place
    if (source == NodeStatus::executed || source == NodeStatus::reused || stays)
      tell(graph.file + ": output '" + deliveries[i].file +
           "' is not written: " + runtime::printable(deliveries[i].problem));
    else
      missing += (missing.empty() ? "" : ", ") + deliveries[i].file;
  }
  for (size_t i = 0; i < result.nodes.size(); ++i) {
    skipped += result.nodes[i].status == NodeStatus::skipped;
    if (result.nodes[i].status != NodeStatus::failed) continue;
    if (failed++ == 0) std::fprintf(stderr, "\n%s\n", paint_error(Colour::red, "FAILED").c_str());
    tell(runtime::printable(result.nodes[i].error));
  }
  if (failed == 0) return;
  std::string follows;
  if (skipped > 0)
    follows = std::to_string(skipped) + (skipped == 1 ? " node that needs" : " nodes that need") + " it did not run";
  if (!missing.empty()) follows += (follows.empty() ? "not written: " : "; not written: ") + missing;
  if (!follows.empty()) tell(follows + ".");
  std::fprintf(stderr, "Mend it and give the same command again: what was done is kept.\n");
}

void print_json_end(const fs::path& out) {
  std::ifstream stream(out / "run.jsonl");
  std::string line, last;
  while (std::getline(stream, line)) last = line;
  std::fprintf(json_output(), "%s\n", last.c_str());
  std::fflush(json_output());
}

std::string in_words(const runtime::OutputOrigin& run) {
  std::string words;
  for (const std::string& text : run.arguments) words += " " + text;
  return words.empty() ? "without overrides" : words.substr(1);
}

/// Variants of a pipeline share its folder below out/: what another one left there is replaced, and that is said.
void tell_of_other_variant(const Options& options, const runtime::Graph& graph, const runtime::OutputFolder& folder) {
  if (!options.out.empty() || options.json || options.quiet) return;
  for (const auto& output : graph.outputs) {
    const auto found = folder.owned().origins.find(output.file);
    if (found == folder.owned().origins.end() || found->second.arguments == options.overrides) continue;
    std::printf(
        "note: the results of another variant (%s) in %s are replaced; give it a folder of its own with --out\n",
        in_words(found->second).c_str(), folder.path().c_str());
    return;
  }
}

/// After a run that was stopped: the record is this run's, and what lies beside it need not be.
void tell_whose_outputs_lie_there(const runtime::Graph& graph, const runtime::OutputFolder& folder) {
  std::map<std::string, std::string> outputs;  // by the run that they are of
  for (const auto& output : graph.outputs) {
    const auto found = folder.owned().origins.find(output.file);
    if (folder.is_of_this_run(output.file) || !fs::exists(fs::symlink_status(folder.path() / output.file))) continue;
    std::string& list = outputs[found == folder.owned().origins.end()
                                    ? "an earlier run, which the record does not tell"
                                    : "the run of " + found->second.time + " (" + in_words(found->second) + ")"];
    list += (list.empty() ? "" : ", ") + output.file;
  }
  for (const auto& [run, list] : outputs)
    std::fprintf(stderr, "%s in %s: not of this run, but of %s\n", list.c_str(), folder.path().c_str(), run.c_str());
}

/// What a run is seen to have done, for the record of one whose nodes do not let it end.
class Seen : public Progress {
 public:
  Seen(const runtime::Graph& graph, runtime::Record& record, Style style, const fs::path& folder)
      : Progress(graph, record, style, folder), graph_(graph) {
    result_.nodes.resize(graph.nodes.size());  // cancelled, until it is known better
    result_.cancelled = true;
  }

  void node_finished(const runtime::GraphNode& node, const runtime::NodeResult& result) override {
    const std::scoped_lock lock(mutex_);
    Progress::node_finished(node, result);
    for (size_t i = 0; i < graph_.nodes.size(); ++i) {
      if (graph_.nodes[i].name != node.name) continue;
      if (!ended_.insert(i).second) result_.earlier.push_back({i, result_.nodes[i].round, result_.nodes[i]});
      result_.nodes[i] = {};
      result_.nodes[i].status = result.status;
      result_.nodes[i].round = result.round;
    }
  }
  void round_finished(const runtime::RoundsEnd& end) override {
    const std::scoped_lock lock(mutex_);
    Progress::round_finished(end);
    result_.rounds = end;
  }

  /// From now on no node is told to have finished: the record has its end. One that is just being told may hold it up
  /// for a moment, not longer.
  runtime::RunResult freeze() {
    const bool quiet = mutex_.try_lock_for(std::chrono::milliseconds(200));
    return quiet ? result_ : runtime::RunResult{std::vector<runtime::NodeResult>(graph_.nodes.size()), {}, {}, true};
  }

 private:
  const runtime::Graph& graph_;
  std::timed_mutex mutex_;
  std::set<size_t> ended_;
  runtime::RunResult result_;
};

/// Files of the user's that the outputs would replace: told before anything runs.
void refuse_obstacles(const std::vector<std::string>& obstacles, const runtime::OutputFolder& folder,
                      const Options& options) {
  if (obstacles.empty()) return;
  constexpr size_t most = 10;
  std::string text = "nothing was run, because outputs would replace what this program did not write:";
  for (size_t i = 0; i < std::min(obstacles.size(), most); ++i) text += "\n  " + obstacles[i];
  // No file has them, as nothing was written.
  if (obstacles.size() > most)
    text += "\n  and " + std::to_string(obstacles.size() - most) + " more in " + folder.path().string();
  text += options.overwrite ? "\nMove it away or choose another folder with --out DIR."
                            : "\nChoose another folder with --out DIR, or replace them with --overwrite.";
  throw UsageError(text);
}

}  // namespace

int run(const Options& options) {
  const fs::path file = find_pipeline(options.pipeline);
  const runtime::Registry registry = discover();
  const runtime::Graph graph = load_pipeline(file, options.overrides, registry, pipeline_folders());
  runtime::Store store = open_store(options);
  if (options.rehash) store.file_hashes().distrust_memory();
  const fs::path out = options.out.empty() ? fs::path("out") / file.stem() : fs::path(options.out);

  runtime::RunOptions run_options;
  run_options.threads =
      options.threads > 0 ? options.threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  run_options.memory = options.memory.empty() ? runtime::MemoryBudget::default_limit() : parse_size(options.memory);
  run_options.keep_memory = !options.memory.empty();
  run_options.cancel = &stop_is_asked_for();
  run_options.isolate = options.isolate;
  runtime::RunInfo info{PLUMBLINE_VERSION, options.overrides, store.folder(), run_options.threads, run_options.memory};
  warn_of_kinds_offered_twice(graph, registry);
  runtime::OutputFolder folder(out, store.file_hashes(), options.overwrite);
  refuse_obstacles(obstacles_to(graph, folder), folder, options);
  tell_of_other_variant(options, graph, folder);
  runtime::Record record(folder, graph, info);

  if (options.json) keep_output_for_json();
  runtime::RunResult result;
  {
    Seen progress(graph, record,
                  options.json    ? Progress::Style::json
                  : options.quiet ? Progress::Style::quiet
                                  : Progress::Style::lines,
                  out);
    const EndsInTime in_time([&] {
      progress.tell_failures();
      std::fprintf(stderr, "cancelled; nodes that did not stop in time were left, and what was finished is kept\n");
      tell_whose_outputs_lie_there(graph, folder);
      record.end(progress.freeze(), {});
      std::error_code ignored;
      fs::remove(out / LiveProgress::file_name, ignored);
      if (options.json) print_json_end(out);
    });
    result = execute(graph, registry, store, run_options, progress);
  }
  std::vector<runtime::Delivery> deliveries;
  std::optional<runtime::JournalGuard> guard;
  if (!result.cancelled) guard.emplace(graph, store, result, out);
  if (guard && !guard->refusal().empty()) {
    record.end(result, {});
    if (options.json) print_json_end(out);
    std::fprintf(stderr, "plumbline: %s\n", guard->refusal().c_str());
    return 1;
  }
  if (guard && !guard->warning().empty()) std::fprintf(stderr, "plumbline: %s\n", guard->warning().c_str());
  if (!result.cancelled && !stop_is_asked_for())
    deliveries = deliver(graph, store, result, folder, &stop_is_asked_for());
  // Who stopped the run at its very end gets the same answer as who did it earlier.
  result.cancelled = result.cancelled || stop_is_asked_for();
  record.end(result, deliveries);

  if (!result.rounds.problem.empty()) tell(graph.file + ": the rounds cannot go on: " + result.rounds.problem);
  std::string unfinished;
  if (graph.rounds.most > 0 && result.ok() && !result.rounds.finished)
    unfinished =
        fmt::format("after {} of at most {} rounds: {}", result.rounds.rounds, graph.rounds.most, result.rounds.text);
  bool delivered = true, lost = false;  // lost: what a node gave could not be written
  for (size_t i = 0; i < deliveries.size(); ++i) {
    const runtime::Delivery& delivery = deliveries[i];
    if (!delivery.note.empty()) tell("warning: " + delivery.note);
    delivered = delivered && delivery.problem.empty();
    lost |= !delivery.problem.empty() && is_good(result.nodes[graph.outputs[i].from.node]);
  }
  const std::string invalid = invalid_nodes(graph, result);
  if (options.json)
    print_json_end(out);
  else if (!options.quiet)
    print_whole(graph, result, deliveries, options, out, invalid.empty() && unfinished.empty() ? 0 : 2);
  std::fflush(stdout);
  print_failure(graph, result, deliveries);
  if (result.cancelled) {
    tell_whose_outputs_lie_there(graph, folder);
    std::fprintf(stderr, "cancelled; what was finished is kept and the next run goes on from there\n");
    return 130;
  }
  if (!result.ok() || !delivered) return result.not_converged() && !lost ? 4 : 1;
  print_invalid(invalid, unfinished);
  return !invalid.empty() || !unfinished.empty() ? 3 : 0;
}

}  // namespace plumbline::cli

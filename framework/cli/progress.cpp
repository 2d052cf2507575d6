#include "progress.hpp"

#include <fmt/core.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "runtime/base/printable.hpp"
#include "runtime/base/told_once.hpp"
#include "terminal.hpp"

namespace plumbline::cli {

using runtime::NodeStatus;
using Clock = std::chrono::steady_clock;

namespace {

Colour colour_of(NodeStatus status) {
  switch (status) {
    case NodeStatus::executed:
      return Colour::green;
    case NodeStatus::reused:
      return Colour::dim;
    case NodeStatus::failed:
      return Colour::red;
    default:
      return Colour::yellow;
  }
}

/// "1 min 55 s, 50 items of 3.58 s, side by side": time on the clock, then the mean time of an item where they
/// overlapped.
std::string times_and_items(const runtime::GraphNode& node, const runtime::NodeResult& result) {
  std::string note = duration_text(result.seconds);
  if (!node.maps) return note;
  note += result.items_executed < result.items
              ? ", " + std::to_string(result.items_executed) + " of " + std::to_string(result.items) + " items"
              : ", " + std::to_string(result.items) + " items";
  if (result.items_executed > 1 && result.item_seconds > 1.1 * result.seconds)
    note += " of " + duration_text(result.item_seconds / static_cast<double>(result.items_executed)) + ", side by side";
  return note;
}

/// How long a run may go on after a failure before it is told.
constexpr std::chrono::seconds patience{2};

size_t terminal_width() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 20 ? size.ws_col : 80;
}

}  // namespace

Progress::Progress(const runtime::Graph& graph, runtime::Record& record, Style style,
                   const std::filesystem::path& folder)
    : record_(record),
      live_(folder, graph.rounds.most > 0 ? 0 : graph.nodes.size()),
      style_(style),
      total_(graph.rounds.most > 0 ? 0 : graph.nodes.size()) {
  for (const auto& node : graph.nodes)
    name_width_ = std::max(name_width_, node.name.size() + std::string(node.kind.node->kind).size() + 3);
}

Progress::~Progress() { clear_status(); }

// All of it stands at the end, where people look, and is told once where that comes at once; but other branches may
// take an hour more.
void Progress::tell_failures_of_before() {
  if (Clock::now() - failed_ > patience) tell_failures();
}

void Progress::tell_failures() {
  for (const std::string& text : std::exchange(untold_, {})) {
    clear_status();
    tell(runtime::printable(text));
  }
}

void Progress::node_started(const runtime::GraphNode& node, size_t items) {
  tell_failures_of_before();
  live_.started(node.name, items);
  running_[node.name].start = Clock::now();
  show_status();
}

void Progress::node_progress(const runtime::GraphNode& node, size_t items_done, size_t items, double fraction,
                             const std::string& text) {
  tell_failures_of_before();
  live_.at(node.name, items_done, items, fraction, text);
  Running& running = running_[node.name];
  running.fraction = items > 1 ? static_cast<double>(items_done) / static_cast<double>(items) : fraction;
  running.text = items > 1 ? std::to_string(items_done) + " of " + std::to_string(items) : text;
  if (Clock::now() - shown_ > std::chrono::milliseconds(100)) show_status();
}

void Progress::node_finished(const runtime::GraphNode& node, const runtime::NodeResult& result) {
  tell_failures_of_before();
  running_.erase(node.name);
  live_.finished(node.name);
  ++done_;
  record_.node(node, result);
  clear_status();
  if (style_ == Style::json) {
    std::fprintf(json_output(), "%s\n", runtime::Record::node_line(node, result).c_str());
    std::fflush(json_output());
  }
  // What was skipped is a consequence of what failed: told in one line at the end.
  if (style_ == Style::lines && result.status != NodeStatus::skipped) {
    std::string line = paint(colour_of(result.status), to_text(result.status));
    line += std::string(10 - std::string(to_text(result.status)).size(), ' ');
    std::string name = runtime::label_of(node) + " (" + node.kind.node->kind + ")";
    std::string note;
    if (result.status == NodeStatus::executed) note = times_and_items(node, result);
    if (!note.empty()) name.resize(std::max(name.size(), name_width_) + 2, ' ');
    std::printf("%s%s%s\n", line.c_str(), name.c_str(), note.c_str());
  }
  std::fflush(stdout);
  if (style_ != Style::json)
    for (const std::string& warning : runtime::told_once(result.warnings))
      tell(node.at.text() + ": node '" + node.name + "': warning: " + runtime::printable(warning));
  if (result.status == NodeStatus::failed && style_ != Style::json) {
    untold_.push_back(result.error.substr(0, result.error.find('\n')));
    failed_ = Clock::now();
    for (const auto& [other, running] : running_)
      if (failed_ - running.start > patience) tell_failures();
  }
  show_status();
}

void Progress::round_finished(const runtime::RoundsEnd& end) {
  record_.round(end);
  clear_status();
  if (style_ == Style::lines && !end.text.empty())
    std::printf("%s\n", paint(Colour::bold, "round " + std::to_string(end.rounds) + ": " + end.text).c_str());
  std::fflush(stdout);
  show_status();
}

/// "[3/9] detect 12 of 40, 30 %, 3.8 % a second, about 18 s left"
void Progress::show_status() {
  if (style_ != Style::lines || !can_rewrite_lines() || running_.empty()) return;
  shown_ = Clock::now();
  const auto& [name, running] = *running_.begin();
  const std::string of = total_ > 0 ? "/" + std::to_string(total_) : "";  // how many rounds come nobody knows
  std::string line = "[" + std::to_string(done_) + of + "] " + name;
  if (!running.text.empty()) line += " " + runtime::printable_line(running.text);
  if (running.fraction > 0.02 && running.fraction <= 1) {
    const double elapsed = std::chrono::duration<double>(shown_ - running.start).count();
    std::string rate;
    if (elapsed >= 1)
      rate = fmt::format(", {:.0f} %, {:.2g} % a second", 100 * running.fraction, 100 * running.fraction / elapsed);
    line += rate + (", about " + rough_duration_text(elapsed * (1 / running.fraction - 1))) + " left";
  }
  if (running_.size() > 1) line += "  (+" + std::to_string(running_.size() - 1) + " more)";
  line.resize(std::min(line.size(), terminal_width() - 1));
  std::fprintf(stderr, "\r\033[K%s", line.c_str());
  std::fflush(stderr);
  status_is_shown_ = true;
}

void Progress::clear_status() {
  if (!status_is_shown_) return;
  std::fprintf(stderr, "\r\033[K");
  std::fflush(stderr);
  status_is_shown_ = false;
}

}  // namespace plumbline::cli

// What a run tells people: a line for each node as it ends and, on a terminal, a status line below with the time left.
#pragma once

#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "live_progress.hpp"
#include "runtime/record/record.hpp"
#include "runtime/run/executor.hpp"

namespace plumbline::cli {

class Progress : public runtime::Observer {
 public:
  enum class Style { lines, json, quiet };
  /// `folder` is where the run delivers to.
  Progress(const runtime::Graph& graph, runtime::Record& record, Style style, const std::filesystem::path& folder);
  ~Progress() override;

  void node_started(const runtime::GraphNode& node, size_t items) override;
  void node_progress(const runtime::GraphNode& node, size_t items_done, size_t items, double fraction,
                     const std::string& text) override;
  void node_finished(const runtime::GraphNode& node, const runtime::NodeResult& result) override;
  void round_finished(const runtime::RoundsEnd& end) override;
  /// What has failed and was not told yet; the end of a run tells all of it anyway.
  void tell_failures();

 private:
  struct Running {
    std::chrono::steady_clock::time_point start;
    double fraction = 0;
    std::string text;
  };
  void tell_failures_of_before();
  void show_status();
  void clear_status();

  runtime::Record& record_;
  LiveProgress live_;
  const Style style_;
  const size_t total_;
  size_t name_width_ = 0, done_ = 0;
  std::map<std::string, Running> running_;
  std::vector<std::string> untold_;
  std::chrono::steady_clock::time_point failed_;
  std::chrono::steady_clock::time_point shown_;
  bool status_is_shown_ = false;
};

}  // namespace plumbline::cli

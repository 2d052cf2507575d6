// What a run is at, for whoever looks from outside (`plumbline serve`): a file .plumbline-progress in the output
// folder, written anew at most twice a second and removed when the run ends. It proves nothing; a file that cannot be
// written is no error.
//
//   {"process": 4711, "done": 3, "total": 18, "running": [{"name": "tags", "start": 1790000000.1, "items_done": 4,
//   "items": 10,
//    "fraction": 0.4, "text": ""}]}
#pragma once

#include <condition_variable>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <thread>

namespace plumbline::cli {

class LiveProgress {
 public:
  /// `total` nodes; 0: how many nobody knows.
  LiveProgress(const std::filesystem::path& folder, size_t total);
  ~LiveProgress();
  LiveProgress(const LiveProgress&) = delete;
  LiveProgress& operator=(const LiveProgress&) = delete;

  void started(const std::string& node, size_t items);
  void at(const std::string& node, size_t items_done, size_t items, double fraction, const std::string& text);
  void finished(const std::string& node);

  static constexpr const char* file_name = ".plumbline-progress";

 private:
  struct Running {
    double start = 0, fraction = 0;
    size_t items_done = 0, items = 0;
    std::string text;
  };
  void write_at_times();
  std::string text() const;

  const std::filesystem::path file_;
  const size_t total_;
  size_t done_ = 0;
  std::map<std::string, Running> running_;
  bool changed_ = false, ended_ = false;
  std::mutex mutex_;
  std::condition_variable end_;
  std::thread thread_;
};

}  // namespace plumbline::cli

// The runs below a folder, as `plumbline serve` shows them: followed as they grow, and no file outside.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace plumbline::cli {

class ServedRuns {
 public:
  using Json = nlohmann::ordered_json;

  /// Throws UsageError if there is no such folder.
  explicit ServedRuns(const std::filesystem::path& folder);
  ~ServedRuns();
  ServedRuns(const ServedRuns&) = delete;
  ServedRuns& operator=(const ServedRuns&) = delete;

  /// A line for each run, the newest first.
  Json list();
  /// One run with its nodes; null if there is no run of that name in the list.
  Json run(const std::string& id);
  /// A node of a run by its name, and of one that ran in rounds "fit@2".
  static std::string name_of(const Json& node);
  /// Where the record of a run lies that the list names; empty: it has none.
  std::filesystem::path record(const std::string& id);

  struct File {
    int descriptor = -1;  ///< -1: there is none, or it must not be seen
    std::uint64_t size = 0;
  };
  /// A regular file below the folder by its path there, opened without following any link and without leaving the
  /// folder; no hidden one.
  File open(const std::string& path) const;

 private:
  struct Run {
    dev_t device = 0;
    ino_t inode = 0;
    std::uint64_t read = 0;  ///< bytes of the record that were taken
    Json start, end;
    std::map<std::string, Json> nodes;  ///< by name and round; of those that ended
    std::vector<std::string> order;
    size_t lines_not_read = 0;
  };
  void reopen() const;
  void look();
  void find(int folder, const std::string& path, int depth);
  void follow(const std::string& id);
  static void take(const std::string& line, Run& run);
  static void take_lines(const File& record, Run& run);
  Json summary(const std::string& id, const Run& run) const;
  Json progress(const std::string& id) const;
  std::string text_of(const std::string& path, size_t most) const;

  const std::filesystem::path folder_;
  int descriptor_ = -1;
  std::mutex mutex_;
  std::vector<std::string> found_;
  std::map<std::string, Run> runs_;
};

}  // namespace plumbline::cli

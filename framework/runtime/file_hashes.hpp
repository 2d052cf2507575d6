// Hashes of files outside the store, remembered so that a folder of photographs is read once and not at every run.
//
// A file is recognised by device, inode, size, time of modification and time of status change; the path plays no part,
// so a folder keeps its hashes when it is renamed. A file that was modified less than two seconds before it was read is
// not remembered: a second write within the tick of the file system's clock would go unnoticed.
#pragma once

#include <filesystem>
#include <map>
#include <mutex>
#include <string>

namespace plumbline::runtime {

class FileHashes {
 public:
  /// `log` is the file of the memory; lines are appended, several processes may do so at once.
  explicit FileHashes(std::filesystem::path log);

  /// SHA-256 of the file's content, 64 hexadecimal digits. Throws std::runtime_error if it cannot be read.
  std::string of_file(const std::filesystem::path& path);

  /// SHA-256 over the relative paths and content hashes of all files below a folder, links followed. Throws
  /// std::runtime_error if the folder or one of its files cannot be read.
  std::string of_tree(const std::filesystem::path& folder);

 private:
  std::filesystem::path log_;
  std::mutex mutex_;
  std::map<std::string, std::string> known_;  // by identity
};

}  // namespace plumbline::runtime

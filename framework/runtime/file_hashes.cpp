#include "runtime/file_hashes.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <fstream>
#include <stdexcept>
#include <vector>

#include "runtime/digest.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

constexpr int64_t settle_seconds = 2;
constexpr int deepest_folder = 64;

std::string identity_of(const struct stat& info) {
  const auto time = [](const timespec& t) { return std::to_string(t.tv_sec) + "." + std::to_string(t.tv_nsec); };
  return std::to_string(info.st_dev) + ":" + std::to_string(info.st_ino) + ":" + std::to_string(info.st_size) + ":" +
         time(info.st_mtim) + ":" + time(info.st_ctim);
}

std::string identity_of(const fs::path& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0)
    throw std::runtime_error("cannot read " + path.string() + ": " + std::strerror(errno));
  if (S_ISDIR(info.st_mode)) throw std::runtime_error(path.string() + " is a folder; a file is expected");
  return identity_of(info);
}

bool settled(const fs::path& path) {
  struct stat info {};
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return stat(path.c_str(), &info) == 0 &&
         std::max(info.st_mtim.tv_sec, info.st_ctim.tv_sec) + settle_seconds < now.tv_sec;
}

}  // namespace

FileHashes::FileHashes(fs::path log) : log_(std::move(log)) {
  std::ifstream stream(log_);
  for (std::string line; std::getline(stream, line);) {
    const size_t blank = line.find(' ');
    // A line that another process is just writing, or that a crash cut off, is passed over.
    if (blank == std::string::npos || stream.eof()) continue;
    const std::string hash = line.substr(blank + 1);
    if (hash.size() == 64) known_[line.substr(0, blank)] = hash;
  }
}

std::string FileHashes::of_file(const fs::path& path) {
  const std::string identity = identity_of(path);
  {
    const std::scoped_lock lock(mutex_);
    if (const auto found = known_.find(identity); found != known_.end()) return found->second;
  }
  const bool keep = settled(path);
  const std::string hash = sha256_of_file(path);
  if (!keep || identity_of(path) != identity) return hash;
  const std::scoped_lock lock(mutex_);
  if (!known_.emplace(identity, hash).second) return hash;
  const std::string line = identity + " " + hash + "\n";
  // One write with O_APPEND: lines of several processes do not mix. That it fails costs only time at the next run.
  const int file = open(log_.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0666);
  if (file >= 0) {
    [[maybe_unused]] const ssize_t written = write(file, line.data(), line.size());
    close(file);
  }
  return hash;
}

std::string FileHashes::of_tree(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, fs::directory_options::follow_directory_symlink, error);
  if (error) throw std::runtime_error("cannot read the folder " + folder.string() + ": " + error.message());
  for (const fs::recursive_directory_iterator end; entry != end; entry.increment(error)) {
    if (error) throw std::runtime_error("cannot read the folder " + folder.string() + ": " + error.message());
    if (entry.depth() > deepest_folder)
      throw std::runtime_error(folder.string() + " is nested deeper than " + std::to_string(deepest_folder) +
                               " folders; does a link in it lead back to itself?");
    std::error_code ignored;
    if (entry->is_regular_file(ignored)) files.push_back(entry->path());
  }
  if (error) throw std::runtime_error("cannot read the folder " + folder.string() + ": " + error.message());
  std::vector<std::string> lines;
  for (const fs::path& file : files) {
    std::string relative = file.lexically_relative(folder).generic_string();
    lines.push_back(std::move(relative.append(1, '\0').append(of_file(file)).append(1, '\n')));
  }
  std::sort(lines.begin(), lines.end());
  Sha256 hash;
  for (const std::string& line : lines) hash.add_field(line);
  return hash.hex();
}

}  // namespace plumbline::runtime

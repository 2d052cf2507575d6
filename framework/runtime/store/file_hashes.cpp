#include "runtime/store/file_hashes.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <fstream>
#include <stdexcept>
#include <vector>

#include "plumbline/folder_files.hpp"
#include "runtime/base/digest.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

constexpr int64_t settle_seconds = 2;
const std::string scheme = "sha256:";
const std::string no_identity = "-";  // of what is remembered only for its place

/// Makes it the last one. False if it was.
bool add_place(std::vector<std::string>& places, const std::string& place) {
  if (!places.empty() && places.back() == place) return false;
  places.erase(std::remove(places.begin(), places.end(), place), places.end());
  places.push_back(place);
  return true;
}

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

/// Where a lease is what a server grants: that it does not says nothing of who writes.
bool is_remote(const struct statfs& system) {
  const auto type = static_cast<uint32_t>(system.f_type);
  return type == 0x6969 || type == 0xff534d42 || type == 0xfe534d42 || type == 0x517b;  // NFS, CIFS, SMB 2, SMB
}

/// Whether some program may write to the file at this moment, also through a mapping that it made earlier. A lease for
/// reading is given only where nobody may; false where the kernel does not say.
bool is_open_for_writing(const fs::path& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return false;
  fcntl(file, F_SETSIG, SIGURG);  // should somebody open it in this moment: a signal that does nothing
  struct statfs system {};
  const bool writable =
      fcntl(file, F_SETLEASE, F_RDLCK) != 0 && errno == EAGAIN && fstatfs(file, &system) == 0 && !is_remote(system);
  close(file);
  return writable;
}

}  // namespace

FileHashes::FileHashes(fs::path log, const fs::path& passing) : log_(std::move(log)) {
  if (!passing.empty()) passing_ = fs::absolute(passing).lexically_normal().string() + "/";
  std::ifstream stream(log_);
  for (std::string line; std::getline(stream, line);) {
    const size_t blank = line.find(' ');
    // A line that another process is just writing, or that a crash cut off, is passed over.
    if (blank == std::string::npos || stream.eof()) continue;
    const std::string identity = line.substr(0, blank), hash = line.substr(blank + 1, 64);
    if (hash.size() != 64 || hash.find_first_not_of("0123456789abcdef") != std::string::npos) continue;
    if (identity != no_identity) known_[identity] = hash;
    if (line.size() > blank + 66 && line[blank + 65] == ' ') add_place(places_[hash], line.substr(blank + 66));
  }
}

void FileHashes::distrust_memory() {
  const std::scoped_lock lock(mutex_);
  known_.clear();
}

std::string FileHashes::of_file(const fs::path& path) {
  const std::string identity = identity_of(path);
  const bool written = !is_passing(path) && is_open_for_writing(path);
  if (!written) {
    const std::scoped_lock lock(mutex_);
    if (const auto found = known_.find(identity); found != known_.end()) {
      const std::string hash = found->second;
      remember(identity, hash, path);
      return hash;
    }
    if (const auto found = own_.find(identity); found != own_.end()) {
      const std::string hash = found->second;
      remember(no_identity, hash, path);
      return hash;
    }
  }
  const bool keep = !written && settled(path), own = is_passing(path);
  const std::string hash = sha256_of_file(path);
  const bool unchanged = (keep || own) && identity_of(path) == identity && (own || !is_open_for_writing(path));
  const std::scoped_lock lock(mutex_);
  if (unchanged && !keep) own_.emplace(identity, hash);
  remember(unchanged && keep ? identity : no_identity, hash, path);
  return hash;
}

bool FileHashes::is_passing(const fs::path& path) const {
  return !passing_.empty() && fs::absolute(path).lexically_normal().string().compare(0, passing_.size(), passing_) == 0;
}

/// Under the lock. Appends a line if it tells something new.
void FileHashes::remember(const std::string& identity, const std::string& hash, const fs::path& path) {
  std::string place = is_passing(path) ? "" : fs::absolute(path).lexically_normal().string();
  const bool fresh = identity != no_identity && known_.emplace(identity, hash).second;
  const bool moved = !place.empty() && add_place(places_[hash], place);
  if (!moved && !fresh) return;
  if (place.find('\n') != std::string::npos) place.clear();
  const std::string line = identity + " " + hash + (place.empty() ? "" : " " + place) + "\n";
  // One write with O_APPEND: lines of several processes do not mix. That it fails costs only time at the next run.
  const int file = open(log_.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0644);
  if (file >= 0) {
    [[maybe_unused]] const ssize_t written = write(file, line.data(), line.size());
    close(file);
  }
}

std::string FileHashes::of(const fs::path& path) { return fs::is_directory(path) ? of_tree(path) : of_file(path); }

/// " (last written: log.txt)" of a folder: what may go on while it is read.
static std::string last_written_in(const fs::path& folder) {
  std::error_code failed;
  if (!fs::is_directory(folder, failed)) return "";
  std::string newest;
  fs::file_time_type time;
  for (const std::string& file : list_files(folder).files) {
    const auto written = fs::last_write_time(folder / file, failed);
    if (!failed && (newest.empty() || written > time)) newest = file, time = written;
  }
  return newest.empty() ? "" : " (last written: " + newest + ")";
}

fs::path FileHashes::locate(const std::string& hash) {
  std::vector<std::string> places;
  {
    const std::scoped_lock lock(mutex_);
    if (const auto found = places_.find(hash); found != places_.end()) places = found->second;
  }
  std::string reasons;
  for (auto place = places.rbegin(); place != places.rend(); ++place) {
    std::error_code error;
    if (!fs::exists(*place, error)) {
      reasons += (reasons.empty() ? "" : "; ") + *place + " is not there any more";
      continue;
    }
    try {
      if (of(*place) == hash) return *place;
      reasons += (reasons.empty() ? "" : "; ") + *place + " has changed since it was read" + last_written_in(*place);
    } catch (const std::exception& unreadable) {
      reasons += (reasons.empty() ? "" : "; ") + std::string(unreadable.what());
    }
  }
  throw std::runtime_error("cannot find the content " + hash.substr(0, 12) + "…" +
                           (reasons.empty() ? "" : ": " + reasons) +
                           "; put it back, or run again; what is written while a run goes on, such as a log, belongs "
                           "elsewhere");
}

bool FileHashes::names_content(const std::string& uri) { return uri.compare(0, scheme.size(), scheme) == 0; }
std::string FileHashes::hash_in(const std::string& uri) { return uri.substr(scheme.size(), 64); }

fs::path FileHashes::resolve(const std::string& uri, fs::path* place) {
  const fs::path rest =
      fs::path(uri.substr(std::min(uri.size(), scheme.size() + 64))).relative_path().lexically_normal();
  const fs::path found = locate(hash_in(uri));
  if (place) *place = found;
  return !fs::is_directory(found) || rest.empty() || *rest.begin() == ".." ? found : found / rest;
}

FileHashes::Tree FileHashes::files_of(const fs::path& folder) {
  constexpr size_t most = 8;
  Tree tree;
  std::string unreadable;  // all of them at once, or a folder from a broken disk is mended file by file
  size_t failed = 0;
  for (const std::string& file : list_files(folder).files) {
    try {
      tree.emplace_back(file, of_file(folder / file));
    } catch (const std::runtime_error& error) {
      if (failed++ < most) unreadable += (unreadable.empty() ? "" : "\n") + std::string(error.what());
    }
  }
  if (failed > most) unreadable += "\nand " + std::to_string(failed - most) + " more files";
  if (failed > 0) throw std::runtime_error(unreadable + "; check the rights, or take away what is not needed");
  return tree;
}

std::string FileHashes::hash_of(const Tree& tree) {
  std::vector<std::string> lines;
  for (const auto& [path, hash] : tree) lines.push_back(std::string(path).append(1, '\0').append(hash).append(1, '\n'));
  std::sort(lines.begin(), lines.end());
  Sha256 hash;
  for (const std::string& line : lines) hash.add_field(line);
  return hash.hex();
}

void FileHashes::remember_places(const fs::path& folder, const Tree& tree) {
  const std::scoped_lock lock(mutex_);
  for (const auto& [path, hash] : tree) remember(no_identity, hash, folder / path);
  remember(no_identity, hash_of(tree), folder);
}

std::string FileHashes::of_tree(const fs::path& folder) {
  std::string hash = hash_of(files_of(folder));
  const std::scoped_lock lock(mutex_);
  remember(no_identity, hash, folder);
  return hash;
}

}  // namespace plumbline::runtime

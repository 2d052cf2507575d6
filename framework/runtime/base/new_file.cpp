#include "runtime/base/new_file.hpp"

#include <fcntl.h>
#include <linux/fs.h>
#include <stdio.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <vector>

namespace plumbline::runtime {

namespace fs = std::filesystem;

void fail_to_write(const std::string& what, int error) {
  throw std::runtime_error(
      what + ": " + std::strerror(error) +
      (error == ENOSPC || error == EDQUOT ? "; free some space or choose another folder with --out" : ""));
}

int rename_to_absent(const fs::path& from, const fs::path& to) {
  if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return 0;
  if (errno != EINVAL && errno != ENOSYS) return -1;
  struct stat info {};
  if (lstat(to.c_str(), &info) == 0) {
    errno = EEXIST;
    return -1;
  }
  return ::rename(from.c_str(), to.c_str());
}

void write_new_file(const fs::path& path, const void* data, size_t size) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file < 0) fail_to_write("cannot write " + path.string(), errno);
  const char* at = static_cast<const char*>(data);
  int error = 0;
  while (size > 0 && error == 0) {
    const ssize_t written = ::write(file, at, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      error = errno;
      break;
    }
    at += written;
    size -= static_cast<size_t>(written);
  }
  if (::close(file) != 0 && error == 0) error = errno;
  if (error == 0) return;
  ::unlink(path.c_str());
  fail_to_write("cannot write " + path.string(), error);
}

void copy_file_content(const fs::path& from, const fs::path& to) {
  const int source = ::open(from.c_str(), O_RDONLY | O_CLOEXEC);
  if (source < 0) fail_to_write("cannot read " + from.string(), errno);
  const int target = ::open(to.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  int error = target < 0 ? errno : 0;
  if (error == 0 && ioctl(target, FICLONE, source) != 0) {
    std::vector<char> buffer(size_t{1} << 20);
    for (;;) {
      const ssize_t got = ::read(source, buffer.data(), buffer.size());
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) error = errno;
      if (got <= 0) break;
      ssize_t at = 0;
      while (at < got && error == 0) {
        const ssize_t written = ::write(target, buffer.data() + at, static_cast<size_t>(got - at));
        if (written < 0 && errno != EINTR) error = errno;
        if (written > 0) at += written;
      }
      if (error) break;
    }
  }
  ::close(source);
  if (target >= 0 && ::close(target) != 0 && error == 0) error = errno;
  if (error == 0) return;
  if (target >= 0) ::unlink(to.c_str());
  fail_to_write("cannot copy " + from.string(), error);
}

}  // namespace plumbline::runtime

#include "loop/state/journal.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "loop/state/hash.hpp"

namespace plumbline::loop {

std::string journal_start() { return std::string(64, '0'); }

std::string journal_head(const std::vector<std::string>& lines) {
  return lines.empty() ? journal_start() : sha256_hex(lines.back());
}

std::string journal_line(const JournalEntry& entry, const std::string& previous) {
  nlohmann::ordered_json line;
  line["previous"] = previous, line["round"] = entry.round;
  line["item"] = entry.item, line["kind"] = entry.kind, line["from"] = entry.from, line["to"] = entry.to;
  line["by"] = entry.by, line["at"] = entry.at, line["why"] = entry.why, line["rests_on"] = entry.rests_on;
  return line.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

JournalFault check_journal(const std::vector<std::string>& lines) {
  std::string expected = journal_start();
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto line = nlohmann::json::parse(lines[i], nullptr, false);
    if (!line.is_object()) return {i + 1, "is no JSON object"};
    for (const char* key : {"previous", "round", "item", "kind", "from", "to", "by", "at", "why", "rests_on"})
      if (!line.contains(key)) return {i + 1, std::string("lacks '") + key + "'"};
    if (line["previous"] != expected)
      return {i + 1, i == 0 ? "does not begin a journal: lines before it are gone"
                            : "does not follow line " + std::to_string(i) +
                                  ": one of the two was changed, or lines between them are gone"};
    expected = sha256_hex(lines[i]);
  }
  return {};
}

namespace {

class LockedFile {
 public:
  explicit LockedFile(const std::filesystem::path& path)
      : path_(path), file_(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)) {
    if (file_ < 0) fail("cannot be opened");
    while (flock(file_, LOCK_EX) != 0)
      if (errno != EINTR) fail("cannot be locked");
  }
  ~LockedFile() {
    if (file_ >= 0) close(file_);
  }
  LockedFile(const LockedFile&) = delete;
  LockedFile& operator=(const LockedFile&) = delete;

  off_t size() const {
    struct stat info {};
    if (fstat(file_, &info) != 0) fail("cannot be looked at");
    return info.st_size;
  }
  std::string read(off_t from, off_t to) const {
    std::string text(static_cast<std::size_t>(to - from), '\0');
    for (std::size_t done = 0; done < text.size();) {
      const ssize_t n = pread(file_, text.data() + done, text.size() - done, from + static_cast<off_t>(done));
      if (n <= 0 && !(n < 0 && errno == EINTR)) fail("cannot be read");
      if (n > 0) done += static_cast<std::size_t>(n);
    }
    return text;
  }
  void cut(off_t size) const {
    if (ftruncate(file_, size) != 0) fail("cannot be cut");
  }
  void append(const std::string& text) const {
    off_t at = size();
    for (std::size_t done = 0; done < text.size();) {
      const ssize_t n = pwrite(file_, text.data() + done, text.size() - done, at);
      if (n < 0 && errno != EINTR) fail("cannot be written");
      if (n > 0) done += static_cast<std::size_t>(n), at += n;
    }
    if (fsync(file_) != 0) fail("cannot be synced to disk");
  }

 private:
  [[noreturn]] void fail(const char* what) const {
    throw std::runtime_error("journal " + path_.string() + " " + what + ": " + std::strerror(errno));
  }
  std::filesystem::path path_;
  int file_;
};

/// Where the last whole line begins and ends; both are the file's size for an empty one. What comes after `end` has no
/// line end.
struct LastLine {
  off_t begin = 0, end = 0;
};

LastLine last_line(const LockedFile& file) {
  constexpr off_t kBlock = 1 << 16;
  const off_t size = file.size();
  std::string tail;
  off_t from = size;
  for (;;) {
    const auto last = tail.rfind('\n');
    const auto before = last == std::string::npos || last == 0 ? std::string::npos : tail.rfind('\n', last - 1);
    if (last != std::string::npos && (before != std::string::npos || from == 0))
      return {from + static_cast<off_t>(before == std::string::npos ? 0 : before + 1), from + static_cast<off_t>(last)};
    if (from == 0) return {};
    const off_t next = from > kBlock ? from - kBlock : 0;
    tail = file.read(next, from) + tail, from = next;
  }
}

}  // namespace

void append_to_journal(const std::filesystem::path& path, const std::vector<JournalEntry>& entries) {
  const LockedFile file(path);
  const LastLine last = last_line(file);
  const off_t whole = last.end > 0 ? last.end + 1 : 0, size = file.size();
  if (size > whole) {
    std::filesystem::path torn = path;
    torn += ".torn";
    LockedFile(torn).append(file.read(whole, size) + "\n");
    file.cut(whole);
  }
  std::string previous = last.end > 0 ? sha256_hex(file.read(last.begin, last.end)) : journal_start();
  std::string text;
  for (const JournalEntry& entry : entries) {
    const std::string line = journal_line(entry, previous);
    previous = sha256_hex(line);
    text += line + "\n";
  }
  file.append(text);
}

}  // namespace plumbline::loop

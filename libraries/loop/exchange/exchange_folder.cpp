// What an exchange has on disk.
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "base/text/whole_file.hpp"
#include "loop/exchange/order_exchange.hpp"

namespace plumbline::loop {
namespace {

std::runtime_error exchange_error(const std::string& path, const char* what) {
  return std::runtime_error(path + " " + what + ": " + std::strerror(errno));
}

/// Opens for appending, under a lock, without a torn last line.
int open_lines(const std::string& path) {
  const int file = open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file < 0) throw exchange_error(path, "cannot be opened");
  if (flock(file, LOCK_EX | LOCK_NB) != 0) {
    close(file);
    throw std::runtime_error(path + " is in use: another program exchanges with this robot; one at a time");
  }
  const std::string text = text::read_whole(path);
  const auto whole = text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n') + 1;
  if (whole != text.size() && ftruncate(file, static_cast<off_t>(whole)) != 0) {
    close(file);
    throw exchange_error(path, "cannot be cut to its last whole line");
  }
  return file;
}

void append_line(int file, const std::string& line, const std::string& path) {
  const std::string text = line + "\n";
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t n = write(file, text.data() + done, text.size() - done);
    if (n < 0 && errno != EINTR) throw exchange_error(path, "cannot be written");
    if (n > 0) done += static_cast<std::size_t>(n);
  }
  if (fsync(file) != 0) throw exchange_error(path, "cannot be synced to disk");
}

std::vector<std::string> lines_of(const std::string& path) {
  std::vector<std::string> lines;
  std::ifstream stream(path, std::ios::binary);
  for (std::string line; std::getline(stream, line);)
    if (!line.empty()) lines.push_back(line);
  return lines;
}

}  // namespace

ExchangeFolder::ExchangeFolder(const std::string& folder) : folder_(folder) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed) throw std::runtime_error("folder " + folder + " cannot be made: " + failed.message());
  sent_ = open_lines(folder + "/sent.jsonl");
  try {
    states_ = open_lines(folder + "/states.jsonl");
  } catch (...) {
    close(sent_);
    throw;
  }
}

ExchangeFolder::~ExchangeFolder() { close(sent_), close(states_); }

void ExchangeFolder::append_sent(const std::string& line) { append_line(sent_, line, folder_ + "/sent.jsonl"); }
void ExchangeFolder::append_state(const std::string& line) { append_line(states_, line, folder_ + "/states.jsonl"); }
std::vector<std::string> ExchangeFolder::sent() const { return lines_of(folder_ + "/sent.jsonl"); }
std::vector<std::string> ExchangeFolder::states() const { return lines_of(folder_ + "/states.jsonl"); }

}  // namespace plumbline::loop

// What an exchange has on disk.
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "base/text/whole_file.hpp"
#include "base/text/words.hpp"
#include "loop/exchange/order_exchange.hpp"

namespace plumbline::loop {
namespace {

std::runtime_error exchange_error(const std::string& path, const char* what) {
  return std::runtime_error(path + " " + what + ": " + std::strerror(errno));
}

/// Opens for appending, under a lock, without a torn last line. `waits`: until another program has let go of it.
int open_lines(const std::string& path, bool waits = false) {
  const int file = open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file < 0) throw exchange_error(path, "cannot be opened");
  while (waits && flock(file, LOCK_EX) != 0)
    if (errno != EINTR) throw exchange_error(path, "cannot be locked");
  if (!waits && flock(file, LOCK_EX | LOCK_NB) != 0) {
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

struct FileCloser {
  int file;
  ~FileCloser() { close(file); }
};

/// "F01-C01-R1:1".
std::string item_key(const std::string& item, int revision) { return item + ":" + std::to_string(revision); }

struct Given {
  std::string robot, order;  ///< MANUFACTURER/SERIAL; the orderId it was given in, empty where the line says none
};

/// By item and revision. Throws std::runtime_error for a line that says neither: what it gives away is not known.
std::map<std::string, Given> given_by_item(const std::string& path) {
  std::map<std::string, Given> given;
  std::size_t number = 0;
  for (const std::string& text : lines_of(path)) {
    ++number;
    const auto line = nlohmann::ordered_json::parse(text, nullptr, false);
    if (!line.is_object() || !line.contains("item") || !line.contains("revision") || !line.contains("robot"))
      throw std::runtime_error(path + ":" + std::to_string(number) + " is '" + text.substr(0, 60) +
                               "', expected item, revision and robot: which robot has what is not known; mend that "
                               "line, or take it out if no robot had it");
    given.try_emplace(item_key(line["item"].get<std::string>(), line["revision"].get<int>()),
                      Given{line["robot"].get<std::string>(), line.value("order", "")});
  }
  return given;
}

/// Who holds an item that this robot would be sent in the order of `job`, in words; empty: nobody. An order of other
/// floors of the same job has another orderId: the robot would not know that it did the item, and would do it again.
std::string holder_of(const Given& given, const Job& job, const std::string& robot) {
  if (given.robot != robot) return given.robot;
  const bool of_this_job = given.order == job.id || given.order.starts_with(job.id + "-F");
  return of_this_job && given.order != vda_order_id(job) ? given.robot + " itself, in order " + given.order : "";
}

}  // namespace

std::string ExchangeFolder::held_by_others(const Job& job, const std::string& robot, bool take) {
  if (given_.empty()) return {};
  const int file = open_lines(given_, true);
  const FileCloser closer{file};
  const std::map<std::string, Given> given = given_by_item(given_);
  std::map<std::string, std::vector<std::string>> held;  // by who holds them
  std::string lines;
  for (const JobItem& item : job.items) {
    const auto found = given.find(item_key(item.id, item.revision));
    if (found != given.end())
      if (const std::string holder = holder_of(found->second, job, robot); !holder.empty())
        held[holder].push_back(item.id);
    if (found == given.end())
      lines += (lines.empty() ? "" : "\n") +
               nlohmann::ordered_json{
                   {"item", item.id}, {"revision", item.revision}, {"robot", robot}, {"order", vda_order_id(job)}}
                   .dump();
  }
  if (held.empty()) {
    if (take && !lines.empty()) append_line(file, lines, given_);
    return {};
  }
  std::string words;
  for (const auto& [other, items] : held)
    words += (words.empty() ? "" : "; ") + text::join(items, 4) + (items.size() > 1 ? " were" : " was") + " given to " +
             other;
  return words + " (" + given_ +
         "): nothing is sent. Two robots share a job by floors (--floor 1, --floor 2), and a robot goes on with the "
         "floors that it was given together; if that robot is known not to have taken them, take its lines out of that "
         "file";
}

ExchangeFolder::ExchangeFolder(const std::string& folder, const std::string& given) : folder_(folder), given_(given) {
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

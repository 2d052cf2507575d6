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
#include <set>
#include <stdexcept>

#include "base/text/whole_file.hpp"
#include "base/text/words.hpp"
#include "loop/exchange/order_exchange.hpp"
#include "loop/exchange/rounds_beside.hpp"

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

/// By whom items are held: "RC/001", or of this robot itself another order. By that, their names.
std::map<std::string, std::vector<std::string>> by_holder(const std::vector<GivenItem>& held,
                                                          const std::string& robot) {
  std::map<std::string, std::vector<std::string>> items;
  for (const GivenItem& one : held)
    items[one.robot + (one.robot == robot ? " itself, in order " + one.order : "") + " (" + one.file.string() + ")"]
        .push_back(one.item);
  return items;
}

/// Lines of the items of a job that are in no line of the file yet, with how long the journal of its round is: what was
/// reported by then answers nothing of it.
std::string lines_to_give(const std::string& given, const std::string& rounds, const Job& job,
                          const std::string& robot) {
  std::set<std::pair<std::string, int>> there;
  for (const GivenItem& one : given_lines(given)) there.emplace(one.item, one.revision);
  const std::size_t journal = rounds.empty() ? 0 : journal_lines(rounds);
  std::string lines;
  for (const JobItem& item : job.items) {
    if (there.contains({item.id, item.revision})) continue;
    nlohmann::ordered_json line{
        {"item", item.id}, {"revision", item.revision}, {"robot", robot}, {"order", vda_order_id(job)}};
    if (journal > 0) line["journal"] = journal;
    lines += (lines.empty() ? "" : "\n") + line.dump();
  }
  return lines;
}

}  // namespace

void ExchangeFolder::note_given(const Job& job, const std::string& robot) {
  if (given_.empty()) return;
  const int file = open_lines(given_, true);
  const FileCloser closer{file};
  if (const std::string lines = lines_to_give(given_, rounds_, job, robot); !lines.empty())
    append_line(file, lines, given_);
}

std::string ExchangeFolder::held_by_others(const Job& job, const std::string& robot, bool take) {
  if (given_.empty()) return {};
  const int file = open_lines(given_, true);
  const FileCloser closer{file};
  if (const std::filesystem::path later = rounds_.empty() ? "" : later_round(rounds_); !later.empty())
    return "job " + job.id + " is of " + rounds_ + ", and " + later.string() +
           " went on from that round: what it recalled is not to be done any more, so nothing is sent. What is still "
           "to "
           "be done is in " +
           (later / "job.json").string() + "; if that round is to count for nothing, take its folder away";
  const auto held = by_holder(unanswered(rounds_, given_, job, robot, vda_order_id(job)), robot);
  if (held.empty()) {
    const std::string lines = lines_to_give(given_, rounds_, job, robot);
    if (take && !lines.empty()) append_line(file, lines, given_);
    return {};
  }
  std::string words;
  for (const auto& [other, items] : held)
    words += (words.empty() ? "" : "; ") + text::join(items, 4) + (items.size() > 1 ? " were" : " was") + " given to " +
             other;
  return words +
         ", and no report of it is in this round: nothing is sent. Let that order come to its end, then run the round "
         "with what that robot said. What was recalled since is asked for again once a campaign measured it after "
         "that ('measured'); what that order did not do and will not do is reported as skipped, with its revision. Two "
         "robots share a job by floors "
         "(--floor 1, --floor 2), and a robot goes on with the floors that it was given together; if that robot is "
         "known not to have taken them, take its lines out of that file";
}

ExchangeFolder::ExchangeFolder(const std::string& folder, const std::string& given, const std::string& rounds)
    : folder_(folder), given_(given), rounds_(rounds) {
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

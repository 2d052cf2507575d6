// plumbline watch: runs a pipeline again whenever what it reads has changed. What has not changed is taken from the
// store, so that a photograph more costs one detection and what follows from it.
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <thread>
#include <utility>

#include "commands.hpp"
#include "plumbline/file_end.hpp"
#include "plumbline/folder_files.hpp"
#include "runtime/base/printable.hpp"
#include "runtime/plugins/executable_node.hpp"
#include "stopping.hpp"

extern char** environ;

namespace plumbline::cli {

namespace fs = std::filesystem;

namespace {

using Clock = std::chrono::steady_clock;

/// What is known of a file without reading it: whoever copies it changes one of these.
struct Stamp {
  long long size = -1, seconds = 0, nanoseconds = 0;
  unsigned long long node = 0;
  bool operator==(const Stamp&) const = default;
};
using Snapshot = std::map<std::string, Stamp>;

void add_file(const fs::path& path, Snapshot& snapshot) {
  struct stat info {};
  Stamp& stamp = snapshot[path.string()];  // one that is not there is told by its stamp, and comes as a change
  if (stat(path.c_str(), &info) == 0) stamp = {info.st_size, info.st_mtim.tv_sec, info.st_mtim.tv_nsec, info.st_ino};
}

/// What is no part of the program and yet of the keys of its results: one's own plugin, one's own script.
void add_own_node(const runtime::Plugin& plugin, std::set<fs::path>& paths) {
  if (plugin.executable)
    for (const fs::path& file : plugin.executable->files) paths.insert(fs::absolute(file));
  else if (!plugin.shipped)
    paths.insert(fs::absolute(plugin.identity.path));
}

/// Files and folders that the pipeline's text and parameters name, and the nodes that are somebody's own.
std::set<fs::path> read_by(const runtime::Graph& graph) {
  std::set<fs::path> paths;
  for (const auto& source : graph.sources) paths.insert(fs::absolute(source.path));
  for (const auto& node : graph.nodes) add_own_node(*node.kind.plugin, paths);
  for (const auto& node : graph.nodes)
    for (uint32_t i = 0; i < node.kind.node->param_count; ++i) {
      const plumbline_param& param = *node.kind.node->params[i];
      const auto value = node.parameters.find(param.name);
      if ((param.kind != PLUMBLINE_FILE && param.kind != PLUMBLINE_FOLDER) || value == node.parameters.end()) continue;
      std::string path;
      for (const char c : value->second + '\x1f')
        if (c != '\x1f')
          path += c;
        else if (!path.empty())
          paths.insert(fs::absolute(std::exchange(path, {})));
    }
  return paths;
}

/// What runs left in a folder is no content of it (list_files), or each run would be followed by another one.
Snapshot look_at(const std::set<fs::path>& paths) {
  Snapshot snapshot;
  for (const fs::path& path : paths) {
    std::error_code ignored;
    if (!fs::is_directory(path, ignored)) {
      add_file(path, snapshot);
      continue;
    }
    try {
      for (const std::string& file : list_files(path).files)
        if (!is_system_file(file)) add_file(path / file, snapshot);
    } catch (const std::runtime_error&) {  // a folder that goes while it is looked at; the run says what is wrong
    }
  }
  return snapshot;
}

/// False if the program is to end.
bool wait(double seconds) {
  const auto until = Clock::now() + std::chrono::duration<double>(seconds);
  while (Clock::now() < until && !stop_is_asked_for()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  return !stop_is_asked_for();
}

std::string changed_text(const Snapshot& before, const Snapshot& now) {
  std::vector<std::string> names;
  for (const auto& [path, stamp] : now)
    if (const auto found = before.find(path); found == before.end() || !(found->second == stamp)) names.push_back(path);
  for (const auto& [path, stamp] : before)
    if (!now.count(path)) names.push_back(path + " (gone)");
  std::string text = names.empty() ? "" : names.front();
  if (names.size() > 1) text += " and " + std::to_string(names.size() - 1) + " more";
  return text;
}

/// Looks until nothing has changed for a while, because a file that is being copied is there before its end is. One
/// that never comes to rest, such as a log beside the photographs, is named, or the wait would look like a hang.
bool wait_until_quiet(const std::set<fs::path>& paths, double quiet, Snapshot& now) {
  constexpr double patience = 10;  // in quiet times
  now = look_at(paths);
  auto told = Clock::now();
  for (auto since = told; Clock::now() - since < std::chrono::duration<double>(quiet);) {
    if (!wait(std::min(0.25, quiet))) return false;
    Snapshot next = look_at(paths);
    if (next == now) continue;
    since = Clock::now();
    if (since - told > std::chrono::duration<double>(patience * quiet)) {
      std::printf(
          "waiting: %s changes still, and a run begins when nothing has changed for %g s\n"
          "If nothing reads it, let it be written outside of what is watched.\n",
          runtime::printable(changed_text(now, next)).c_str(), quiet);
      std::fflush(stdout);
      told = since;
    }
    now = std::move(next);
  }
  return true;
}

std::string ending_of(const fs::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

/// Text of instruments and tables, which has no mark of its end but the last line's.
bool is_text_of_readings(const std::string& ending) {
  static const std::set<std::string> endings = {".gsi", ".sdr", ".csv", ".txt", ".dat", ".raw",
                                                ".rw5", ".idx", ".job", ".xml", ".jxl", ".gkf"};
  return endings.count(ending) > 0;
}

/// Whether a file of readings lost a tenth of its bytes and more: a copy under way may end with a line, too.
bool is_much_shorter(const fs::path& path, const Stamp& before, const Stamp& now) {
  constexpr long long kSmallest = 1024;  // [bytes]: below it is typed by hand
  return before.size > kSmallest && now.size >= 0 && now.size * 10 < before.size * 9 &&
         is_text_of_readings(ending_of(path));
}

/// Whether a file lacks the mark of its end: of JPEG and PNG (cameras write trailers of some kilobytes behind it, and
/// the compressed picture cannot hold it), of IFC, of what is zipped, and the last line end of text; or whether what a
/// TIFF, a raw photograph or a HEIC names of itself lies behind its end. Of other files nothing is known.
bool is_copied_in_part(const fs::path& path) {
  const std::string ending = ending_of(path);
  const auto is_one_of = [&](auto... endings) { return ((ending == endings) || ...); };
  constexpr std::streamoff kTail = 1 << 16;
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return false;
  const std::streamoff size = file.tellg();
  file.seekg(std::max<std::streamoff>(0, size - kTail));
  const std::string tail(std::istreambuf_iterator<char>(file), {});
  const auto has = [&](std::string_view mark) { return tail.find(mark) != std::string::npos; };
  if (is_one_of(".jpg", ".jpeg")) return !has("\xFF\xD9");
  if (ending == ".png") return !has("IEND");
  if (is_one_of(".tif", ".tiff", ".dng", ".nef", ".arw", ".cr2")) return size < 8 || lacks_part_of_tiff(path);
  if (is_one_of(".heic", ".heif", ".avif", ".cr3")) return size < 8 || lacks_part_of_boxes(path);
  if (ending == ".ifc") return !has("END-ISO-10303-21");
  if (is_one_of(".ifczip", ".xlsx", ".zip")) return !has("PK\5\6");
  if (is_text_of_readings(ending))
    return tail.find_last_of("\n\r\x1A") + 1 != tail.size() &&
           std::count(tail.begin(), tail.end(), '\n') > 2;  // no note
  return false;
}

constexpr int kPatience = 60;  // [s]: a file without an end is waited for so long, because it may have none

/// Files that have come or changed since `last` (without a last run: within the last minute) and have no end, or much
/// less than they had.
struct InPart {
  std::string path;
  bool is_shorter = false;  ///< than it was; else it has no end
};

std::vector<InPart> copied_in_part(const Snapshot& last, const Snapshot& now) {
  std::vector<InPart> files;
  const long long recent = std::time(nullptr) - kPatience;
  for (const auto& [path, stamp] : now) {
    const auto known = last.find(path);
    const bool is_new = last.empty() ? stamp.seconds >= recent : known == last.end() || !(known->second == stamp);
    const bool is_shorter = known != last.end() && is_much_shorter(path, known->second, stamp);
    if (is_new && (is_shorter || is_copied_in_part(path))) files.push_back({path, is_shorter});
  }
  return files;
}

/// Until nothing changes and files that came since `last` have their ends: a copy may pause for longer than the
/// time in which nothing may change. One that gets no end is left to the run, which says what is wrong with it.
bool wait_until_copied(const std::set<fs::path>& paths, double quiet, const Snapshot& last, Snapshot& now) {
  for (auto told = Clock::time_point::max();;) {
    if (!wait_until_quiet(paths, quiet, now)) return false;
    const std::vector<InPart> files = copied_in_part(last, now);
    if (files.empty() || (told != Clock::time_point::max() && Clock::now() - told > std::chrono::seconds(kPatience)))
      return true;
    if (told != Clock::time_point::max()) continue;
    told = Clock::now();
    const std::string others = std::to_string(files.size() - 1);
    std::printf("waiting: %s %s%s, as while a copy is under way; a run begins when %s whole, or in %d s\n",
                runtime::printable(files.front().path).c_str(),
                files.front().is_shorter ? "is much shorter than it was" : "has no end yet",
                files.size() > 1 ? (", and " + others + " more").c_str() : "", files.size() > 1 ? "they are" : "it is",
                kPatience);
    std::fflush(stdout);
  }
}

std::vector<std::string> words_of_run(const Options& options) {
  std::vector<std::string> words{"plumbline", "run", options.pipeline};
  words.insert(words.end(), options.overrides.begin(), options.overrides.end());
  const auto option = [&](const char* name, const std::string& value) {
    if (!value.empty()) words.insert(words.end(), {name, value});
  };
  option("--out", options.out), option("--store", options.store), option("--memory", options.memory);
  option("--threads", options.threads > 0 ? std::to_string(options.threads) : "");
  for (const auto& [set, name] : {std::pair{options.overwrite, "--overwrite"},
                                  {options.isolate, "--isolate"},
                                  {options.trust_others, "--trust-others"},
                                  {options.quiet, "--quiet"}})
    if (set) words.emplace_back(name);
  return words;
}

/// `plumbline run`, as a process of its own: a run that crashes is told and does not end the watch.
int run_once(const Options& options) {
  std::vector<std::string> words = words_of_run(options);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = 0;
  if (const int error = posix_spawn(&child, "/proc/self/exe", nullptr, nullptr, arguments.data(), environ))
    throw std::runtime_error(std::string("cannot start the run: ") + std::strerror(error));
  int status = 0;
  // Ctrl-C in a terminal reaches both; whoever ends this process alone means the run as well.
  for (auto asked = Clock::time_point::max(); waitpid(child, &status, WNOHANG) == 0;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    if (!stop_is_asked_for()) continue;
    if (asked == Clock::time_point::max()) asked = Clock::now();
    if (Clock::now() - asked > std::chrono::seconds(1)) kill(child, SIGTERM), asked = Clock::now();
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// What the pipeline reads now. One that cannot be read any more is said to be so, and its own files are watched on.
std::set<fs::path> paths_of(const Options& options, std::set<fs::path> before) {
  try {
    const runtime::Registry registry = discover();  // anew: a manifest may name other files than before
    // The run says which of two plugins it uses; here it would be said a second time.
    return read_by(load_pipeline(find_pipeline(options.pipeline), options.overrides, registry, pipeline_folders()));
  } catch (const std::exception& error) {
    if (before.empty()) throw;
    std::fprintf(stderr, "%s\n", runtime::printable(error.what()).c_str());
    return before;
  }
}

}  // namespace

int watch(const Options& options) {
  std::set<fs::path> paths = paths_of(options, {});
  stop_is_asked_for();  // from here on Ctrl-C ends the watch
  Snapshot last;
  for (int runs = 0;;) {
    Snapshot before;
    if (!wait_until_copied(paths, options.quiet_seconds, last, before)) return 130;
    const int code = run_once(options);
    if (stop_is_asked_for()) return 130;
    if (++runs == options.most_runs) return code;
    paths = paths_of(options, std::move(paths));
    std::printf("watching %zu files (the run ended with %d); Ctrl-C ends it\n", before.size(), code);
    std::fflush(stdout);
    last = before;
    Snapshot now = look_at(paths);  // what came while the run was at work counts
    for (; now == before; now = look_at(paths))
      if (!wait(1)) return 130;
    std::printf("changed: %s\n", runtime::printable(changed_text(before, now)).c_str());
    std::fflush(stdout);
  }
}

}  // namespace plumbline::cli

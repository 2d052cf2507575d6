// A program started for one purpose, watched through its pidfd, and ended with all that it started.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

namespace plumbline::runtime {

struct ChildStart {
  std::vector<std::string> arguments;  ///< [0]: the program's path
  std::vector<std::string> settings;   ///< NAME=VALUE on top of our environment
  int channel = -1;                    ///< a descriptor of ours that it gets as number 3; -1: it gets none
  uint64_t memory_limit = 0;           ///< bytes of data it may have (RLIMIT_DATA); 0: as many as we
  bool ends_with_this_thread = false;  ///< it is killed if the thread that started it ends first, e.g. with us
};

struct ChildProcess {
  pid_t pid = -1;
  int handle = -1;  ///< its pidfd: readable when it has ended
  int log = -1;     ///< what it prints, standard output and error
};

constexpr int child_channel = 3;

/// Starts the program in a process group of its own, its input /dev/null. Throws std::runtime_error.
ChildProcess start_child(const ChildStart& start);

struct ChildEnd {
  int status = 0;  ///< as of waitpid()
  double peak_mebibytes = 0;
};

/// Kills what is left of it, takes its last account, and closes its pidfd; the log stays open.
ChildEnd finish_child(ChildProcess& child);

void empty_log(int log);

/// Whoever prints without end must not fill the memory: of a long log only the end is kept.
void shorten_log(int log);

/// The end of what it printed, at most so many bytes of it.
std::string end_of_log(int log, size_t most);

/// "the last it printed: ...", its last line and below it what stood before, up to 600 bytes; or "it printed nothing".
std::string last_words(int log);

/// How it ended, for people: signal or exit code, peak of memory, the limit it had (bytes; 0: none), its last words.
std::string death_text(const ChildEnd& end, int log, uint64_t memory_limit);

/// A text that holds death_text() without the peak, which is another each time.
std::string without_peaks(std::string text);

/// The text for one that was killed at its limit of time.
std::string lateness_text(double seconds, int log);

std::string mebibytes_text(uint64_t bytes);  ///< "200 MiB"

}  // namespace plumbline::runtime

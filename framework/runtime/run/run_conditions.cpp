#include "runtime/run/run_conditions.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <fstream>

#include "runtime/base/orphans.hpp"
#include "runtime/base/running_nodes.hpp"

extern char** environ;

namespace plumbline::runtime {

namespace {

void add(std::string& list, const std::string& text) {
  if (!text.empty()) list += (list.empty() ? "" : ", ") + text;
}

const char* rounding_text(int mode) {
  return mode == FE_UPWARD      ? "upwards"
         : mode == FE_DOWNWARD  ? "downwards"
         : mode == FE_TONEAREST ? "to nearest"
                                : "towards zero";
}

/// What differs from the default mode. Flags of exceptions that have happened are no mode.
std::string mode_changes() {
  std::string list;
  if (const int rounding = fegetround(); rounding != FE_TONEAREST)
    add(list, std::string("rounding (") + rounding_text(rounding) + ")");
  [[maybe_unused]] fenv_t now{};
  fegetenv(&now);
#if defined(__x86_64__)
  constexpr unsigned flush = 0x8000, subnormals_are_zero = 0x40, traps = 0x1f80, precision = 0x300;
  // fegetround() asks the old unit alone, and doubles are computed by the other.
  constexpr unsigned vector_rounding = 0x6000;
  if ((now.__mxcsr & vector_rounding) >> 3 != static_cast<unsigned>(fegetround()))
    add(list, "rounding of vector registers");
  if (now.__mxcsr & flush) add(list, "subnormal results (set to zero)");
  if (now.__mxcsr & subnormals_are_zero) add(list, "subnormal operands (taken as zero)");
  if ((now.__mxcsr & traps) != traps) add(list, "traps of floating-point exceptions");
  if ((now.__control_word & precision) != precision) add(list, "the precision of long double");
#elif defined(__aarch64__)
  if (now.__fpcr & (1u << 24)) add(list, "subnormal numbers (taken as zero)");
  if (now.__fpcr & 0x9f00) add(list, "traps of floating-point exceptions");
#endif
  return list;
}

std::string octal(mode_t mode) { return fmt::format("{:04o}", static_cast<unsigned>(mode)); }

/// Read, not asked for: asking for it is setting it.
mode_t umask_of_process() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.compare(0, 6, "Umask:") == 0) return static_cast<mode_t>(std::strtoul(line.c_str() + 6, nullptr, 8));
  return 022;
}

/// Of a default action the flags say nothing: setting it anew, as std::system() does, leaves one of the kernel's there.
bool same_action(const struct sigaction& a, const struct sigaction& b) {
  const bool handled = a.sa_handler != SIG_DFL && a.sa_handler != SIG_IGN;
  return a.sa_handler == b.sa_handler && (!handled || a.sa_flags == b.sa_flags);
}

/// Ctrl-C takes its own handler away when it comes, so that the second one ends the program.
bool may_go_back_to_default(int signal) { return signal == SIGINT || signal == SIGTERM; }

}  // namespace

ThreadConditions::ThreadConditions() : locale_(uselocale(nullptr)) {
  fegetenv(&mode_);
  fesetenv(FE_DFL_ENV);
  pthread_sigmask(SIG_SETMASK, nullptr, &blocked_);
}

ThreadConditions::~ThreadConditions() {
  fesetenv(&mode_);
  pthread_sigmask(SIG_SETMASK, &blocked_, nullptr);
  uselocale(locale_);
}

std::string ThreadConditions::changes() const {
  std::string list;
  if (const std::string mode = mode_changes(); !mode.empty()) list = "the floating-point mode of its thread: " + mode;
  sigset_t blocked;
  pthread_sigmask(SIG_SETMASK, nullptr, &blocked);
  for (int signal = 1; signal < 32; ++signal)
    if (sigismember(&blocked, signal) != sigismember(&blocked_, signal)) {
      add(list, "the signals that its thread blocks");
      break;
    }
  if (uselocale(nullptr) != locale_) add(list, "the locale of its thread");
  return list;
}

ProcessConditions::ProcessConditions()
    : umask_(umask_of_process()),
      folder_(open(".", O_PATH | O_DIRECTORY | O_CLOEXEC)),
      locale_(setlocale(LC_ALL, nullptr)) {
  if (folder_ >= 0) fstat(folder_, &folder_info_);
  for (char** entry = environ; entry && *entry; ++entry) environment_.emplace_back(*entry);
  for (size_t i = 1; i < actions_.size(); ++i) sigaction(static_cast<int>(i), nullptr, &actions_[i]);
  take_in_orphans();
}

ProcessConditions::~ProcessConditions() {
  if (folder_ >= 0) close(folder_);
}

std::string ProcessConditions::restore() {
  std::string list;
  // Set to what it should be: if it is that, nobody notices.
  if (const mode_t now = umask(umask_); now != umask_)
    add(list, "the umask (" + octal(now) + " in place of " + octal(umask_) + ")");
  add(list, restore_folder());
  add(list, restore_locale());
  add(list, restore_environment());
  add(list, restore_signals());
  if (const std::string orphans = end_orphans(); !orphans.empty())
    add(list, "what runs beside it: " + orphans + ", which it had started, went on and was ended");
  return list;
}

std::string ProcessConditions::restore_folder() const {
  struct stat now {};
  if (folder_ < 0 || stat(".", &now) != 0) return "";
  if (now.st_ino == folder_info_.st_ino && now.st_dev == folder_info_.st_dev) return "";
  return std::string("the working folder") + (fchdir(folder_) == 0 ? "" : " (it could not be put back)");
}

std::string ProcessConditions::restore_locale() const {
  const std::string now = setlocale(LC_ALL, nullptr);
  if (now == locale_ && std::locale() == cpp_locale_) return "";
  std::locale::global(cpp_locale_);
  setlocale(LC_ALL, locale_.c_str());
  return "the locale" + (now == locale_ ? "" : " (" + now + " in place of " + locale_ + ")");
}

std::string ProcessConditions::restore_environment() {
  size_t number = 0;
  char** entry = environ;
  for (; entry && *entry && number < environment_.size(); ++entry, ++number)
    if (environment_[number] != *entry) break;
  if (number == environment_.size() && (!entry || !*entry)) return "";
  std::set<std::string> before(environment_.begin(), environment_.end()), now;
  for (entry = environ; entry && *entry; ++entry) now.insert(*entry);
  std::set<std::string> names;
  const auto name_of = [](const std::string& text) { return text.substr(0, text.find('=')); };
  for (const std::string& text : now)
    if (!before.count(text)) names.insert(name_of(text));
  for (const std::string& name : names) unsetenv(name.c_str());
  for (const std::string& text : before) {
    if (now.count(text)) continue;
    names.insert(name_of(text));
    setenv(name_of(text).c_str(), text.c_str() + std::min(text.size(), text.find('=') + 1), 1);
  }
  environment_.clear();
  for (entry = environ; entry && *entry; ++entry) environment_.emplace_back(*entry);
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? " (" : ", ") + name;
  return names.empty() ? "" : "the environment" + list + ")";
}

std::string ProcessConditions::restore_signals() const {
  std::string list;
  std::unique_lock<std::mutex> held;
  const bool command = commands_go_on(held);  // of another node, which puts these two back
  for (size_t i = 1; i < actions_.size(); ++i) {
    const int signal = static_cast<int>(i);
    if (command && (signal == SIGINT || signal == SIGQUIT)) continue;
    struct sigaction now {};
    if (sigaction(signal, nullptr, &now) != 0 || same_action(now, actions_[i])) continue;
    if (may_go_back_to_default(signal) && now.sa_handler == SIG_DFL) continue;
    sigaction(signal, &actions_[i], nullptr);
    list += (list.empty() ? " (" : ", ") + std::string("SIG") + sigabbrev_np(signal);
  }
  return list.empty() ? "" : "what signals do" + list + ")";
}

SharedConditions::Run SharedConditions::begin(const std::string& name) {
  const std::scoped_lock lock(mutex_);
  if (running_.empty()) locale_sets_ = times_locale_was_set();
  return running_.insert(running_.end(), {name, {}});
}

SharedConditions::Finding SharedConditions::end(Run run) {
  const std::scoped_lock lock(mutex_);
  std::string changes = conditions_.restore();
  // Whoever ran beside it may have read "0.5" as 0 or written it as "0,5" meanwhile.
  if (changes.empty() && running_.size() > 1 && times_locale_was_set() != locale_sets_)
    changes = "the locale, which was put back,";
  locale_sets_ = times_locale_was_set();
  if (!changes.empty()) {
    std::set<std::string> names;
    for (const auto& [name, finding] : running_) names.insert(name);
    for (auto& [name, finding] : running_) {
      add(finding.changes, changes);
      finding.runs.insert(names.begin(), names.end());
    }
  }
  Finding finding = std::move(run->second);
  running_.erase(run);
  return finding;
}

std::string left_changed_text(const std::string& changes) {
  return "it left changed what it must leave as it finds it: " + changes +
         ". What runs after it would be computed under that, so its result is not kept; put it back before the node "
         "ends";
}

}  // namespace plumbline::runtime

#include "runtime/store/claims.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>

namespace plumbline::runtime {

namespace {

constexpr int64_t slots = 1 << 14;
constexpr int64_t whole_store = int64_t{1} << 61;  // beyond the place of any key
constexpr int64_t processes = (int64_t{1} << 61) + 1024;

}  // namespace

/// What a holder writes of itself. Keys that share a slot overwrite each other, so it only informs.
struct Claims::Slot {
  char key[32];  // the first digits
  char host[47];
  char done;
  int64_t process;
  bool is_of(const std::string& k) const { return k.compare(0, sizeof key, key, sizeof key) == 0; }
};

Claims::Claims(const std::filesystem::path& file) : file_(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)) {
  char name[65] = "host";
  gethostname(name, sizeof name - 1);
  host_ = std::string(name).substr(0, sizeof(Slot::host) - 1);
}

Claims::~Claims() {
  if (file_ >= 0) ::close(file_);
}

int64_t Claims::place_of(const std::string& key) {
  return static_cast<int64_t>(std::stoull(key.substr(0, 15), nullptr, 16));
}

/// Open file description locks: they belong to this Claims, not to the process, so two of them exclude each other too.
bool Claims::lock(int64_t place, short type) const {
  if (file_ < 0) return true;
  struct flock range {};
  range.l_type = type;
  range.l_whence = SEEK_SET;
  range.l_start = place;
  range.l_len = 1;
  while (fcntl(file_, F_OFD_SETLK, &range) != 0) {
    if (errno == EINTR) continue;
    return errno != EAGAIN && errno != EACCES;  // a file system without locks: every claim is granted
  }
  return true;
}

Claims::Slot Claims::read_slot(const std::string& key) const {
  Slot slot{};
  if (file_ < 0 || pread(file_, &slot, sizeof slot, place_of(key) % slots * static_cast<int64_t>(sizeof slot)) !=
                       static_cast<ssize_t>(sizeof slot))
    return {};
  return slot;
}

void Claims::write_slot(const std::string& key, bool done) const {
  if (file_ < 0) return;
  Slot slot{};
  std::memcpy(slot.key, key.data(), std::min(key.size(), sizeof slot.key));
  std::memcpy(slot.host, host_.data(), host_.size());
  slot.done = done ? 1 : 0;
  slot.process = getpid();
  // That it fails (a full disk) costs only what the slot tells.
  [[maybe_unused]] const ssize_t written =
      pwrite(file_, &slot, sizeof slot, place_of(key) % slots * static_cast<int64_t>(sizeof slot));
}

bool Claims::use_store() { return lock(processes + getpid(), F_RDLCK) && lock(whole_store, F_RDLCK); }

bool Claims::is_gone(long process) const {
  struct flock range {};
  range.l_type = F_WRLCK;
  range.l_whence = SEEK_SET;
  range.l_start = processes + process;
  range.l_len = 1;
  return file_ >= 0 && fcntl(file_, F_OFD_GETLK, &range) == 0 && range.l_type == F_UNLCK;
}

bool Claims::have_store_alone() { return lock(whole_store, F_WRLCK); }

bool Claims::take(const std::string& key) {
  {
    const std::scoped_lock guard(mutex_);
    if (!held_.insert(key).second) return false;
  }
  if (!lock(place_of(key), F_WRLCK)) {
    const std::scoped_lock guard(mutex_);
    held_.erase(key);
    return false;
  }
  return true;
}

void Claims::begin(const std::string& key) { write_slot(key, false); }

void Claims::give_back(const std::string& key, bool done) {
  if (done) write_slot(key, true);
  lock(place_of(key), F_UNLCK);
  {
    const std::scoped_lock guard(mutex_);
    held_.erase(key);
  }
  given_back_.notify_all();
}

bool Claims::is_done(const std::string& key) const {
  const Slot slot = read_slot(key);
  return slot.is_of(key) && slot.done == 1;
}

bool Claims::holder_is_stopped(const std::string& key) const {
  const Slot slot = read_slot(key);
  if (!slot.is_of(key) || slot.done || slot.process == getpid() || host_ != std::string(slot.host)) return false;
  std::ifstream stream("/proc/" + std::to_string(slot.process) + "/stat");
  std::string text;
  std::getline(stream, text);
  const size_t name_end = text.rfind(')');
  return name_end != std::string::npos && name_end + 2 < text.size() &&
         (text[name_end + 2] == 'T' || text[name_end + 2] == 't');
}

std::string Claims::holder(const std::string& key) const {
  const Slot slot = read_slot(key);
  if (!slot.is_of(key) || slot.process == 0) return "";
  return "process " + std::to_string(slot.process) + " on " + slot.host;
}

void Claims::wait(int milliseconds) {
  std::unique_lock guard(mutex_);
  given_back_.wait_for(guard, std::chrono::milliseconds(milliseconds));
}

Turn::Turn(Claims& claims, std::string key, std::string key_with_seed)
    : claims_(claims), key_(std::move(key)), key_with_seed_(std::move(key_with_seed)) {}

/// Whoever waits for the second of the two waits for the first before, as long as that is held: one of them says
/// enough.
Turn::~Turn() {
  if (has_seeded_) claims_.give_back(key_with_seed_, done_ && !has_key_);
  if (has_key_) claims_.give_back(key_, done_);
}

bool Turn::take() {
  if (!claims_.take(key_)) {
    busy_ = key_;
    return false;
  }
  if (!claims_.take(key_with_seed_)) {
    claims_.give_back(key_, false);
    busy_ = key_with_seed_;
    return false;
  }
  has_key_ = has_seeded_ = true;
  return true;
}

bool Turn::was_done() const { return claims_.is_done(key_) || claims_.is_done(key_with_seed_); }

void Turn::begin() { claims_.begin(key_); }

void Turn::seed_was_drawn() {
  const std::scoped_lock guard(mutex_);
  if (!has_key_) return;
  has_key_ = false;
  claims_.begin(key_with_seed_);
  claims_.give_back(key_, false);
}

}  // namespace plumbline::runtime

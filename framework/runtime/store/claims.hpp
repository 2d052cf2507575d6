// Who computes what, so that nothing is computed twice at the same time, in one process or in many on one store.
//
// A claim is a lock of the kernel's on one byte of the file `claims`, at the place that the key's hash names. The lock
// goes with the process that holds it, however it ends, and on a shared folder the file server keeps it. Beside it the
// holder writes who it is and, when the result is in the store, that it is done: whoever waited then knows that the
// result is there, even if a shared folder shows it late.
//
// A holder that is stopped (SIGSTOP, a suspended job) would keep everybody waiting: on this machine it is recognised
// and passed over. Two processes may then compute the same, which costs time and nothing else, because results are
// named by content.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <set>
#include <string>

namespace plumbline::runtime {

class Claims {
 public:
  /// `file` is made if need be. Where it cannot be written, every claim is granted.
  explicit Claims(const std::filesystem::path& file);
  ~Claims();
  Claims(const Claims&) = delete;
  Claims& operator=(const Claims&) = delete;

  /// False if somebody else, here or in another process, has it. Never waits.
  bool take(const std::string& key);
  /// Says that the holder computes it now.
  void begin(const std::string& key);
  /// Gives it back; `done`: the result is in the store.
  void give_back(const std::string& key, bool done);

  /// Says that this process uses the store. False if somebody is pruning it.
  bool use_store();
  /// True if no process of that number, on any machine, says so.
  bool is_gone(long process) const;
  /// Nobody but this process uses the store from now on, as long as this lives. False if somebody does.
  bool have_store_alone();

  /// True if the last holder said that the result is in the store.
  bool is_done(const std::string& key) const;
  /// True if the holder is a process of this machine that is stopped.
  bool holder_is_stopped(const std::string& key) const;
  /// "process 4711 on host", or nothing if it is not known.
  std::string holder(const std::string& key) const;

  /// Waits until somebody of this process gives a claim back, at most that long.
  void wait(int milliseconds);

 private:
  struct Slot;
  static int64_t place_of(const std::string& key);
  Slot read_slot(const std::string& key) const;
  void write_slot(const std::string& key, bool done) const;
  bool lock(int64_t place, short type) const;

  int file_ = -1;
  std::string host_;
  mutable std::mutex mutex_;
  std::condition_variable given_back_;
  std::set<std::string> held_;  // by this process
};

/// The claims of one run of a node: under the key of its fields, which serves every seed, and under the key with its
/// seed. Once the node asks for its seed, its result cannot serve other seeds, and the first is given back.
class Turn {
 public:
  Turn(Claims& claims, std::string key, std::string key_with_seed);
  ~Turn();
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

  /// Takes both or none. False: busy() is taken by somebody else.
  bool take();
  const std::string& busy() const { return busy_; }
  /// True if who had one of them before says that its result is in the store.
  bool was_done() const;
  void begin();
  void seed_was_drawn();
  void done() { done_ = true; }

 private:
  Claims& claims_;
  const std::string key_, key_with_seed_;
  std::string busy_;
  std::mutex mutex_;
  bool has_key_ = false, has_seeded_ = false, done_ = false;
};

}  // namespace plumbline::runtime

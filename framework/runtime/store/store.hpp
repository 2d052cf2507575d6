// The store: every artifact that ever left a node, and what each run of a node gave.
//
//   blobs/ab/<sha256>      an artifact, named by its content
//   runs/ab/<key>.json     what one run of a node gave: outputs by hash (small ones with their content), metrics,
//                          warnings, time
//   folders/<name>/        what a node wrote as a folder; artifacts name it by the uri "store:<name>"
//   pipelines/<id>.json    key of every node in the last run of a pipeline, for `plumbline plan`
//   file-hashes            see file_hashes.hpp
//   claims                 see claims.hpp
//   tmp/                   whatever is not finished
//
// Everything is written in tmp/ and renamed into place, so readers see whole files only, several programs can share a
// store, and a killed one leaves nothing but rubbish in tmp/. Content is checked against its name when it is first read
// in a process: a file that a power failure left empty is found there, removed, and the node that made it runs again.
// Hence correctness needs no fsync, and none is done unless `durable` is asked for: syncing the file system of a busy
// machine took seconds a run.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "plumbline/plugin.h"
#include "runtime/store/claims.hpp"
#include "runtime/store/file_hashes.hpp"

namespace plumbline::runtime {

/// The store cannot do what is asked: what() names the store, the reason and the mend.
class StoreError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Content of a blob, held in memory or mapped; unmapped when the last copy goes.
class Blob {
 public:
  plumbline_bytes bytes() const;
  struct Memory;
  explicit Blob(std::shared_ptr<const Memory> memory) : memory_(std::move(memory)) {}

 private:
  friend class Store;
  std::shared_ptr<const Memory> memory_;
};

struct Metric {
  std::string name;
  double value = 0;
  std::string unit;
};

/// Where and how a result was computed; it goes with the result to whoever takes it over.
struct Provenance {
  double start = 0;     ///< seconds since 1970; 0: not known
  std::string host;     ///< the machine's name
  int threads = 0;      ///< that the run was given
  std::string program;  ///< version of plumbline
  std::string plugin;   ///< version of the node's plugin
};

/// What one run of a node gave.
struct StoredRun {
  std::string kind;
  std::map<std::string, std::vector<std::string>> outputs;  ///< blob hashes by port
  std::map<std::string, std::string> folders;               ///< tree hash by the name of the folder
  std::vector<Metric> metrics;
  std::vector<std::string> warnings, messages;
  double seconds = 0;
  Provenance provenance;
  /// Hash by path of the files that it was found to depend on when it ran, beside what its key is made of;
  /// of one that must not be there, absent_hash.
  std::map<std::string, std::string> used;
};

class Store {
 public:
  /// $PLUMBLINE_STORE, else $XDG_CACHE_HOME/plumbline, else ~/.cache/plumbline. Throws StoreError if none is set.
  static std::filesystem::path default_folder();

  /// Opens or makes the store. `durable`: every file reaches the disk before the next step. Throws StoreError, also for
  /// a store that somebody else may write (trust.hpp).
  explicit Store(const std::filesystem::path& folder, bool durable = false);
  /// Opens a store that is there to look at it; it may be one that cannot be written. Throws StoreError.
  static std::unique_ptr<Store> for_reading(const std::filesystem::path& folder);
  const std::filesystem::path& folder() const { return folder_; }

  /// Keeps the bytes and returns their hash. Throws StoreError, e.g. if the disk is full.
  std::string put(const void* data, size_t size);
  /// The same for an output of a node that put_run() or keep() will name: up to `inline_up_to` bytes wait in memory and
  /// go into the run's record. A file of their own would cost more than all the rest of a small node.
  std::string hold(const void* data, size_t size);
  static constexpr size_t inline_up_to = 512;
  /// For a store that is thrown away: what nodes hand on stays in memory up to so many bytes an item.
  void keep_in_memory(size_t up_to) { in_memory_up_to_ = up_to; }
  /// The blob of that hash. Throws StoreError if it is missing or does not match its name; then it has been removed.
  Blob get(const std::string& hash);

  void put_run(const std::string& key, const StoredRun& run);
  /// Makes blobs of what a run without a record holds: the run of a node that is not deterministic.
  void keep(const StoredRun& run);
  /// The run of that key if it is there with all that it names. If something of it is missing or damaged, `damage` says
  /// what, and the answer is empty, so that the node runs again.
  /// `outdated` says which of the files that the run used has changed; the answer is empty then, too.
  std::optional<StoredRun> find_run(const std::string& key, std::string& damage, std::string& outdated);

  /// An empty folder for a node to fill, then commit_folder() or discard it.
  std::filesystem::path new_folder();
  /// Moves a filled folder to its name, or to that of its content if none is given, and returns the hash of its tree.
  /// If that name holds the same tree already, that stays.
  std::string commit_folder(const std::filesystem::path& filled, const std::string& name = "");
  std::filesystem::path folder_path(const std::string& name) const;
  /// Path of a file or folder that an artifact names: "store:<name>/...", "sha256:<hash>/..." (file_hashes.hpp) or a
  /// path. Empty if the uri leads out of the store. Throws std::runtime_error if a content is nowhere any more.
  std::filesystem::path resolve(const std::string& uri) const;

  /// A small text kept by pipeline, empty if there is none.
  std::string pipeline_note(const std::string& id) const;
  void put_pipeline_note(const std::string& id, const std::string& text);

  /// Blobs, small ones in records too, whose hash starts with `prefix` (at least four digits).
  std::vector<std::string> blobs_starting_with(const std::string& prefix) const;

  FileHashes& file_hashes() { return *file_hashes_; }
  Claims& claims() { return *claims_; }

  /// What is stored of each kind of node: runs, and bytes of the blobs and folders that no kind before it named.
  struct Usage {
    size_t runs = 0;
    uint64_t bytes = 0;
  };
  std::map<std::string, Usage> usage() const;
  struct Pruned {
    size_t runs = 0, blobs = 0, folders = 0;
    uint64_t bytes = 0;
  };
  /// Removes the results that were not used for the longest time, until those that stay take at most `bytes` and none
  /// is older than `days`; then what no result names. Throws StoreError while a program uses the store.
  Pruned prune(uint64_t bytes, double days);

 private:
  struct ReadOnly {};
  Store(const std::filesystem::path& folder, ReadOnly);
  void check_trust() const;
  std::string blob_path(const std::string& hash) const;
  std::string run_path(const std::string& key) const;
  std::string temporary_name();
  void write(const std::string& path, const void* data, size_t size);
  void clear_way_to(const std::string& path);
  std::shared_ptr<const Blob::Memory> load(const std::string& path) const;
  std::shared_ptr<const Blob::Memory> held(const std::string& hash);
  std::shared_ptr<const Blob::Memory> from_file(const std::string& hash);
  std::map<std::string, std::shared_ptr<const Blob::Memory>> contents_starting_with(const std::string& prefix) const;
  [[noreturn]] void throw_missing(const std::string& hash) const;
  [[noreturn]] void fail(const std::string& what, int error) const;
  std::string changed_of(const std::map<std::string, std::string>& used);
  void remove_leftovers() const;
  void sync() const;

  std::filesystem::path folder_;
  bool durable_ = false, writable_ = true;
  size_t in_memory_up_to_ = inline_up_to;
  std::string temporary_prefix_;
  std::unique_ptr<FileHashes> file_hashes_;
  std::unique_ptr<Claims> claims_;
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<const Blob::Memory>> open_;    // blobs in use
  std::map<std::string, std::shared_ptr<const Blob::Memory>> held_;  // small outputs that need no file
  std::set<std::string> checked_;                                    // blobs that matched their name
};

}  // namespace plumbline::runtime

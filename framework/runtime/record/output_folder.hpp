// The folder a run delivers to, which may hold files of the user's beside those of earlier runs.
//
// The program replaces or removes only what run.jsonl in that folder proves it wrote, with unchanged content: the
// record tells the SHA-256 of every file before it is put in place, and the next record takes over what the one before
// it proved. Everything else is an obstacle that is named before anything runs. No tree is removed blindly: files go
// one by one, each after its hash was found in the record, and folders only when they are empty.
//
// New content is made in a staging folder of unpredictable name, which the record tells of, and renamed into place;
// what a killed run left in it is put away by the next. The folder is locked while a run has it.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "runtime/store/file_hashes.hpp"

namespace plumbline::runtime {

/// Which run an output is of.
struct OutputOrigin {
  std::string time;                    ///< UTC at which the run began
  std::vector<std::string> arguments;  ///< its KEY=VALUE overrides
};

/// What a record proves. Paths are relative to the output folder, with forward slashes.
struct Ownership {
  std::map<std::string, std::set<std::string>> files;  ///< SHA-256 that the file had when it was written
  std::map<std::string, std::string> made_from;        ///< by output: identity of what it was made from
  std::set<std::string> folders;                       ///< that the program made
  std::map<std::string, OutputOrigin> origins;         ///< by output: the run that wrote it or found it as it must be
};

/// A file of a tree that is delivered.
struct TreeFile {
  std::string path;  ///< below the tree, checked to be a plain relative path
  std::string sha256;
  std::function<void(const std::filesystem::path& target)> write;  ///< makes the file there; throws if it cannot
};

class OutputFolder {
 public:
  /// Makes the folder if need be, locks it and reads what its record proves. With `overwrite`, files in the way of an
  /// output are replaced whoever wrote them. Throws std::runtime_error if it cannot be had: no rights, another run.
  OutputFolder(std::filesystem::path folder, FileHashes& hashes, bool overwrite = false);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  const std::filesystem::path& path() const { return folder_; }
  std::filesystem::path record() const { return folder_ / "run.jsonl"; }
  const std::string& staging_name() const { return staging_; }
  const Ownership& owned() const { return owned_; }

  /// What stands in the way of delivering `output` (a tree or a file), a sentence each; empty: nothing.
  std::vector<std::string> obstacles(const std::string& output, bool tree) const;

  /// Replaces run.jsonl by a record that begins with `line`; append() adds to it. Throws std::runtime_error.
  void begin_record(const std::string& line);
  void append(const std::string& line);
  int record_file() const { return record_; }  ///< -1: no record was begun

  /// True if `output` is there as a run left it that made it of the same things: `made_from` is their identity.
  bool holds(const std::string& output, const std::string& made_from) const;

  /// Puts a file or a tree in place, whole or not at all; what is the same already is not written again. Returns a note
  /// for people, mostly empty. Throws std::runtime_error if it cannot, or if meanwhile there is something in the way.
  void put_file(const TreeFile& file, const std::string& made_from);
  std::string put_tree(const std::string& output, const std::vector<TreeFile>& files, const std::string& made_from);

  /// Removes what an earlier run left as `output`. Returns what had to stay, as a sentence; empty: nothing did.
  std::string remove(const std::string& output);

  /// The run that has the folder now; and that `output` is what it gave.
  void set_run(OutputOrigin run) { run_ = std::move(run); }
  void confirm(const std::string& output) {
    owned_.origins[output] = run_;
    confirmed_.insert(output);
  }
  bool is_of_this_run(const std::string& output) const { return confirmed_.contains(output); }

  /// Forgets files that are no more: what run_end tells is the final state.
  void settle_ownership();

 private:
  enum class Standing { absent, ours, changed, foreign, link, folder, other };
  struct Entry {
    std::string path;  // below the folder that was walked
    bool is_folder = false;
  };
  Standing standing(const std::string& path) const;
  std::string in_words(const std::string& path, Standing standing) const;
  std::vector<std::string> not_ours_in(const std::string& path) const;
  bool is_owned_content(const std::filesystem::path& file, const std::string& path) const;
  static std::vector<Entry> walk(const std::filesystem::path& folder);
  void lock();
  void read_record();
  void put_away_leftovers();
  void announce(const std::string& output, const std::map<std::string, std::string>& files, bool tree);
  std::set<std::string> missing_folders(const std::string& path) const;
  void make_folders(const std::string& path);
  void move_in(const std::filesystem::path& made, const std::string& path);
  std::filesystem::path build(const std::string& output, const std::vector<TreeFile>& files);
  std::string merge(const std::filesystem::path& made, const std::string& output, const std::vector<TreeFile>& files);
  std::string discard(const std::filesystem::path& old, const std::string& output);
  static void clear(const std::filesystem::path& staged);

  std::filesystem::path folder_;
  FileHashes& hashes_;
  bool overwrite_ = false;
  int lock_ = -1, record_ = -1;
  std::string staging_;                           // name of this run's staging folder
  std::string old_staging_;                       // of the run before
  std::map<std::string, std::string> displaced_;  // "old-3" of the run before -> output
  size_t deliveries_ = 0;
  OutputOrigin run_;
  std::set<std::string> confirmed_;
  Ownership owned_;
};

/// "a/b/c" -> {"a", "a/b"}
std::vector<std::string> parents_of(const std::string& path);

}  // namespace plumbline::runtime

// Hashes of files outside the store, remembered so that a folder of photographs is read once and not at every run.
//
// A file is recognised by device, inode, size, time of modification and time of status change; the path plays no part,
// so a folder keeps its hashes when it is renamed. A file that was modified less than two seconds before it was read is
// not remembered: a second write within the tick of the file system's clock would go unnoticed. Nor is one that a
// program has open for writing: through a mapping (numpy.memmap) it may change without a trace in its times. Whether
// that is so the kernel tells of the user's own files, on file systems that have leases; of others it is not known, and
// `plumbline run --rehash` trusts no memory. What lies in the
// store's own tmp/ is, as long as the process runs: nobody but the node that writes it touches it, and it has just been
// read.
//
// Where a content was last seen is remembered too, because artifacts name files and folders by content:
//
//   sha256:<hash of a file>/<its name>          sha256:<hash of a tree>[/<path of a file in it>]
#pragma once

#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace plumbline::runtime {

class FileHashes {
 public:
  /// `log` is the file of the memory; lines are appended, several processes may do so at once. What lies in `passing`
  /// is on its way elsewhere: its place is not remembered.
  explicit FileHashes(std::filesystem::path log, const std::filesystem::path& passing = {});

  /// From now on every file is read once more, whatever is remembered of it.
  void distrust_memory();

  /// SHA-256 of the file's content, 64 hexadecimal digits. Throws std::runtime_error if it cannot be read.
  std::string of_file(const std::filesystem::path& path);

  /// SHA-256 over the relative paths and content hashes of all files below a folder, links followed, without what runs
  /// of the program left there (plumbline/folder_files.hpp). Throws std::runtime_error if the folder or one of its
  /// files cannot be read.
  std::string of_tree(const std::filesystem::path& folder);

  /// Relative path and content hash of every file that of_tree() is made of, in its order.
  using Tree = std::vector<std::pair<std::string, std::string>>;
  Tree files_of(const std::filesystem::path& folder);
  static std::string hash_of(const Tree& tree);
  /// The tree lies at `folder` now.
  void remember_places(const std::filesystem::path& folder, const Tree& tree);

  /// The hash of either.
  std::string of(const std::filesystem::path& path);

  /// A file or folder that has this hash now. Throws std::runtime_error that names where it was last seen.
  std::filesystem::path locate(const std::string& hash);

  /// Whether the uri is "sha256:<hash>/...", and that hash.
  static bool names_content(const std::string& uri);
  static std::string hash_in(const std::string& uri);
  /// What such a uri names; `place` is where the content of that hash is, which may be a folder with the file in it.
  /// Throws like locate().
  std::filesystem::path resolve(const std::string& uri, std::filesystem::path* place = nullptr);

 private:
  bool is_passing(const std::filesystem::path& path) const;
  void remember(const std::string& identity, const std::string& hash, const std::filesystem::path& path);
  std::filesystem::path log_;
  std::string passing_;  // with a '/' at its end
  std::mutex mutex_;
  std::map<std::string, std::string> known_;                // by identity
  std::map<std::string, std::string> own_;                  // the same of what came through `passing`, not in the log
  std::map<std::string, std::vector<std::string>> places_;  // by hash, the last one last
};

}  // namespace plumbline::runtime

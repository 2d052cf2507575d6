// The files of a folder, as the host hashes them and as nodes list them. Library: Plumbline::folder_files.
//
// What a run of the program left in a folder is no content of it, so that a campaign may hold its own results: the key
// of a node that reads the folder must not change by what the pipeline writes there. run.jsonl says which files those
// are, by their names. A folder that a run delivered, such as a simulated campaign, is read by its own name. Nor is the
// file that the program itself prints to (`plumbline run ... > log.txt`), which grows while it is read.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline {

/// Paths are relative to the folder, with forward slashes, ordered by their bytes.
struct FolderFiles {
  std::vector<std::string> files;     ///< regular files, through links
  std::vector<std::string> outputs;   ///< those that runs left there; not among `files`
  std::vector<std::string> dangling;  ///< links to nothing; not among `files`
};

/// Says which files this process prints to; its workers, and all they list, know it from the environment.
void announce_printed_files();

/// Lists all files below a folder, links followed. Throws std::runtime_error if a folder cannot be read, if a link
/// leads back to a folder that holds it, and beyond two million files.
FolderFiles list_files(const std::filesystem::path& folder);

/// Whether systems and office programs write files of that name beside those of people: "._Foto.jpg" and .DS_Store of
/// macOS, Thumbs.db and desktop.ini of Windows, "~$Plan.xlsx" of an open document, all in hidden folders and in those
/// of servers of files (.thumbnails, @eaDir). `path` is relative to the folder that was listed, with forward slashes.
bool is_system_file(std::string_view path);

}  // namespace plumbline

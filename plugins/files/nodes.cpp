// Files and folders from outside the pipeline: the only nodes that turn a path into data.
#include <algorithm>
#include <filesystem>

#include "artifacts/file_artifact.hpp"
#include "artifacts/folder.hpp"
#include "plumbline/node.hpp"

namespace {

using namespace plumbline;
namespace fs = std::filesystem;

struct ReadFile : Node {
  static constexpr Info info{"read.file", "", 1, "Reads one file as it is"};
  Param<FilePath> file{"file", required, "the file"};
  Out<File> out{"file", "its content and base name"};

  void run(Context&) override { out.commit(file_artifact(file->path)); }
};

struct ReadFolder : Node {
  static constexpr Info info{"read.folder", "", 2, "Lists a folder with the hash of every file in it"};
  Param<FolderPath> folder{"folder", required, "the folder"};
  Out<Folder> out{"folder", "its files, by reference"};

  void run(Context& context) override {
    const fs::path root = folder->path;
    std::vector<fs::path> paths;
    for (const auto& entry : fs::recursive_directory_iterator(root))
      if (entry.is_regular_file()) paths.push_back(entry.path());
    FolderT result;
    result.uri = "sha256:" + context.digest(root.string());
    for (const fs::path& path : paths) {
      auto item = std::make_unique<FolderEntryT>();
      item->path = path.lexically_relative(root).generic_string();
      item->sha256 = context.digest(path.string());
      item->size = fs::file_size(path);
      result.files.push_back(std::move(item));
    }
    std::sort(result.files.begin(), result.files.end(), [](const auto& a, const auto& b) { return a->path < b->path; });
    out.commit(result);
  }
};

}  // namespace

PLUMBLINE_PLUGIN("files", "0.1.0", "MIT", ReadFile, ReadFolder)

// Files and folders from outside the pipeline: the only nodes that turn a path into data.
#include <filesystem>

#include "artifacts/file_artifact.hpp"
#include "artifacts/folder.hpp"
#include "plumbline/folder_files.hpp"
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
  static constexpr Info info{"read.folder", "", 3,
                             "Lists a folder with the hash of every file in it, but what runs left there"};
  Param<FolderPath> folder{"folder", required, "the folder"};
  Out<Folder> out{"folder", "its files, by reference"};

  void run(Context& context) override {
    const fs::path root = folder->path;
    const FolderFiles found = list_files(root);
    if (!found.outputs.empty())
      context.info(std::to_string(found.outputs.size()) + " files that runs left in " + root.string() +
                   " are no content of it");
    FolderT result;
    result.uri = "sha256:" + context.digest(root.string());
    for (const std::string& path : found.files) {
      auto item = std::make_unique<FolderEntryT>();
      item->path = path;
      item->sha256 = context.digest((root / path).string());
      item->size = fs::file_size(root / path);
      result.files.push_back(std::move(item));
    }
    out.commit(result);
  }
};

}  // namespace

PLUMBLINE_PLUGIN("files", PLUMBLINE_BUILD_ID, "MIT", ReadFile, ReadFolder)

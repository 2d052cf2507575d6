// plumbline example: the data of the tutorial, in a folder of one's own.
#include <cstdio>

#include "commands.hpp"
#include "terminal.hpp"

namespace plumbline::cli {

namespace fs = std::filesystem;

namespace {

constexpr const char* the_example = "board";

/// Beside the folders of pipelines.
fs::path examples_folder() {
  for (const fs::path& pipelines : pipeline_folders()) {
    const fs::path folder = pipelines.parent_path() / "examples";
    if (pipelines.is_absolute() && fs::is_directory(folder / the_example)) return folder;
  }
  throw std::runtime_error("the examples are not there: share/plumbline/examples of the installation is missing");
}

}  // namespace

int example(const Options& options) {
  const fs::path folder = options.name.empty() ? fs::path(the_example) : fs::path(options.name);
  if (fs::exists(fs::symlink_status(folder)) && !(fs::is_directory(folder) && fs::is_empty(folder)))
    throw UsageError(folder.string() + " is there already; choose another name");
  fs::create_directories(folder);
  for (const auto& entry : fs::directory_iterator(examples_folder() / the_example)) {
    const fs::path copy = folder / entry.path().filename();
    fs::copy_file(entry.path(), copy);
    fs::permissions(copy, fs::perms::owner_write, fs::perm_options::add);
  }
  std::printf("%s: photographs of a printed board, its print as a survey. What they give:\n\n", folder.c_str());
  std::printf("  plumbline run photo_campaign folder=%s detector=aruco family=DICT_6X6_1000\n", folder.c_str());
  return 0;
}

}  // namespace plumbline::cli

// Runs the built program as people do, in a folder of its own with its own store; with the test plugins, or those of
// the build.
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "test_support.hpp"

namespace plumbline::test {

struct Answer {
  int code = -1;
  std::string out, err;
};

class Program {
 public:
  explicit Program(const std::filesystem::path& plugins = std::filesystem::path(PLUMBLINE_STORY_PLUGIN).parent_path())
      : plugins_(plugins) {
    std::filesystem::create_directory(folder.path() / "work");
    // Only those plugins: a copy of the program in a folder without plugins beside it.
    std::filesystem::create_directories(folder.path() / "bin");
    std::filesystem::copy_file(PLUMBLINE_PROGRAM, folder.path() / "bin" / "plumbline");
  }

  void write(const std::string& name, const std::string& text) const { std::ofstream(work() / name) << text; }
  void use_plugins(const std::filesystem::path& folder_of_plugins) { plugins_ = folder_of_plugins; }
  /// Root reads what nobody may read: from now on the program runs as "nobody", to whom all of the folder is given.
  void without_roots_rights() {
    if (geteuid() != 0) return;
    user_ = 65534;
    const auto give = [&](const std::filesystem::path& path) {
      if (lchown(path.c_str(), user_, user_) != 0) throw std::runtime_error("cannot give away " + path.string());
    };
    give(folder.path());
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path())) give(entry.path());
  }
  std::filesystem::path work() const { return folder.path() / "work"; }
  const std::filesystem::path& plugins() const { return plugins_; }

  /// Starts the program in work(), or another folder, and returns its process.
  pid_t start(const std::vector<std::string>& arguments) const { return start(arguments, work()); }
  pid_t start(const std::vector<std::string>& arguments, const std::filesystem::path& place) const {
    const std::string program = folder.path() / "bin" / "plumbline";
    const pid_t child = fork();
    if (child != 0) return child;
    std::vector<char*> words{const_cast<char*>(program.c_str())};
    for (const std::string& word : arguments) words.push_back(const_cast<char*>(word.c_str()));
    words.push_back(nullptr);
    setenv("PLUMBLINE_PLUGIN_PATH", plugins_.c_str(), 1);
    setenv("PLUMBLINE_STORE", (folder.path() / "store").c_str(), 1);
    setenv("XDG_CACHE_HOME", (folder.path() / "cache").c_str(), 1);
    const int out = open((folder.path() / "out").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    const int err = open((folder.path() / "err").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (chdir(place.c_str()) != 0 || dup2(out, 1) < 0 || dup2(err, 2) < 0) _exit(126);
    if (user_ != 0 && (setgid(user_) != 0 || setuid(user_) != 0)) _exit(126);
    execv(program.c_str(), words.data());
    _exit(127);
  }
  Answer finish(pid_t child) const {
    int status = 0;
    waitpid(child, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), read_file(folder.path() / "out"),
            read_file(folder.path() / "err")};
  }
  Answer operator()(const std::vector<std::string>& arguments) const { return finish(start(arguments)); }
  Answer in(const std::filesystem::path& place, const std::vector<std::string>& arguments) const {
    return finish(start(arguments, place));
  }

  TemporaryFolder folder;

 private:
  std::filesystem::path plugins_;
  uid_t user_ = 0;  ///< the program runs as, if it is not 0
};

inline bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

inline const std::string chain =
    "plumbline: 1\n"
    "vars: {value: 3, seed: 1}\n"
    "nodes:\n"
    "  a: {use: story.constant, with: {value: \"${value}\"}}\n"
    "  b: {use: story.add, in: {a: a.number}, with: {offset: 1}}\n"
    "outputs: {b.json: b.sum}\n";

}  // namespace plumbline::test

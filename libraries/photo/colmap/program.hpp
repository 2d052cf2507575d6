// The program `colmap` as a process of its own: started without a shell, without a display, ended when nobody waits for
// it any more or its time is up. It stays in our process group, so that whoever kills that kills it too.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace plumbline::colmap {

/// A folder for exchanged files, removed with all that is in it whatever happens.
class ScratchFolder {
 public:
  ScratchFolder();  ///< Throws std::runtime_error if none can be made.
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  /// A new folder in it.
  std::filesystem::path make(const std::string& name) const;

 private:
  std::filesystem::path path_;
};

/// The name by which it is looked for on PATH, where nobody says which one it is.
inline constexpr const char* usual_program = "colmap";

/// Runs `program`, COLMAP by its name or path, with these arguments (the first is its command) and gives all that it
/// printed. What it prints goes through the file `log`. Throws std::runtime_error if the program is not installed, ends
/// with an error or takes longer than `seconds`, with the end of what it printed; Stopped if the work is to end.
std::string run_program(const std::string& program, const std::vector<std::string>& arguments, double seconds,
                        const std::filesystem::path& log);

/// Whether the program can be started.
bool is_installed(const std::string& program = usual_program);

/// What it says it is: "COLMAP 3.8", empty if it says nothing of that kind. Asked once for each program.
std::string version_of(const std::string& program);

}  // namespace plumbline::colmap

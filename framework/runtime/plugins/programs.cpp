#include "runtime/plugins/programs.hpp"

#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "runtime/base/child_process.hpp"
#include "runtime/base/digest.hpp"
#include "runtime/plugins/elf.hpp"
#include "runtime/plugins/library.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

/// What a program prints, and how it ends; killed after `milliseconds`.
std::string printed_by(std::vector<std::string> arguments, int milliseconds, int* status = nullptr) {
  ChildStart start;
  start.arguments = std::move(arguments);
  start.ends_with_this_thread = true;
  ChildProcess child = start_child(start);
  pollfd ending{child.handle, POLLIN, 0};
  while (poll(&ending, 1, milliseconds) < 0 && errno == EINTR) {
  }
  const ChildEnd end = finish_child(child);
  if (status) *status = end.status;
  std::string said = end_of_log(child.log, size_t{1} << 20);
  close(child.log);
  return said;
}

/// What the loader prints of a program's libraries, without running any of it.
std::string asked_of_loader(const fs::path& loader, const fs::path& program) {
  return printed_by({loader.string(), "--list", program.string()}, 20000);
}

/// What stands behind a script (conda, flatpak, docker, a shell's exec) nothing shows but what it says of itself. A
/// program that ends by an error says that, too; one that takes longer than five seconds says nothing.
std::string said_by_script(const fs::path& program) {
  int status = 0;
  std::string said = printed_by({program.string(), "-h"}, 5000, &status);
  if (WIFSIGNALED(status)) said.clear();  // how far it came depends on how busy the machine was
  Sha256 hash;
  hash.add_field(said);
  hash.add_field(std::to_string(status));
  return hash.hex();
}

/// The libraries of lines such as "libz.so.1 => /lib/libz.so.1 (0x00007f...)".
std::vector<std::string> libraries_in(const std::string& said) {
  std::vector<std::string> paths;
  std::istringstream lines(said);
  for (std::string line; std::getline(lines, line);) {
    const size_t path = line.find("=> /"), end = line.rfind(" (0x");
    if (path != std::string::npos && end != std::string::npos && end > path)
      paths.push_back(line.substr(path + 3, end - path - 3));
  }
  return paths;
}

struct Looked {
  std::map<std::string, std::string> identities;  // which files they were
  std::string field;
  bool still_holds() const {
    for (const auto& [path, identity] : identities)
      if (file_identity(path) != identity) return false;
    return true;
  }
};

Looked look_at(const std::string& program, FileHashes& files) {
  Looked looked;
  looked.identities[program] = file_identity(program);
  looked.field = "sha256:" + files.of_file(program);
  const fs::path loader = elf_interpreter(program);
  if (loader.empty()) {
    if (is_script(program)) looked.field += " says:" + said_by_script(program);
    return looked;
  }
  Sha256 hash;
  for (const std::string& library : libraries_in(asked_of_loader(loader, program))) {
    looked.identities[library] = file_identity(library);
    hash.add_field(fs::path(library).filename().string());
    hash.add_field(id_of_library(library));
  }
  looked.field += " libraries:" + hash.hex();
  return looked;
}

}  // namespace

bool is_script(const fs::path& program) {
  std::ifstream file(program, std::ios::binary);
  char begin[2] = {};
  return file.read(begin, 2) && begin[0] == '#' && begin[1] == '!';
}

bool names_program(const plumbline_param& param) {
  return param.kind == PLUMBLINE_FILE && !param.is_list && param.default_text && *param.default_text &&
         !std::strchr(param.default_text, '/');
}

std::string find_program(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "/usr/bin:/bin");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path candidate = fs::absolute(fs::path(folder.empty() ? "." : folder) / name).lexically_normal();
    std::error_code failed;
    if (fs::is_regular_file(candidate, failed) && access(candidate.c_str(), X_OK) == 0) return candidate.string();
  }
  return name;
}

std::string program_field(const std::string& program, FileHashes& files) {
  if (program.find('/') == std::string::npos) return "not installed";
  static std::mutex mutex;
  static std::map<std::string, Looked> known;
  const std::scoped_lock lock(mutex);
  auto found = known.find(program);
  if (found == known.end() || !found->second.still_holds())
    found = known.insert_or_assign(program, look_at(program, files)).first;
  return found->second.field;
}

}  // namespace plumbline::runtime

#include "runtime/plugins/library.hpp"

#include <dlfcn.h>
#include <sys/stat.h>

#include <stdexcept>

namespace plumbline::runtime {

namespace fs = std::filesystem;

std::string file_identity(const fs::path& path) {
  struct stat found {};
  if (stat(path.c_str(), &found) != 0) return "absent";
  std::string text;
  for (const auto value :
       {static_cast<uint64_t>(found.st_dev), static_cast<uint64_t>(found.st_ino), static_cast<uint64_t>(found.st_size),
        static_cast<uint64_t>(found.st_mtim.tv_sec), static_cast<uint64_t>(found.st_mtim.tv_nsec),
        // Whoever writes can set the time of modification back; that of the change of status nobody can.
        static_cast<uint64_t>(found.st_ctim.tv_sec), static_cast<uint64_t>(found.st_ctim.tv_nsec)})
    text += std::to_string(value) + ' ';
  return text;
}

const plumbline_plugin_table* open_table(const fs::path& library) {
  void* handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle) {
    const std::string why = dlerror();
    const bool missing = why.find("cannot open shared object file") != std::string::npos;
    throw std::runtime_error("cannot be loaded: " + why +
                             (missing ? "; install the package that has it, or set LD_LIBRARY_PATH"
                                      : "; link it with every library it uses (-Wl,--no-undefined tells at once)"));
  }
  const auto entry = reinterpret_cast<const plumbline_plugin_table* (*)()>(dlsym(handle, "plumbline_plugin"));
  if (!entry) throw std::runtime_error("does not export plumbline_plugin(); use plumbline_add_plugin() in CMake");
  return entry();
}

}  // namespace plumbline::runtime

#include "build_info.hpp"

#include <filesystem>
#include <fstream>
#include <set>

#include "build_commit.hpp"

namespace plumbline::cli {

std::string build_commit() { return PLUMBLINE_COMMIT; }

std::string build_compiler() { return PLUMBLINE_COMPILER; }

std::vector<std::string> loaded_libraries() {
  std::ifstream maps("/proc/self/maps");
  std::set<std::string> names;
  for (std::string line; std::getline(maps, line);) {
    const auto slash = line.find('/');
    if (slash == std::string::npos || line.find(".so", slash) == std::string::npos) continue;
    const std::string name = std::filesystem::path(line.substr(slash)).filename().string();
    if (name.rfind("libplumbline", 0) != 0) names.insert(name);
  }
  return {names.begin(), names.end()};
}

}  // namespace plumbline::cli

// plumbline new: a folder that a node of one's own begins with. It builds against the installation, passes the tests of
// its role and runs in a pipeline as it is; what is to be replaced is marked in its source.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <set>

#include "commands.hpp"
#include "runtime/base/printable.hpp"
#include "terminal.hpp"

namespace plumbline::cli {

namespace fs = std::filesystem;

namespace {

/// Beside the folders of pipelines.
fs::path templates_folder() {
  for (const fs::path& pipelines : pipeline_folders()) {
    const fs::path folder = pipelines.parent_path() / "templates";
    if (pipelines.is_absolute() && fs::is_directory(folder)) return folder;
  }
  throw std::runtime_error("the templates are not there: share/plumbline/templates of the installation is missing");
}

std::vector<std::string> templates_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory()) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// It becomes a part of file names, of the node's kind and of CMake targets.
void check_name(const std::string& name) {
  const auto fits = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
  if (!name.empty() && name[0] >= 'a' && name[0] <= 'z' && name.size() <= 40 &&
      std::all_of(name.begin(), name.end(), fits))
    return;
  throw UsageError("'" + name +
                   "' cannot be the name of a node: small letters, digits and '_', a letter first, at most 40");
}

std::string read_text(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string filled(std::string text, const std::map<std::string, std::string>& values) {
  for (const auto& [word, value] : values)
    for (size_t at = 0; (at = text.find(word, at)) != std::string::npos; at += value.size())
      text.replace(at, word.size(), value);
  return text;
}

/// The kind that the template declares, as "detect.mine".
std::string kind_of(const fs::path& folder, const std::map<std::string, std::string>& values) {
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string text = entry.is_regular_file() ? read_text(entry.path()) : "";
    for (const std::string before : {"Info info{\"", "\nkind: "}) {
      const size_t at = text.find(before);
      if (at == std::string::npos) continue;
      const size_t start = at + before.size();
      return filled(text.substr(start, text.find_first_of("\"\n", start) - start), values);
    }
  }
  throw std::runtime_error("the template " + folder.string() + " declares no node");
}

void write_all(const fs::path& from, const fs::path& to, const std::map<std::string, std::string>& values) {
  fs::create_directories(to);
  for (const auto& entry : fs::recursive_directory_iterator(from)) {
    const fs::path target = to / filled(fs::relative(entry.path(), from).string(), values);
    if (entry.is_directory()) {
      fs::create_directories(target);
      continue;
    }
    std::ofstream stream(target, std::ios::binary);
    stream << filled(read_text(entry.path()), values);
    stream.close();
    if (!stream) throw std::runtime_error("cannot write " + target.string());
    fs::permissions(target, entry.status().permissions() | fs::perms::owner_write);
  }
}

}  // namespace

int new_node(const Options& options) {
  const fs::path templates = templates_folder();
  std::string wanted = options.role;
  std::replace(wanted.begin(), wanted.end(), '-', '_');
  const std::vector<std::string> known = templates_in(templates);
  if (std::find(known.begin(), known.end(), wanted) == known.end()) {
    std::string all;
    for (const std::string& name : known) all += (all.empty() ? "" : ", ") + name;
    const std::string hint = did_you_mean(wanted, known);
    throw UsageError("there is no template '" + options.role + "'" + (hint.empty() ? "; there are " + all : hint));
  }
  check_name(options.name);
  const fs::path self = fs::read_symlink("/proc/self/exe"), prefix = self.parent_path().parent_path();
  const bool installed = fs::is_regular_file(prefix / "lib/cmake/Plumbline/PlumblineConfig.cmake");
  const std::map<std::string, std::string> values = {
      {"@name@", options.name}, {"@prefix@", installed ? prefix.string() : ""}, {"@program@", self.string()}};
  const fs::path folder = options.out.empty() ? fs::path(options.name) : fs::path(options.out);
  if (fs::exists(fs::symlink_status(folder)) && !(fs::is_directory(folder) && fs::is_empty(folder)))
    throw UsageError(folder.string() + " is there already; choose another name, or another folder with --out DIR");
  const std::string kind = kind_of(templates / wanted, values);
  if (const runtime::Registry registry = discover(); registry.find(kind))
    throw UsageError("there is a node " + kind + " already; choose another name");
  write_all(templates / wanted, folder, values);
  std::printf("%s: the node %s\n\n", folder.c_str(), kind.c_str());
  const bool compiled = fs::is_regular_file(folder / "CMakeLists.txt");
  std::vector<std::vector<std::string>> rows = {
      {"  " + (folder / "check").string(),
       compiled ? "builds it, tests it and runs it in a pipeline" : "runs it in a pipeline"},
      {"  " + (folder / (compiled ? options.name + ".cpp" : "own_" + options.name + ".py")).string(),
       "is where your own goes"}};
  std::printf("%s", columns(rows).c_str());
  if (compiled && !installed)
    std::printf(
        "\nThis program is not installed with what plugins are built with. First: cmake --install BUILD --prefix "
        "PREFIX, then\nCMAKE_PREFIX_PATH=PREFIX %s\n",
        (folder / "check").c_str());
  return 0;
}

}  // namespace plumbline::cli

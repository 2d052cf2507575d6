#include "runtime/graph/include_paths.hpp"

#include <algorithm>

namespace plumbline::runtime {

namespace fs = std::filesystem;

std::string with_values(const std::string& name, const ValueOfVariable& value_of, std::string& unknown) {
  std::string text;
  size_t at = 0;
  for (;;) {
    const size_t begin = name.find("${", at), end = begin == std::string::npos ? begin : name.find('}', begin);
    if (end == std::string::npos) return text + name.substr(at);
    const std::string variable = name.substr(begin + 2, end - begin - 2);
    const auto value = value_of(variable);
    if (!value && unknown.empty()) unknown = variable;
    text += name.substr(at, begin - at) + value.value_or("");
    at = end + 1;
  }
}

fs::path find_include(const fs::path& file, const std::string& name, const std::vector<fs::path>& include_folders) {
  if (name.empty()) return {};
  std::vector<fs::path> folders{file.parent_path()};
  folders.insert(folders.end(), include_folders.begin(), include_folders.end());
  for (const fs::path& folder : folders)
    for (const fs::path& candidate : {folder / name, folder / (name + ".yaml")})
      if (fs::is_regular_file(candidate)) return candidate.lexically_normal();
  return {};
}

std::string included_places(const fs::path& file, const std::string& name, const std::string& replaced,
                            const std::vector<fs::path>& folders) {
  std::string text = (file.parent_path() / replaced).lexically_normal().string();
  for (const fs::path& folder : folders) text += ", nor in " + folder.string();
  const size_t begin = name.find("${"), end = name.rfind('}');
  const size_t slash = name.rfind('/', begin);
  if (begin == std::string::npos || end == std::string::npos || name.find('/', begin) != std::string::npos) return text;
  const size_t stem = slash == std::string::npos ? 0 : slash + 1;
  const std::string before = name.substr(stem, begin - stem), after = name.substr(end + 1);
  std::vector<std::string> others;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(file.parent_path() / name.substr(0, stem), error)) {
    const std::string other = entry.path().filename().string();
    if (other.size() > before.size() + after.size() && other.starts_with(before) && other.ends_with(after))
      others.push_back(other.substr(before.size(), other.size() - before.size() - after.size()));
  }
  std::sort(others.begin(), others.end());
  for (size_t i = 0; i < others.size(); ++i)
    text += (i == 0 ? "; " + name.substr(begin, end + 1 - begin) + " may be " : ", ") + others[i];
  return text;
}

}  // namespace plumbline::runtime

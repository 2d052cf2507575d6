// What may stand where a run delivers to: whose a file is that is there already.
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>

#include "runtime/record/output_folder.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

std::vector<std::string> parents_of(const std::string& path) {
  std::vector<std::string> parents;
  for (size_t at = path.find('/'); at != std::string::npos; at = path.find('/', at + 1))
    parents.push_back(path.substr(0, at));
  return parents;
}

/// Everything below a folder, folders before what is in them; links are not followed.
std::vector<OutputFolder::Entry> OutputFolder::walk(const fs::path& folder) {
  std::vector<Entry> entries;
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, error);
  for (const fs::recursive_directory_iterator end; !error && entry != end; entry.increment(error))
    entries.push_back(
        {entry->path().lexically_relative(folder).generic_string(), fs::is_directory(entry->symlink_status(error))});
  if (error) throw std::runtime_error("cannot read the folder " + folder.string() + ": " + error.message());
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.path < b.path; });
  return entries;
}

bool OutputFolder::is_owned_content(const fs::path& file, const std::string& path) const {
  const auto known = owned_.files.find(path);
  struct stat info {};
  if (known == owned_.files.end() || lstat(file.c_str(), &info) != 0 || !S_ISREG(info.st_mode)) return false;
  try {
    return known->second.count(hashes_.of_file(file)) > 0;
  } catch (const std::exception&) {  // unreadable: nothing is proved
    return false;
  }
}

OutputFolder::Standing OutputFolder::standing(const std::string& path) const {
  struct stat info {};
  if (lstat((folder_ / path).c_str(), &info) != 0) return errno == ENOENT ? Standing::absent : Standing::other;
  if (S_ISDIR(info.st_mode)) return Standing::folder;
  if (S_ISLNK(info.st_mode)) return Standing::link;
  if (!S_ISREG(info.st_mode)) return Standing::other;
  if (is_owned_content(folder_ / path, path)) return Standing::ours;
  return owned_.files.count(path) ? Standing::changed : Standing::foreign;
}

std::string OutputFolder::in_words(const std::string& path, Standing standing) const {
  const std::string name = (folder_ / path).string();
  switch (standing) {
    case Standing::changed:
      return name + " was changed since a run wrote it";
    case Standing::foreign:
      return name + " was not written by a run that the record in this folder tells of";
    case Standing::link:
      return name + " is a link, which no run makes";
    case Standing::folder:
      return name + " is a folder";
    default:
      return name + " is no regular file or cannot be looked at";
  }
}

/// What lies below a folder that no record proves, in words.
std::vector<std::string> OutputFolder::not_ours_in(const std::string& path) const {
  std::vector<std::string> found;
  if (!owned_.folders.count(path)) found.push_back((folder_ / path).string() + " is a folder that no run made");
  for (const Entry& entry : walk(folder_ / path)) {
    const std::string below = path + "/" + entry.path;
    const Standing is = standing(below);
    if (entry.is_folder ? !owned_.folders.count(below) : is != Standing::ours)
      found.push_back(entry.is_folder ? (folder_ / below).string() + " is a folder that no run made"
                                      : in_words(below, is));
  }
  return found;
}

std::vector<std::string> OutputFolder::obstacles(const std::string& output, bool tree) const {
  for (const std::string& parent : parents_of(output)) {
    const Standing is = standing(parent);
    if (is == Standing::absent) return {};
    if (is != Standing::folder) return {(folder_ / parent).string() + " must be a folder to hold " + output};
  }
  const Standing is = standing(output);
  switch (is) {
    case Standing::absent:
    case Standing::ours:
      return {};
    case Standing::folder:
      return tree && overwrite_ ? std::vector<std::string>{} : not_ours_in(output);
    case Standing::other:
      return {in_words(output, is)};
    default:
      return overwrite_ ? std::vector<std::string>{} : std::vector<std::string>{in_words(output, is)};
  }
}

}  // namespace plumbline::runtime

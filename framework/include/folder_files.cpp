#include "plumbline/folder_files.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

namespace plumbline {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::json;

/// What run.jsonl in a folder says was written beside it. Paths relative to that folder.
struct Written {
  bool is_record = false;
  std::set<std::string> files;
};

bool is_event(const std::string& line, const char* event) {
  return line.rfind(std::string("{\"event\":\"") + event + "\"", 0) == 0;
}

void add_keys(const Json& json, const char* key, std::set<std::string>& names) {
  if (!json.is_object() || !json.contains(key) || !json[key].is_object()) return;
  for (const auto& [name, ignored] : json[key].items()) names.insert(name);
}

/// A line that a crash cut off, or that another run is just writing, says nothing.
Written read_record(const fs::path& record) {
  Written written;
  std::ifstream stream(record, std::ios::binary);
  std::string line;
  if (!std::getline(stream, line) || !is_event(line, "run_start")) return written;
  written.is_record = true;
  do {
    const bool deliver = is_event(line, "deliver");
    if (!deliver && !is_event(line, "run_start") && !is_event(line, "run_end")) continue;
    const Json json = Json::parse(line, nullptr, false);
    if (!json.is_object()) continue;
    if (deliver)
      add_keys(json, "files", written.files);
    else if (json.contains("owned"))
      add_keys(json["owned"], "files", written.files);
  } while (std::getline(stream, line));
  return written;
}

constexpr const char* printed_files = "PLUMBLINE_PRINTS_TO";  // "device:inode " of each

std::string identity_of(const struct stat& info) {
  return std::to_string(info.st_dev) + ":" + std::to_string(info.st_ino) + " ";
}

class Walk {
 public:
  explicit Walk(const fs::path& top) : top_(top) {
    if (const char* set = std::getenv(printed_files)) printed_ = set;
    enter(top, "");
    std::sort(found_.files.begin(), found_.files.end());
    std::sort(found_.outputs.begin(), found_.outputs.end());
    std::sort(found_.dangling.begin(), found_.dangling.end());
  }
  FolderFiles take() { return std::move(found_); }

 private:
  static constexpr std::size_t most_files = 2'000'000;

  struct Record {
    std::string prefix;  // of the folder that it lies in, with a '/' at its end
    Written written;
  };

  /// A link that leads back to a folder that holds it is refused: behind it everything stands once more, and behind two
  /// of them without end.
  void enter(const fs::path& folder, const std::string& prefix) {
    struct stat info {};
    std::error_code error;
    fs::directory_iterator entry(folder, error);
    if (error || stat(folder.c_str(), &info) != 0)
      throw std::runtime_error("cannot read the folder " + folder.string() + ": " +
                               (error ? error.message() : std::strerror(errno)));
    const std::pair<dev_t, ino_t> self{info.st_dev, info.st_ino};
    if (std::find(above_.begin(), above_.end(), self) != above_.end())
      throw std::runtime_error("the link " + folder.string() +
                               " leads back to a folder that holds it; take the link away");
    above_.push_back(self);
    Written written = read_record(folder / "run.jsonl");
    if (written.is_record) records_.push_back({prefix, std::move(written)});
    const bool own_record = !records_.empty() && records_.back().prefix == prefix;
    for (const fs::directory_iterator end; entry != end; entry.increment(error)) {
      if (error) throw std::runtime_error("cannot read the folder " + folder.string() + ": " + error.message());
      const std::string path = prefix + entry->path().filename().string();
      std::error_code ignored;
      if (entry->is_directory(ignored))
        enter(entry->path(), path + "/");
      else if (entry->is_regular_file(ignored))
        (is_output(path) || is_printed_to(entry->path()) ? found_.outputs : found_.files).push_back(path);
      else if (entry->is_symlink(ignored) && !entry->exists(ignored))
        found_.dangling.push_back(path);
      if (found_.files.size() + found_.outputs.size() > most_files)
        throw std::runtime_error(top_.string() + " holds more than " + std::to_string(most_files) +
                                 " files; do links in it show folders again and again?");
    }
    above_.pop_back();
    if (own_record) records_.pop_back();
  }

  bool is_output(const std::string& path) const {
    if (path == ".run.jsonl.new" || path.ends_with("/.run.jsonl.new")) return true;  // a record that is just begun
    for (const Record& record : records_) {
      const std::string local = path.substr(record.prefix.size());
      if (local == "run.jsonl" || local.rfind(".plumbline-", 0) == 0 || record.written.files.count(local)) return true;
    }
    return false;
  }

  bool is_printed_to(const fs::path& file) const {
    struct stat info {};
    return !printed_.empty() && stat(file.c_str(), &info) == 0 &&
           printed_.find(" " + identity_of(info)) != std::string::npos;
  }

  fs::path top_;
  std::string printed_;
  FolderFiles found_;
  std::vector<std::pair<dev_t, ino_t>> above_;
  std::vector<Record> records_;  // of the folders above
};

}  // namespace

void announce_printed_files() {
  std::string files = " ";
  for (const int stream : {1, 2}) {
    struct stat info {};
    if (fstat(stream, &info) == 0 && S_ISREG(info.st_mode)) files += identity_of(info);
  }
  if (files.size() > 1)
    setenv(printed_files, files.c_str(), 1);
  else
    unsetenv(printed_files);
}

FolderFiles list_files(const fs::path& folder) { return Walk(folder).take(); }

/// Folders that nobody opens: hidden ones, such as .thumbnails and .@__thumb, and those that servers of files and
/// Windows make for small copies and for what was deleted.
static bool is_in_system_folder(std::string_view path) {
  for (std::size_t at = 0, end; (end = path.find('/', at)) != std::string_view::npos; at = end + 1) {
    const std::string_view folder = path.substr(at, end - at);
    const bool hidden = folder.size() > 1 && folder[0] == '.' && folder != "..";
    if (hidden || folder == "@eaDir" || folder == "#recycle" || folder == "$RECYCLE.BIN") return true;
  }
  return false;
}

bool is_system_file(std::string_view path) {
  const std::string_view name = path.substr(path.rfind('/') + 1);  // npos + 1 is 0
  const auto is = [&](std::string_view other) {
    return name.size() == other.size() && std::equal(name.begin(), name.end(), other.begin(), [](char a, char b) {
             return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b;
           });
  };
  return name.starts_with("._") || name.starts_with("~$") || is(".ds_store") || is("thumbs.db") || is("ehthumbs.db") ||
         is("desktop.ini") || path.starts_with("__MACOSX/") || is_in_system_folder(path);
}

}  // namespace plumbline

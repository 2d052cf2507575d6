#include "runtime/record/output_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <stdexcept>

#include "runtime/base/digest.hpp"
#include "runtime/base/new_file.hpp"
#include "runtime/record/ownership.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

std::string unpredictable_name() {
  std::random_device device;
  std::string name = ".plumbline-";
  for (int i = 0; i < 16; ++i) name += "0123456789abcdef"[device() % 16];
  return name;
}

const std::string record_begin = "{\"event\":\"run_start\"";

}  // namespace

OutputFolder::OutputFolder(fs::path folder, FileHashes& hashes, bool overwrite)
    : folder_(std::move(folder)), hashes_(hashes), overwrite_(overwrite), staging_(unpredictable_name()) {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error || !fs::is_directory(folder_) || access(folder_.c_str(), W_OK | X_OK) != 0)
    throw std::runtime_error("cannot write to the output folder " + folder_.string() + ": " +
                             (error ? error.message() : std::strerror(errno)) + "; choose another with --out");
  lock();
  try {
    read_record();
    put_away_leftovers();
  } catch (...) {
    ::close(lock_);
    throw;
  }
}

OutputFolder::~OutputFolder() {
  if (record_ >= 0) ::close(record_);
  ::rmdir((folder_ / staging_).c_str());
  if (lock_ >= 0) ::close(lock_);
}

void OutputFolder::lock() {
  lock_ = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ < 0) fail_to_write("cannot open the output folder " + folder_.string(), errno);
  if (flock(lock_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;  // a file system without locks has none
  ::close(lock_);
  throw std::runtime_error("another run is writing to the output folder " + folder_.string() + record_owner(record()) +
                           "; wait for its end or choose another with --out");
}

void OutputFolder::read_record() {
  struct stat info {};
  if (lstat(record().c_str(), &info) != 0) return;
  if (!S_ISREG(info.st_mode))
    throw std::runtime_error(record().string() + " is no regular file, and the record of the run goes there; move it " +
                             "away or choose another folder with --out");
  if (!read_ownership(record(), owned_, old_staging_, displaced_) && !overwrite_)
    throw std::runtime_error(record().string() +
                             " is no record of a run, and would be replaced by one; choose another folder with --out, "
                             "or --overwrite to replace it");
}

/// What a killed run was just writing, and the beginning of a record that it could not put in place.
void OutputFolder::put_away_leftovers() {
  const fs::path begun = folder_ / ".run.jsonl.new";
  struct stat info {};
  if (lstat(begun.c_str(), &info) == 0 && S_ISREG(info.st_mode)) {
    // Cut off anywhere: what there is of it must be how a record begins.
    std::ifstream stream(begun, std::ios::binary);
    std::string text(record_begin.size(), '\0');
    stream.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(stream.gcount());
    if (record_begin.compare(0, text.size(), text) == 0) ::unlink(begun.c_str());
  }
  if (old_staging_.empty()) return;
  const fs::path staged = folder_ / old_staging_;
  if (lstat(staged.c_str(), &info) != 0 || !S_ISDIR(info.st_mode)) return;
  for (const auto& [name, output] : displaced_)
    if (fs::is_directory(fs::symlink_status(staged / name))) discard(staged / name, output);
  std::error_code error;
  std::vector<fs::path> made;
  for (const auto& entry : fs::directory_iterator(staged, error))
    if (entry.path().filename().string().starts_with("new-")) made.push_back(entry.path());
  for (const fs::path& path : made) clear(path);
  ::rmdir(staged.c_str());
}

void OutputFolder::begin_record(const std::string& line) {
  const fs::path begun = folder_ / ".run.jsonl.new";
  record_ = ::open(begun.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0666);
  if (record_ < 0) fail_to_write("cannot write " + begun.string(), errno);
  try {
    append(line);
    if (::rename(begun.c_str(), record().c_str()) != 0) fail_to_write("cannot write " + record().string(), errno);
  } catch (...) {
    ::unlink(begun.c_str());
    throw;
  }
}

void OutputFolder::append(const std::string& line) {
  const std::string text = line + "\n";
  for (size_t at = 0; at < text.size();) {
    const ssize_t written = ::write(record_, text.data() + at, text.size() - at);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail_to_write("cannot write " + record().string(), errno);
    at += static_cast<size_t>(written);
  }
}

/// Tells the record what is about to be put in place: proof must be there before the thing itself.
void OutputFolder::announce(const std::string& output, const std::map<std::string, std::string>& files, bool tree) {
  if (record_ < 0) throw std::logic_error("a delivery before its record was begun");
  std::set<std::string> folders;
  for (const auto& [path, sha256] : files) {
    owned_.files[path].insert(sha256);
    folders.merge(missing_folders(path));
  }
  if (tree) folders.merge(missing_folders(output + "/"));  // a tree without files is a folder, too
  owned_.folders.insert(folders.begin(), folders.end());
  append(deliver_line(output, ++deliveries_, files, folders));
  if (::mkdir((folder_ / staging_).c_str(), 0777) != 0 && errno != EEXIST)
    fail_to_write("cannot make " + (folder_ / staging_).string(), errno);
}

std::set<std::string> OutputFolder::missing_folders(const std::string& path) const {
  std::set<std::string> missing;
  struct stat info {};
  for (const std::string& parent : parents_of(path))
    if (lstat((folder_ / parent).c_str(), &info) != 0) missing.insert(parent);
  return missing;
}

/// Those above `path`. A link among them is not gone through: it may lead anywhere.
void OutputFolder::make_folders(const std::string& path) {
  for (const std::string& parent : parents_of(path)) {
    if (::mkdir((folder_ / parent).c_str(), 0777) == 0) continue;
    if (errno != EEXIST) fail_to_write("cannot make the folder " + (folder_ / parent).string(), errno);
    if (!fs::is_directory(fs::symlink_status(folder_ / parent)))
      throw std::runtime_error((folder_ / parent).string() + " must be a folder to hold " + path);
  }
}

/// Renames a made file into place, if what is there may go.
void OutputFolder::move_in(const fs::path& made, const std::string& path) {
  Standing is = standing(path);
  if (is == Standing::folder && not_ours_in(path).empty()) {
    remove(path);
    is = standing(path);
  }
  const bool may_go = is == Standing::ours ||
                      (overwrite_ && (is == Standing::changed || is == Standing::foreign || is == Standing::link));
  if (is != Standing::absent && !may_go) {
    clear(made);
    throw std::runtime_error(in_words(path, is) + ", and is left as it is");
  }
  if ((may_go ? ::rename(made.c_str(), (folder_ / path).c_str()) : rename_to_absent(made, folder_ / path)) == 0) return;
  const int error = errno;
  clear(made);
  fail_to_write("cannot write " + (folder_ / path).string(), error);
}

bool OutputFolder::holds(const std::string& output, const std::string& made_from) const {
  const auto known = owned_.made_from.find(output);
  if (known == owned_.made_from.end() || known->second != made_from) return false;
  const Standing is = standing(output);
  if (is == Standing::ours) return true;
  if (is != Standing::folder || !not_ours_in(output).empty()) return false;
  for (auto file = owned_.files.lower_bound(output + "/");
       file != owned_.files.end() && file->first.starts_with(output + "/"); ++file)
    if (standing(file->first) != Standing::ours) return false;
  return true;
}

void OutputFolder::put_file(const TreeFile& file, const std::string& made_from) {
  const std::string& output = file.path;
  if (standing(output) != Standing::ours || hashes_.of_file(folder_ / output) != file.sha256) {
    announce(output, {{output, file.sha256}}, false);
    make_folders(output);
    const fs::path made = folder_ / staging_ / ("new-" + std::to_string(deliveries_));
    file.write(made);
    move_in(made, output);
  }
  owned_.files[output] = {file.sha256};
  owned_.made_from[output] = made_from;
}

/// The tree in the staging folder; a file that is there already is linked, not copied.
fs::path OutputFolder::build(const std::string& output, const std::vector<TreeFile>& files) {
  const fs::path made = folder_ / staging_ / ("new-" + std::to_string(deliveries_));
  try {
    fs::create_directory(made);
    for (const TreeFile& file : files) {
      fs::create_directories((made / file.path).parent_path());
      const fs::path present = folder_ / output / file.path;
      if (standing(output + "/" + file.path) == Standing::ours && hashes_.of_file(present) == file.sha256 &&
          ::link(present.c_str(), (made / file.path).c_str()) == 0)
        continue;
      file.write(made / file.path);
    }
  } catch (...) {
    clear(made);
    throw;
  }
  return made;
}

std::string OutputFolder::put_tree(const std::string& output, const std::vector<TreeFile>& files,
                                   const std::string& made_from) {
  std::map<std::string, std::string> paths;
  for (const TreeFile& file : files) paths[output + "/" + file.path] = file.sha256;
  const Standing before = standing(output);
  std::string note;
  const auto same = [&] {
    size_t found = 0;
    for (const Entry& entry : walk(folder_ / output)) {
      if (entry.is_folder) continue;
      const auto wanted = paths.find(output + "/" + entry.path);
      if (wanted == paths.end() || standing(wanted->first) != Standing::ours ||
          hashes_.of_file(folder_ / wanted->first) != wanted->second)
        return false;
      ++found;
    }
    return found == paths.size();
  };
  if (before != Standing::folder || !same()) {
    announce(output, paths, true);
    make_folders(output);
    const fs::path made = build(output, files);
    if (before != Standing::folder) {
      move_in(made, output);
    } else if (not_ours_in(output).empty()) {
      const fs::path old = folder_ / staging_ / ("old-" + std::to_string(deliveries_));
      if (::rename((folder_ / output).c_str(), old.c_str()) != 0) fail_to_write("cannot replace " + output, errno);
      if (rename_to_absent(made, folder_ / output) != 0)
        fail_to_write("cannot write " + (folder_ / output).string(), errno);
      note = discard(old, output);
    } else if (overwrite_) {
      note = merge(made, output, files);
    } else {
      clear(made);
      throw std::runtime_error(not_ours_in(output).front() + ", and is left as it is");
    }
  }
  for (auto file = owned_.files.lower_bound(output + "/");
       file != owned_.files.end() && file->first.starts_with(output + "/");)
    file = paths.count(file->first) ? std::next(file) : owned_.files.erase(file);
  for (const auto& [path, sha256] : paths) owned_.files[path] = {sha256};
  owned_.made_from[output] = made_from;
  return note;
}

/// Puts the files of a tree beside others that stay, each on its own.
std::string OutputFolder::merge(const fs::path& made, const std::string& output, const std::vector<TreeFile>& files) {
  std::set<std::string> wanted;
  for (const TreeFile& file : files) {
    wanted.insert(file.path);
    make_folders(output + "/" + file.path);
    move_in(made / file.path, output + "/" + file.path);
  }
  size_t stays = 0;
  for (const Entry& entry : walk(folder_ / output)) {
    if (entry.is_folder || wanted.count(entry.path)) continue;
    const std::string path = output + "/" + entry.path;
    if (standing(path) == Standing::ours)
      ::unlink((folder_ / path).c_str());
    else
      ++stays;
  }
  clear(made);
  return stays == 0 ? ""
                    : std::to_string(stays) + (stays == 1 ? " file" : " files") + " in " + (folder_ / output).string() +
                          " that no run wrote stay" + (stays == 1 ? "s" : "") + " there beside the output's own";
}

/// Removes a tree that was moved out of the way, file by file as the record proves them. What came in between is moved
/// back to where it was.
std::string OutputFolder::discard(const fs::path& old, const std::string& output) {
  std::vector<Entry> entries = walk(old);
  std::string note;
  for (const Entry& entry : entries) {
    const std::string path = output + "/" + entry.path;
    if (entry.is_folder) {
      if (!owned_.folders.count(path)) make_folders(path + "/");
      continue;
    }
    if (is_owned_content(old / entry.path, path)) {
      ::unlink((old / entry.path).c_str());
      continue;
    }
    make_folders(path);
    if (rename_to_absent(old / entry.path, folder_ / path) != 0)
      note = "what another program wrote to " + (folder_ / path).string() + " meanwhile is kept in " + old.string();
  }
  for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry)
    if (entry->is_folder) ::rmdir((old / entry->path).c_str());
  ::rmdir(old.c_str());
  return note;
}

/// What this program made in a staging folder and nobody else knows of.
void OutputFolder::clear(const fs::path& staged) {
  std::error_code error;
  if (!fs::is_directory(fs::symlink_status(staged, error))) {
    ::unlink(staged.c_str());
    return;
  }
  std::vector<Entry> entries = walk(staged);
  for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry)
    entry->is_folder ? ::rmdir((staged / entry->path).c_str()) : ::unlink((staged / entry->path).c_str());
  ::rmdir(staged.c_str());
}

std::string OutputFolder::remove(const std::string& output) {
  const Standing is = standing(output);
  if (is == Standing::absent) return "";
  if (is == Standing::folder) {
    std::vector<Entry> entries = walk(folder_ / output);
    for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry) {
      const std::string path = output + "/" + entry->path;
      if (entry->is_folder && owned_.folders.count(path)) ::rmdir((folder_ / path).c_str());
      if (!entry->is_folder && standing(path) == Standing::ours) ::unlink((folder_ / path).c_str());
    }
    if (owned_.folders.count(output)) ::rmdir((folder_ / output).c_str());
  } else if (is == Standing::ours) {
    ::unlink((folder_ / output).c_str());
  }
  return standing(output) == Standing::absent ? "" : "; what lies at its place is not of this run";
}

void OutputFolder::settle_ownership() {
  struct stat info {};
  for (auto file = owned_.files.begin(); file != owned_.files.end();)
    file = lstat((folder_ / file->first).c_str(), &info) == 0 ? std::next(file) : owned_.files.erase(file);
  for (auto folder = owned_.folders.begin(); folder != owned_.folders.end();)
    folder = lstat((folder_ / *folder).c_str(), &info) == 0 ? std::next(folder) : owned_.folders.erase(folder);
  for (auto from = owned_.made_from.begin(); from != owned_.made_from.end();)
    from = lstat((folder_ / from->first).c_str(), &info) == 0 ? std::next(from) : owned_.made_from.erase(from);
  for (auto of = owned_.origins.begin(); of != owned_.origins.end();)
    of = lstat((folder_ / of->first).c_str(), &info) == 0 ? std::next(of) : owned_.origins.erase(of);
}

}  // namespace plumbline::runtime

#include "runtime/store/store.hpp"

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <sstream>
#include <utility>

#include "runtime/base/digest.hpp"
#include "runtime/base/trust.hpp"
#include "runtime/store/blob_memory.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

/// Blobs below this size are read, above they are mapped: a mapping costs a page and one of 65 530 entries.
constexpr size_t map_from = size_t{64} << 10;

plumbline_bytes Blob::bytes() const { return {memory_->data(), memory_->size}; }

namespace {

/// Closes at the end of the scope; -1 is none.
struct File {
  int number = -1;
  explicit File(int n) : number(n) {}
  int close() { return ::close(std::exchange(number, -1)); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  ~File() {
    if (number >= 0) ::close(number);
  }
};

bool write_all(int file, const void* data, size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = ::write(file, at, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    at += written;
    size -= static_cast<size_t>(written);
  }
  return true;
}

bool read_all(int file, void* data, size_t size) {
  char* at = static_cast<char*>(data);
  while (size > 0) {
    const ssize_t count = ::read(file, at, size);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    at += count;
    size -= static_cast<size_t>(count);
  }
  return true;
}

bool safe_name(const std::string& name) {
  return !name.empty() && name[0] != '.' && name.find('/') == std::string::npos;
}

}  // namespace

fs::path Store::default_folder() {
  const auto variable = [](const char* name) -> std::string {
    const char* text = std::getenv(name);
    return text ? text : "";
  };
  if (const std::string set = variable("PLUMBLINE_STORE"); !set.empty()) return set;
  if (const std::string cache = variable("XDG_CACHE_HOME"); !cache.empty()) return fs::path(cache) / "plumbline";
  if (const std::string home = variable("HOME"); !home.empty()) return fs::path(home) / ".cache" / "plumbline";
  throw StoreError("no place for the store: HOME is not set; choose one with --store or PLUMBLINE_STORE");
}

Store::Store(const fs::path& folder, bool durable) : folder_(fs::absolute(folder)), durable_(durable) {
  check_trust();
  const bool fresh = !fs::exists(folder_);
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) fail("cannot make " + folder_.string(), error.value());
  // Whatever the umask: what others could write would not be believed the next time.
  if (fresh) fs::permissions(folder_, fs::perms::group_write | fs::perms::others_write, fs::perm_options::remove);
  for (const char* part : {"blobs", "runs", "folders", "pipelines", "tmp"})
    if (::mkdir((folder_ / part).c_str(), 0755) != 0 && errno != EEXIST)
      fail("cannot make " + (folder_ / part).string(), errno);
  if (access((folder_ / "tmp").c_str(), W_OK | X_OK) != 0) fail("cannot write to " + (folder_ / "tmp").string(), errno);
  char host[65] = "host";
  gethostname(host, sizeof host - 1);
  // Containers may have one name and a first process each: what was drawn tells them apart.
  uint64_t drawn = 0;
  if (getrandom(&drawn, sizeof drawn, 0) != sizeof drawn) drawn = static_cast<uint64_t>(std::time(nullptr));
  temporary_prefix_ = std::string(host) + "-" + std::to_string(getpid()) + "-" + std::to_string(drawn) + "-";
  file_hashes_ = std::make_unique<FileHashes>(folder_ / "file-hashes", folder_ / "tmp");
  claims_ = std::make_unique<Claims>(folder_ / "claims");
  if (!claims_->use_store())
    throw StoreError("the store " + folder_.string() + " is being pruned; try again in a moment");
  remove_leftovers();
}

Store::Store(const fs::path& folder, ReadOnly) : folder_(fs::absolute(folder)), writable_(false) {
  if (!fs::is_directory(folder_)) throw StoreError("there is no store " + folder_.string());
  check_trust();
  file_hashes_ = std::make_unique<FileHashes>(folder_ / "file-hashes", folder_ / "tmp");
  claims_ = std::make_unique<Claims>("/nonexistent/claims");
}

std::unique_ptr<Store> Store::for_reading(const fs::path& folder) {
  if (!fs::exists(folder) || access((folder / "tmp").c_str(), W_OK | X_OK) == 0) return std::make_unique<Store>(folder);
  return std::unique_ptr<Store>(new Store(folder, ReadOnly{}));
}

/// A result of somebody else's would be delivered as one's own.
void Store::check_trust() const {
  std::string problem = distrust(folder_);
  for (const char* part : {"blobs", "runs", "folders", "pipelines"})
    if (problem.empty()) problem = distrust(folder_ / part);
  if (!problem.empty())
    throw StoreError("the store is not believed: " + problem + ", or choose another with --store or PLUMBLINE_STORE");
}

void Store::fail(const std::string& what, int error) const {
  std::string text = what + ": " + std::strerror(error) + "; ";
  if (error == ENOSPC || error == EDQUOT)
    text += "free some space or choose another store with --store or PLUMBLINE_STORE";
  else
    text += "check the rights on " + folder_.string() + " or choose another store with --store or PLUMBLINE_STORE";
  throw StoreError(text);
}

/// What processes of this machine left in tmp/ that are no more. Names are host-process-drawn-count, and nothing that
/// is called otherwise is touched. Without locks nobody can say who is alive, and it stays.
void Store::remove_leftovers() const {
  std::error_code ignored;
  std::string host = temporary_prefix_;
  for (int part = 0; part < 2; ++part) host.erase(host.rfind('-', host.size() - 2) + 1);
  for (const auto& entry : fs::directory_iterator(folder_ / "tmp", ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.compare(0, host.size(), host) != 0 || name.compare(0, temporary_prefix_.size(), temporary_prefix_) == 0)
      continue;
    const char* const end = name.data() + name.size();
    long process = 0;
    const auto first = std::from_chars(name.data() + host.size(), end, process);
    if (first.ec != std::errc() || first.ptr == end || *first.ptr != '-') continue;
    if (std::string(first.ptr, end).find_first_not_of("0123456789-") != std::string::npos) continue;
    if (process > 0 && claims_->is_gone(process)) fs::remove_all(entry.path(), ignored);
  }
}

// Put together as text: a path is split into its parts at each step, which a node pays for several times.
std::string Store::blob_path(const std::string& hash) const {
  return folder_.native() + "/blobs/" + hash.substr(0, 2) + "/" + hash;
}

std::string Store::run_path(const std::string& key) const {
  return folder_.native() + "/runs/" + key.substr(0, 2) + "/" + key + ".json";
}

std::string Store::temporary_name() {
  // Of the process and not of the store: one process may have the same store open twice.
  static std::atomic<uint64_t> count = 0;
  return folder_.native() + "/tmp/" + temporary_prefix_ + std::to_string(++count);
}

/// What is no file where the store has files, and no folder where it has folders, is nobody's: a tool has made it.
void Store::clear_way_to(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  std::error_code ignored;
  if (fs::exists(folder, ignored) && !fs::is_directory(folder, ignored)) ::unlink(folder.c_str());
  ::mkdir(folder.c_str(), 0755);
  if (!fs::is_directory(fs::symlink_status(path, ignored))) return;
  const fs::path away = temporary_name();
  fs::rename(path, away, ignored);
  fs::remove_all(away, ignored);
}

void Store::write(const std::string& path, const void* data, size_t size) {
  const std::string temporary = temporary_name();
  bool made = false;
  const auto give_up = [&](const char* what) {
    const int error = errno;
    if (made) ::unlink(temporary.c_str());
    fail(what + path, error);
  };
  {
    File file(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
    if (file.number < 0) give_up("cannot write ");
    made = true;
    if (!write_all(file.number, data, size)) give_up("cannot write ");
    if (durable_ && fsync(file.number) != 0) give_up("cannot sync ");
    if (file.close() != 0) give_up("cannot write ");  // where a network file system says that it is full
  }
  if (::rename(temporary.c_str(), path.c_str()) != 0) {
    clear_way_to(path);
    if (::rename(temporary.c_str(), path.c_str()) != 0) give_up("cannot write ");
  }
  if (durable_) {
    const File parent(::open(fs::path(path).parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (parent.number >= 0) fsync(parent.number);
  }
}

std::shared_ptr<const Blob::Memory> Store::load(const std::string& path) const {
  const File file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.number < 0) return nullptr;
  struct stat info {};
  if (fstat(file.number, &info) != 0) return nullptr;
  auto memory = std::make_shared<Blob::Memory>();
  memory->size = static_cast<size_t>(info.st_size);
  if (memory->size >= map_from) {
    void* mapped = mmap(nullptr, memory->size, PROT_READ, MAP_PRIVATE, file.number, 0);
    if (mapped != MAP_FAILED) {
      memory->mapped = mapped;
      return memory;
    }
  }
  std::vector<unsigned char> bytes(memory->size);
  if (!read_all(file.number, bytes.data(), bytes.size())) return nullptr;
  memory->kept = read_only_copy(bytes.data(), bytes.size());
  return memory;
}

std::string Store::put(const void* data, size_t size) {
  std::string hash = sha256_of(data, size);
  const std::string path = blob_path(hash);
  {
    const std::scoped_lock lock(mutex_);
    if (checked_.count(hash) && access(path.c_str(), R_OK) == 0) return hash;
  }
  // A damaged blob of the same name must not survive, so what lies there is compared byte by byte.
  const auto present = load(path);
  if (!present || present->size != size || (size > 0 && std::memcmp(present->data(), data, size) != 0))
    write(path, data, size);
  const std::scoped_lock lock(mutex_);
  checked_.insert(hash);
  return hash;
}

std::shared_ptr<const Blob::Memory> Store::held(const std::string& hash) {
  const std::scoped_lock lock(mutex_);
  if (const auto found = held_.find(hash); found != held_.end()) return found->second;
  if (const auto found = open_.find(hash); found != open_.end()) return found->second.lock();
  return nullptr;
}

/// Nothing if there is no such file. Throws StoreError, and removes it, if its content does not match its name.
std::shared_ptr<const Blob::Memory> Store::from_file(const std::string& hash) {
  if (!is_hash(hash)) throw StoreError("'" + hash + "' is no hash of a blob");
  bool checked = false;
  {
    const std::scoped_lock lock(mutex_);
    checked = checked_.count(hash) > 0;
  }
  const std::string path = blob_path(hash);
  auto memory = load(path);
  if (!memory) {
    const std::scoped_lock lock(mutex_);
    checked_.erase(hash);
    return nullptr;
  }
  if (!checked && sha256_of(memory->data(), memory->size) != hash) {
    const bool removed = ::unlink(path.c_str()) == 0;
    throw StoreError("blob " + hash + " in the store " + folder_.string() +
                     " is damaged: its content does not match its name" + (removed ? ". It has been removed" : ""));
  }
  const std::scoped_lock lock(mutex_);
  checked_.insert(hash);
  open_[hash] = memory;
  return memory;
}

void Store::throw_missing(const std::string& hash) const {
  throw StoreError("blob " + hash + " is missing in the store " + folder_.string());
}

Blob Store::get(const std::string& hash) {
  if (auto memory = held(hash)) return Blob(std::move(memory));
  if (auto memory = from_file(hash)) return Blob(std::move(memory));
  auto contents = contents_starting_with(hash);
  if (contents.empty()) throw_missing(hash);
  const std::scoped_lock lock(mutex_);
  return Blob(held_.try_emplace(hash, std::move(contents.begin()->second)).first->second);
}

fs::path Store::new_folder() {
  const fs::path path = temporary_name();
  if (::mkdir(path.c_str(), 0755) != 0) fail("cannot make the folder " + path.string(), errno);
  return path;
}

std::string Store::commit_folder(const fs::path& filled, const std::string& name) {
  const FileHashes::Tree files = file_hashes_->files_of(filled);
  const std::string tree = FileHashes::hash_of(files);
  const fs::path target = folder_path(name.empty() ? tree : name);
  if (durable_) sync();
  for (int attempt = 0; attempt < 8; ++attempt) {
    if (::rename(filled.c_str(), target.c_str()) == 0) {
      file_hashes_->remember_places(target, files);
      return tree;
    }
    if (errno != EEXIST && errno != ENOTEMPTY) fail("cannot make the folder " + target.string(), errno);
    std::error_code ignored;
    try {
      if (file_hashes_->of_tree(target) == tree) {
        fs::remove_all(filled, ignored);
        return tree;
      }
    } catch (const std::exception&) {  // unreadable or just being replaced by another process: treated as damaged
    }
    const fs::path away = temporary_name();
    fs::rename(target, away, ignored);
    fs::remove_all(away, ignored);
  }
  throw StoreError("cannot make the folder " + target.string() + ": another program keeps writing there");
}

fs::path Store::folder_path(const std::string& name) const {
  if (!safe_name(name)) throw StoreError("'" + name + "' is no folder of the store");
  return folder_ / "folders" / name;
}

fs::path Store::resolve(const std::string& uri) const {
  if (FileHashes::names_content(uri)) return file_hashes_->resolve(uri);
  static const std::string scheme = "store:";
  if (uri.compare(0, scheme.size(), scheme) != 0) return uri;
  const fs::path inside = fs::path(uri.substr(scheme.size())).lexically_normal();
  if (inside.empty() || inside.is_absolute() || *inside.begin() == "..") return {};
  return folder_ / "folders" / inside;
}

std::string Store::pipeline_note(const std::string& id) const {
  std::ifstream stream(folder_ / "pipelines" / (id + ".json"));
  std::ostringstream text;
  if (stream) text << stream.rdbuf();
  return text.str();
}

void Store::put_pipeline_note(const std::string& id, const std::string& text) {
  write(folder_ / "pipelines" / (id + ".json"), text.data(), text.size());
}

std::vector<std::string> Store::blobs_starting_with(const std::string& prefix) const {
  std::vector<std::string> found;
  if (prefix.size() < 4 || prefix.find('/') != std::string::npos) return found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder_ / "blobs" / prefix.substr(0, 2), error)) {
    const std::string name = entry.path().filename().string();
    if (name.compare(0, prefix.size(), prefix) == 0) found.push_back(name);
  }
  for (const auto& [hash, memory] : contents_starting_with(prefix)) found.push_back(hash);
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

void Store::sync() const {
  const File file(::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (file.number >= 0 && syncfs(file.number) != 0) fail("cannot sync " + folder_.string(), errno);
}

}  // namespace plumbline::runtime

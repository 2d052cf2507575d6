// What a store holds, and how it gets smaller.
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <tuple>

#include "runtime/base/digest.hpp"
#include "runtime/store/store.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

/// Whether the store could have made a file or folder of this name: a hash, and what may follow it. Nothing else is
/// ever counted or removed.
bool is_named_by_store(const fs::path& path, const std::string& ending) {
  const std::string name = path.filename().string();
  return is_hash(name.substr(0, 64)) && name.substr(64) == ending;
}
bool is_stored_folder(const fs::path& path) {
  const std::string name = path.filename().string();
  return is_hash(name.substr(0, 64)) && (name.size() == 64 || name[64] == '-');
}

struct StoredFile {
  fs::path path;
  std::string kind;
  double age = 0;  // days since it was used
  uint64_t bytes = 0;
  std::set<std::string> blobs, folders;
};

uint64_t size_of_tree(const fs::path& folder) {
  uint64_t bytes = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code ignored;
    if (entry->is_regular_file(ignored)) bytes += entry->file_size(ignored);
  }
  return bytes;
}

/// All results, the last used first. One that cannot be read names nothing.
std::vector<StoredFile> results_in(const fs::path& runs) {
  std::vector<StoredFile> results;
  const auto now = fs::file_time_type::clock::now();
  std::error_code error;
  for (fs::recursive_directory_iterator entry(runs, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code gone;
    if (!entry->is_regular_file(gone) || !is_named_by_store(entry->path(), ".json")) continue;
    StoredFile result;
    result.path = entry->path();
    result.age = std::chrono::duration<double, std::ratio<86400>>(now - entry->last_write_time(gone)).count();
    result.bytes = entry->file_size(gone);
    std::ifstream stream(entry->path());
    std::string line;  // the second one is its check: whatever the first names is kept
    std::getline(stream, line);
    const auto json = nlohmann::json::parse(line, nullptr, false);
    try {
      if (!json.is_discarded()) {
        json.at("kind").get_to(result.kind);
        for (const auto& [port, hashes] : json.at("outputs").items())
          for (const auto& hash : hashes) result.blobs.insert(hash.get<std::string>());
        if (json.contains("used")) result.blobs.insert(json.at("used").get<std::string>());
        if (json.contains("folders"))
          for (const auto& [name, tree] : json.at("folders").items()) result.folders.insert(name);
      }
    } catch (const nlohmann::json::exception&) {
      result.kind.clear();
    }
    if (result.kind.empty()) result.kind = "(damaged)";
    results.push_back(std::move(result));
  }
  std::sort(results.begin(), results.end(),
            [](const StoredFile& a, const StoredFile& b) { return std::tie(a.age, a.path) < std::tie(b.age, b.path); });
  return results;
}

}  // namespace

std::map<std::string, Store::Usage> Store::usage() const {
  std::map<std::string, Usage> all;
  std::set<std::string> counted;
  for (const StoredFile& result : results_in(folder_ / "runs")) {
    Usage& usage = all[result.kind];
    ++usage.runs;
    usage.bytes += result.bytes;
    std::error_code gone;
    for (const std::string& hash : result.blobs)
      if (counted.insert(hash).second)
        if (const auto size = fs::file_size(blob_path(hash), gone); !gone) usage.bytes += size;
    for (const std::string& name : result.folders)
      if (counted.insert(name).second) usage.bytes += size_of_tree(folder_path(name));
  }
  return all;
}

Store::Pruned Store::prune(uint64_t bytes, double days) {
  if (!claims_->have_store_alone())
    throw StoreError("a program uses the store " + folder_.string() + "; prune it when no run is at work");
  Pruned pruned;
  std::set<std::string> kept;
  uint64_t sum = 0;
  bool full = false;
  std::error_code gone;
  const auto remove = [&](const fs::path& path, uint64_t size, size_t& count) {
    if (fs::remove_all(path, gone) == 0 || gone) return;
    ++count;
    pruned.bytes += size;
  };
  for (const StoredFile& result : results_in(folder_ / "runs")) {
    uint64_t more = result.bytes;
    for (const std::string& hash : result.blobs)
      if (!kept.count(hash))
        if (const auto size = fs::file_size(blob_path(hash), gone); !gone) more += size;
    for (const std::string& name : result.folders)
      if (!kept.count(name)) more += size_of_tree(folder_path(name));
    full |= sum + more > bytes;
    if (full || result.age > days || result.kind == "(damaged)") {
      remove(result.path, result.bytes, pruned.runs);
      continue;
    }
    sum += more;
    kept.insert(result.blobs.begin(), result.blobs.end());
    kept.insert(result.folders.begin(), result.folders.end());
  }
  std::vector<fs::path> unnamed;
  for (fs::recursive_directory_iterator entry(folder_ / "blobs", gone), end; !gone && entry != end;
       entry.increment(gone))
    if (std::error_code ignored; entry->is_regular_file(ignored) && is_named_by_store(entry->path(), "") &&
                                 !kept.count(entry->path().filename().string()))
      unnamed.push_back(entry->path());
  for (const fs::path& blob : unnamed) remove(blob, fs::file_size(blob, gone), pruned.blobs);
  unnamed.clear();
  for (fs::directory_iterator entry(folder_ / "folders", gone), end; !gone && entry != end; entry.increment(gone))
    if (is_stored_folder(entry->path()) && !kept.count(entry->path().filename().string()))
      unnamed.push_back(entry->path());
  // What stopped runs would have gone on with: no run is at work.
  for (fs::directory_iterator entry(folder_ / "partial", gone), end; !gone && entry != end; entry.increment(gone))
    unnamed.push_back(entry->path());
  for (const fs::path& folder : unnamed) remove(folder, size_of_tree(folder), pruned.folders);
  const std::scoped_lock lock(mutex_);
  checked_.clear();
  return pruned;
}

}  // namespace plumbline::runtime

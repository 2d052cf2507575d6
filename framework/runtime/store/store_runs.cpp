// The records of runs in the store, and the small outputs that are kept in them.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>

#include "runtime/base/digest.hpp"
#include "runtime/base/json_text.hpp"
#include "runtime/store/blob_memory.hpp"
#include "runtime/store/used_files.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

using Memory = std::shared_ptr<const Blob::Memory>;

/// The time of modification of a result is that of its last use, to the hour: prune() goes by it.
void mark_used(const std::string& file) {
  struct stat info {};
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  if (stat(file.c_str(), &info) == 0 && info.st_mtim.tv_sec + 3600 < now.tv_sec)
    utimensat(AT_FDCWD, file.c_str(), nullptr, 0);
}

std::string hex_of(const Blob::Memory& memory) {
  static constexpr const char* digits = "0123456789abcdef";
  std::string text;
  text.reserve(2 * memory.size);
  const auto* const bytes = static_cast<const unsigned char*>(memory.data());
  for (size_t i = 0; i < memory.size; ++i) {
    text += digits[bytes[i] >> 4];
    text += digits[bytes[i] & 15];
  }
  return text;
}

/// Nothing if the text is no content of that hash.
Memory content_of(const std::string& hex, const std::string& hash) {
  const auto digit = [](char c) { return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1; };
  std::vector<unsigned char> bytes(hex.size() / 2);
  for (size_t i = 0; i < bytes.size(); ++i) {
    const int high = digit(hex[2 * i]), low = digit(hex[2 * i + 1]);
    if (high < 0 || low < 0) return nullptr;
    bytes[i] = static_cast<unsigned char>(16 * high + low);
  }
  if (hex.size() % 2 != 0 || sha256_of(bytes.data(), bytes.size()) != hash) return nullptr;
  return std::make_shared<const Blob::Memory>(bytes.data(), bytes.size());
}

}  // namespace

std::string Store::hold(const void* data, size_t size) {
  if (size > in_memory_up_to_) return put(data, size);
  std::string hash = sha256_of(data, size);
  auto memory = std::make_shared<const Blob::Memory>(data, size);
  const std::scoped_lock lock(mutex_);
  held_.try_emplace(hash, std::move(memory));
  return hash;
}

namespace {

/// Of the record of a run. A program that does not know it passes the record over and computes for itself: what it
/// would not understand may say that the result must not be taken.
constexpr std::uint64_t record_format = 1;

/// The record as it is written: a line, and a second one with the line's SHA-256. Blobs are checked by their names; a
/// metric or a warning is in the record alone.
std::string with_check(std::string line) {
  line += '\n';
  return line + sha256_of(line.data(), line.size()) + '\n';
}

/// The first line. Nothing if it is not what was written.
std::optional<std::string_view> checked_line(std::string_view text) {
  const size_t line = text.find('\n') + 1;
  if (line == 0 || text.size() != line + 65 || text.back() != '\n') return std::nullopt;
  if (text.substr(line, 64) != sha256_of(text.data(), line)) return std::nullopt;
  return text.substr(0, line);
}

/// Programs before the first format wrote a line and no check.
bool is_without_check(std::string_view text) { return text.starts_with("{\"kind\":") && text.ends_with("}\n"); }

}  // namespace

void Store::keep(const StoredRun& run) {
  for (const auto& [port, hashes] : run.outputs)
    for (const std::string& hash : hashes)
      if (const Memory memory = held(hash)) put(memory->data(), memory->size);
}

void Store::put_run(const std::string& key, const StoredRun& run) {
  JsonText json;
  json.open('{').field("format", record_format).field("key", key).field("kind", run.kind).name("outputs").open('{');
  for (const auto& [port, hashes] : run.outputs) json.field(port, hashes);
  json.close('}');
  std::map<std::string, Memory> contents;
  for (const auto& [port, hashes] : run.outputs)
    for (const std::string& hash : hashes)
      if (Memory memory = held(hash); memory && memory->size <= inline_up_to) contents[hash] = std::move(memory);
  if (!contents.empty()) {
    json.name("contents").open('{');
    for (const auto& [hash, memory] : contents) json.field(hash, hex_of(*memory));
    json.close('}');
  }
  if (!run.folders.empty()) {
    json.name("folders").open('{');
    for (const auto& [name, tree] : run.folders) json.field(name, tree);
    json.close('}');
  }
  if (!run.used.empty()) {
    // A blob of its own: many runs have the same list, which may be long.
    std::string list;
    for (const auto& [file, hash] : run.used) list += hash + " " + file + "\n";
    json.field("used", put(list.data(), list.size()));
  }
  if (!run.metrics.empty()) {
    json.name("metrics").open('[');
    for (const Metric& metric : run.metrics)
      json.open('{').field("name", metric.name).field("value", metric.value).field("unit", metric.unit).close('}');
    json.close(']');
  }
  if (!run.warnings.empty()) json.field("warnings", run.warnings);
  if (!run.messages.empty()) json.field("messages", run.messages);
  const Provenance& from = run.provenance;
  if (from.start > 0) {
    json.name("computed").open('{').field("start", from.start).field("host", from.host);
    json.field("threads", static_cast<std::uint64_t>(from.threads)).field("program", from.program);
    json.field("plugin", from.plugin).close('}');
  }
  const std::string text = with_check(json.field("seconds", run.seconds).close('}').take());
  write(run_path(key), text.data(), text.size());
}

namespace {

/// "<hash> <path>", a line each.
std::map<std::string, std::string> used_in(const std::string& list) {
  std::map<std::string, std::string> used;
  std::istringstream lines(list);
  for (std::string line; std::getline(lines, line);)
    if (line.size() > 65) used[line.substr(65)] = line.substr(0, 64);
  return used;
}

/// Throws nlohmann::json::exception, or StoreError for content that does not match its name.
StoredRun run_from(const nlohmann::json& json, std::map<std::string, Memory>& contents) {
  StoredRun run;
  json.at("kind").get_to(run.kind);
  json.at("outputs").get_to(run.outputs);
  if (json.contains("contents"))
    for (const auto& [hash, hex] : json.at("contents").items()) {
      contents[hash] = content_of(hex.get_ref<const std::string&>(), hash);
      if (!contents[hash])
        throw StoreError("blob " + hash + " in its record is damaged: its content does not match its name");
    }
  if (json.contains("folders")) json.at("folders").get_to(run.folders);
  if (json.contains("warnings")) json.at("warnings").get_to(run.warnings);
  if (json.contains("messages")) json.at("messages").get_to(run.messages);
  if (json.contains("metrics"))
    for (const auto& metric : json.at("metrics"))
      run.metrics.push_back({metric.at("name"),
                             metric.at("value").is_null() ? std::nan("") : metric.at("value").get<double>(),
                             metric.at("unit")});
  run.seconds = json.at("seconds");
  if (json.contains("computed")) {
    const auto& from = json.at("computed");
    run.provenance = {from.at("start"), from.at("host"), from.at("threads"), from.at("program"), from.at("plugin")};
  }
  return run;
}

}  // namespace

/// The first that is not what it was; empty if none.
std::string Store::changed_of(const std::map<std::string, std::string>& used) {
  for (const auto& [file, hash] : used) {
    std::error_code failed;
    if (hash == absent_hash) {
      if (fs::exists(fs::symlink_status(file, failed)))
        return file + " is there now, and may be taken in place of what it used";
      continue;
    }
    if (!fs::is_regular_file(file, failed)) return file + ", which it used, is not there any more";
    if (file_hashes_->of_file(file) != hash) return file + ", which it used, has changed";
  }
  return "";
}

std::optional<StoredRun> Store::find_run(const std::string& key, std::string& damage, std::string& outdated) {
  damage.clear();
  outdated.clear();
  const std::string path = run_path(key);
  const auto text = load(path);
  if (!text) return std::nullopt;
  const std::string_view record(static_cast<const char*>(text->data()), text->size);
  const auto line = checked_line(record);
  if (!line) {
    if (!is_without_check(record)) damage = "its record in the store is damaged";
    return std::nullopt;
  }
  StoredRun run;
  try {
    std::map<std::string, Memory> contents;
    const auto json = nlohmann::json::parse(*line);
    if (json.at("format") != record_format) return std::nullopt;
    if (json.at("key") != key) throw StoreError("its record in the store is that of another node");
    run = run_from(json, contents);
    if (json.contains("used")) {
      const Blob blob = get(json.at("used").get<std::string>());
      const plumbline_bytes list = blob.bytes();
      run.used = used_in({static_cast<const char*>(list.data), list.size});
    }
    {
      const std::scoped_lock lock(mutex_);
      held_.merge(contents);
    }
    for (const auto& [port, hashes] : run.outputs)
      for (const std::string& hash : hashes)
        if (!held(hash) && !from_file(hash)) throw_missing(hash);
    for (const auto& [name, tree] : run.folders)
      if (file_hashes_->of_tree(folder_path(name)) != tree)
        throw StoreError("the folder " + folder_path(name).string() + " was changed since it was stored");
  } catch (const nlohmann::json::exception&) {
    damage = "its record in the store is damaged";
    return std::nullopt;
  } catch (const std::exception& error) {
    damage = error.what();
    return std::nullopt;
  }
  outdated = changed_of(run.used);
  if (!outdated.empty()) return std::nullopt;
  mark_used(path);
  return run;
}

/// Contents of all records whose hash starts so: for who has a hash and not the run it came from.
std::map<std::string, Memory> Store::contents_starting_with(const std::string& prefix) const {
  std::map<std::string, Memory> found;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder_ / "runs", error), end; !error && entry != end;
       entry.increment(error)) {
    std::ifstream stream(entry->path());
    std::ostringstream text;
    text << stream.rdbuf();
    if (text.str().find("\"" + prefix) == std::string::npos) continue;
    const auto line = checked_line(text.view());
    const auto json = nlohmann::json::parse(line.value_or(""), nullptr, false);
    if (!json.is_object() || !json.contains("contents") || !json.at("contents").is_object()) continue;
    for (const auto& [hash, hex] : json.at("contents").items())
      if (hash.compare(0, prefix.size(), prefix) == 0 && hex.is_string())
        if (Memory memory = content_of(hex.get<std::string>(), hash)) found[hash] = std::move(memory);
  }
  return found;
}

}  // namespace plumbline::runtime

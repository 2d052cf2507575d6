#include "runtime/deliver.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <set>

#include "artifacts/file.hpp"
#include "artifacts/folder.hpp"
#include "runtime/artifact_type.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

fs::path beside(const fs::path& path) {
  return path.parent_path() / ("." + path.filename().string() + ".tmp-" + std::to_string(getpid()));
}

/// Renames `made` to `target`, whatever lies there.
void put_in_place(const fs::path& made, const fs::path& target) {
  std::error_code error;
  if (fs::is_directory(target) || fs::is_directory(made)) fs::remove_all(target, error);
  fs::rename(made, target, error);
  if (!error) return;
  std::error_code ignored;
  fs::remove_all(made, ignored);
  throw std::runtime_error("cannot write " + target.string() + ": " + error.message());
}

Blob verified(Store& store, const plumbline_type& type, const std::string& hash) {
  Blob blob = store.get(hash);
  if (const std::string problem = verify_artifact(type, blob.bytes()); !problem.empty())
    throw std::runtime_error("blob " + hash + " is no valid " + type.name + ": " + problem);
  return blob;
}

void write_file_artifact(const fs::path& path, const Blob& blob) {
  const auto* file = flatbuffers::GetRoot<File>(blob.bytes().data);
  write_file(path, file->content()->data(), file->content()->size());
}

/// A node chooses the names in a list of files, so they must not lead out of the folder.
void write_file_list(Store& store, const plumbline_type& type, const Hashes& hashes, const fs::path& path) {
  const fs::path making = beside(path);
  fs::remove_all(making);
  fs::create_directories(making);
  std::set<std::string> names;
  for (const std::string& hash : hashes) {
    const Blob blob = verified(store, type, hash);
    const std::string name = flatbuffers::GetRoot<File>(blob.bytes().data)->name()->str();
    if (name.empty() || name[0] == '.' || name.find('/') != std::string::npos || !names.insert(name).second) {
      fs::remove_all(making);
      throw std::runtime_error("a list of files with the name '" + name +
                               "', which is no plain name or is there twice");
    }
    write_file_artifact(making / name, blob);
  }
  put_in_place(making, path);
}

/// True if `path` holds the files of the folder and nothing else, so that gigabytes need not be copied again.
bool holds_already(Store& store, const Folder& folder, const fs::path& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) return false;
  size_t files = 0;
  for (fs::recursive_directory_iterator entry(path, error), end; !error && entry != end; entry.increment(error))
    files += !entry->is_directory(error);
  if (error || files != folder.files()->size()) return false;
  for (const auto* entry : *folder.files()) {
    const fs::path file = path / entry->path()->str();
    if (!fs::is_regular_file(file, error) || store.file_hashes().of_file(file) != entry->sha256()->str()) return false;
  }
  return true;
}

void copy_folder_artifact(Store& store, const Blob& blob, const fs::path& path) {
  const auto* folder = flatbuffers::GetRoot<Folder>(blob.bytes().data);
  const fs::path source = store.resolve(folder->uri()->str()), making = beside(path);
  if (source.empty() || !fs::is_directory(source))
    throw std::runtime_error("the folder " + folder->uri()->str() + " is not there any more");
  if (holds_already(store, *folder, path)) return;
  fs::remove_all(making);
  fs::create_directories(making);
  for (const auto* entry : *folder->files()) {
    const fs::path relative = fs::path(entry->path()->str()).lexically_normal();
    std::error_code error;
    if (relative.empty() || relative.is_absolute() || *relative.begin() == "..")
      error = std::make_error_code(std::errc::invalid_argument);
    if (!error) fs::create_directories((making / relative).parent_path(), error);
    if (!error) fs::copy_file(source / relative, making / relative, error);
    if (error) {
      fs::remove_all(making);
      throw std::runtime_error("cannot copy " + (source / relative).string() + ": " + error.message());
    }
  }
  put_in_place(making, path);
}

void deliver_one(const Graph& graph, const Registry& registry, Store& store, const RunResult& result,
                 const GraphOutput& output, const fs::path& path) {
  const GraphNode& node = graph.nodes[output.from.node];
  const std::string type_name = node.kind.output(output.from.port)->type;
  const plumbline_type* type = registry.type(type_name);
  if (!type) throw std::runtime_error("no plugin brings the type " + type_name);
  const Hashes& hashes = result.nodes[output.from.node].outputs.at(output.from.port);
  const bool list = node.output_is_list.at(output.from.port);
  fs::create_directories(path.parent_path());
  if (type_name == artifact_traits<File>::name) {
    if (list) return write_file_list(store, *type, hashes, path);
    return write_file_artifact(path, verified(store, *type, hashes.at(0)));
  }
  if (type_name == artifact_traits<Folder>::name && !list && path.extension() != ".json")
    return copy_folder_artifact(store, verified(store, *type, hashes.at(0)), path);
  std::string text;
  for (const std::string& hash : hashes) text += (text.empty() ? "" : ",\n") + blob_to_json(store, *type, hash);
  if (list) text = "[\n" + text + "\n]";
  text += "\n";
  write_file(path, text.data(), text.size());
}

}  // namespace

void write_file(const fs::path& path, const void* data, size_t size) {
  const fs::path making = beside(path);
  std::ofstream stream(making, std::ios::binary | std::ios::trunc);
  stream.write(static_cast<const char*>(data), static_cast<std::streamsize>(size));
  stream.close();
  if (!stream) {
    const std::string why = std::strerror(errno);
    std::error_code ignored;
    fs::remove(making, ignored);
    throw std::runtime_error("cannot write " + path.string() + ": " + why);
  }
  put_in_place(making, path);
}

std::string blob_to_json(Store& store, const plumbline_type& type, const std::string& hash) {
  std::string text = artifact_to_json(type, verified(store, type, hash).bytes());
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

std::vector<Delivery> deliver(const Graph& graph, const Registry& registry, Store& store, const RunResult& result,
                              const fs::path& out) {
  std::error_code error;
  fs::create_directories(out, error);
  if (error) throw std::runtime_error("cannot make the output folder " + out.string() + ": " + error.message());
  std::vector<Delivery> deliveries;
  for (const GraphOutput& output : graph.outputs) {
    const NodeResult& source = result.nodes[output.from.node];
    const NodeStatus status = source.status;
    const std::string& name = graph.nodes[output.from.node].name;
    Delivery delivery{output.file, ""};
    try {
      if (status == NodeStatus::executed || status == NodeStatus::reused)
        deliver_one(graph, registry, store, result, output, out / output.file);
      else
        delivery.problem = "'" + name + "' " +
                           (status == NodeStatus::failed    ? "failed"
                            : status == NodeStatus::skipped ? "did not run because '" + source.cause + "' failed"
                                                            : "did not run");
    } catch (const std::exception& failure) {
      delivery.problem = failure.what();
    }
    if (!delivery.problem.empty()) fs::remove_all(out / output.file, error);
    deliveries.push_back(std::move(delivery));
  }
  return deliveries;
}

}  // namespace plumbline::runtime

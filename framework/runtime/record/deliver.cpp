#include "runtime/record/deliver.hpp"

#include <unistd.h>

#include <functional>
#include <set>

#include "artifacts/file.hpp"
#include "artifacts/folder.hpp"
#include "runtime/base/digest.hpp"
#include "runtime/base/new_file.hpp"
#include "runtime/plugins/artifact_type.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

/// Raised when the same artifact is written with other bytes than before.
constexpr const char* delivery_format = "plumbline delivery 1";

Blob verified(Store& store, const plumbline_type& type, const std::string& hash) {
  Blob blob = store.get(hash);
  if (const std::string problem = verify_artifact(type, blob.bytes()); !problem.empty())
    throw std::runtime_error("blob " + hash + " is no valid " + type.name + ": " + problem);
  return blob;
}

struct Delivered {
  std::string type;
  bool list = false, is_tree = false;
};

/// How an output is written depends on its port's type and cardinality, and on its name.
Delivered what_is(const Graph& graph, const GraphOutput& output) {
  const GraphNode& node = graph.nodes[output.from.node];
  Delivered what{node.kind.output(output.from.port)->type, node.output_is_list.at(output.from.port), false};
  what.is_tree =
      (what.type == artifact_traits<File>::name && what.list) ||
      (what.type == artifact_traits<Folder>::name && !what.list && fs::path(output.file).extension() != ".json");
  return what;
}

/// The copy of a file that must still be what it was when it was read.
std::function<void(const fs::path&)> copy_of(Store& store, const fs::path& source, const std::string& sha256) {
  return [&store, source, sha256](const fs::path& target) {
    copy_file_content(source, target);
    if (store.file_hashes().of_file(source) == sha256) return;
    ::unlink(target.c_str());
    throw std::runtime_error(source.string() + " has changed since it was read; run again");
  };
}

/// What a file artifact holds, or what it names, as the file `path`.
TreeFile content_of(Store& store, const Blob& blob, const std::string& path) {
  const auto* file = flatbuffers::GetRoot<File>(blob.bytes().data);
  if (file->uri() && file->uri()->size() > 0) {
    const fs::path source = store.resolve(file->uri()->str());
    if (!fs::is_regular_file(source))
      throw std::runtime_error("the file " + file->uri()->str() + " is not there any more");
    const std::string sha256 = file->sha256() ? file->sha256()->str() : store.file_hashes().of_file(source);
    return {path, sha256, copy_of(store, source, sha256)};
  }
  return {path, sha256_of(file->content()->data(), file->content()->size()), [blob](const fs::path& target) {
            const auto* content = flatbuffers::GetRoot<File>(blob.bytes().data)->content();
            write_new_file(target, content->data(), content->size());
          }};
}

/// A node chooses the names in a list of files, so they must not lead out of the folder.
std::vector<TreeFile> files_of_list(Store& store, const plumbline_type& type, const Hashes& hashes) {
  std::vector<TreeFile> files;
  std::set<std::string> names;
  for (const std::string& hash : hashes) {
    const Blob blob = verified(store, type, hash);
    const std::string name = flatbuffers::GetRoot<File>(blob.bytes().data)->name()->str();
    if (name.empty() || name[0] == '.' || name.find('/') != std::string::npos || !names.insert(name).second)
      throw std::runtime_error("a list of files with the name '" + name +
                               "', which is no plain name or is there twice");
    files.push_back(content_of(store, blob, name));
  }
  return files;
}

/// The files are where the artifact says, and must still be what it says.
std::vector<TreeFile> files_of_folder(Store& store, const Blob& blob) {
  const auto* folder = flatbuffers::GetRoot<Folder>(blob.bytes().data);
  const fs::path source = store.resolve(folder->uri()->str());
  if (source.empty() || !fs::is_directory(source))
    throw std::runtime_error("the folder " + folder->uri()->str() + " is not there any more");
  std::vector<TreeFile> files;
  for (const auto* entry : *folder->files()) {
    const fs::path relative = fs::path(entry->path()->str()).lexically_normal();
    if (relative.empty() || relative.is_absolute() || *relative.begin() == ".." || *relative.begin() == ".")
      throw std::runtime_error("the folder " + source.string() + " lists a file '" + entry->path()->str() +
                               "', which lies outside of it");
    const std::string sha256 = entry->sha256()->str();
    files.push_back({relative.generic_string(), sha256, copy_of(store, source / relative, sha256)});
  }
  return files;
}

/// What the output is made of; equal if it would be written with the same bytes.
std::string identity_of(const plumbline_type& type, const Delivered& what, const Hashes& hashes) {
  Sha256 hash;
  hash.add_field(delivery_format);
  hash.add_field(type.name);
  hash.add_field(sha256_of(type.schema.data, type.schema.size));
  hash.add_field(what.list ? "list" : "one");
  for (const std::string& item : hashes) hash.add_field(item);
  return hash.hex();
}

std::string deliver_one(const Graph& graph, Store& store, const RunResult& result, const GraphOutput& output,
                        OutputFolder& out) {
  const Delivered what = what_is(graph, output);
  // As its own plugin has it: another one may call something else by that name.
  const Kind& kind = graph.nodes[output.from.node].kind;
  const plumbline_type* type = &kind.type_of(*kind.output(output.from.port));
  const Hashes& hashes = result.nodes[output.from.node].outputs.at(output.from.port);
  const std::string made_from = identity_of(*type, what, hashes);
  if (out.holds(output.file, made_from)) return "";
  if (what.is_tree)
    return out.put_tree(
        output.file,
        what.list ? files_of_list(store, *type, hashes) : files_of_folder(store, verified(store, *type, hashes.at(0))),
        made_from);
  if (what.type == artifact_traits<File>::name) {
    out.put_file(content_of(store, verified(store, *type, hashes.at(0)), output.file), made_from);
    return "";
  }
  std::string text;
  for (const std::string& hash : hashes) text += (text.empty() ? "" : ",\n") + blob_to_json(store, *type, hash);
  if (what.list) text = "[\n" + text + "\n]";
  text += "\n";
  out.put_file({output.file, sha256_of(text.data(), text.size()),
                [&](const fs::path& target) { write_new_file(target, text.data(), text.size()); }},
               made_from);
  return "";
}

}  // namespace

std::string blob_to_json(Store& store, const plumbline_type& type, const std::string& hash) {
  std::string text = artifact_to_json(type, verified(store, type, hash).bytes());
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

std::vector<std::string> obstacles_to(const Graph& graph, const OutputFolder& out) {
  std::vector<std::string> all;
  for (const GraphOutput& output : graph.outputs)
    for (std::string& text : out.obstacles(output.file, what_is(graph, output).is_tree)) all.push_back(std::move(text));
  return all;
}

std::vector<Delivery> deliver(const Graph& graph, Store& store, const RunResult& result, OutputFolder& out,
                              const std::atomic<bool>* stop) {
  std::vector<Delivery> deliveries;
  for (const GraphOutput& output : graph.outputs) {
    const NodeResult& source = result.nodes[output.from.node];
    const NodeStatus status = source.status;
    const std::string& name = graph.nodes[output.from.node].name;
    Delivery delivery{output.file, "", ""};
    if (stop && *stop) {
      deliveries.push_back({output.file, "the run was stopped before it was written", ""});
      continue;
    }
    try {
      if (status == NodeStatus::executed || status == NodeStatus::reused)
        delivery.note = deliver_one(graph, store, result, output, out), out.confirm(output.file);
      else
        delivery.problem = "'" + name + "' " +
                           (status == NodeStatus::failed    ? "failed"
                            : status == NodeStatus::skipped ? "did not run because '" + source.cause + "' failed"
                                                            : "did not run");
    } catch (const std::exception& failure) {
      delivery.problem = failure.what();
    }
    if (!delivery.problem.empty()) delivery.problem += out.remove(output.file);
    deliveries.push_back(std::move(delivery));
  }
  out.settle_ownership();
  return deliveries;
}

}  // namespace plumbline::runtime

// plumbline show: an artifact as JSON.
//
// It is named by (the start of) its hash, or by RUN.jsonl:NODE.PORT (NODE@3.PORT of round 3), or as a file of an
// artifact. A blob does not say its type; the run record does, and for a hash or a file every known type is tried: the
// verifier tells which ones it can be.
#include <cstdio>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "runtime/plugins/artifact_type.hpp"
#include "runtime/record/deliver.hpp"

namespace plumbline::cli {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

/// An output in a run record.
struct RecordedOutput {
  std::vector<std::string> hashes;
  std::string kind, port, type;
};

RecordedOutput find_in_record(const std::string& file, const std::string& wanted) {
  std::ifstream stream(file);
  if (!stream) throw UsageError("cannot read the run record " + file);
  std::vector<std::string> names;
  RecordedOutput found;
  for (std::string line; std::getline(stream, line);) {
    const Json json = Json::parse(line, nullptr, false);
    if (!json.is_object() || json.value("event", "") != "node") continue;
    for (const auto& [port, hashes] : json.at("outputs").items()) {
      const auto name = json.at("name").get<std::string>();
      names.push_back(name + "." + port);
      // Of a node that ran in several rounds the last, or the one that is asked for: update@3.points.
      if (names.back() == wanted || name + "@" + std::to_string(json.value("round", 0)) + "." + port == wanted)
        found = {hashes.get<std::vector<std::string>>(), json.value("kind", ""), port, json.at("types").at(port)};
    }
  }
  if (!found.type.empty()) return found;
  const std::string hint = did_you_mean(wanted, names);
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "; it has " : ", ") + name;
  throw UsageError(file + " has no output '" + wanted + "'" + (hint.empty() ? all : hint));
}

void print_of_some_type(const runtime::Registry& registry, plumbline_bytes bytes, const std::string& type) {
  std::vector<const plumbline_type*> candidates;
  std::vector<std::string> names;
  for (const auto& [name, candidate] : registry.types()) {
    names.push_back(name);
    if (type.empty() ? runtime::verify_artifact(*candidate, bytes).empty() : name == type)
      candidates.push_back(candidate);
  }
  if (!type.empty() && candidates.empty())
    throw UsageError("no plugin brings the type '" + type + "'" + did_you_mean(type, names));
  if (candidates.empty()) throw UsageError("this is no artifact of any type the plugins bring");
  if (candidates.size() > 1) {
    std::string all;
    for (const auto* candidate : candidates) all += (all.empty() ? "" : ", ") + std::string(candidate->name);
    throw UsageError("the bytes do not say which type they are; it may be " + all + ": choose with --type");
  }
  if (const std::string problem = runtime::verify_artifact(*candidates[0], bytes); !problem.empty())
    throw std::runtime_error("this is no valid " + std::string(candidates[0]->name) + ": " + problem);
  const std::string text = runtime::artifact_to_json(*candidates[0], bytes);
  std::printf("%s%s", text.c_str(), text.empty() || text.back() != '\n' ? "\n" : "");
}

}  // namespace

int show(const Options& options) {
  if (!options.relative.empty()) return show_relative(options);
  const runtime::Registry registry = discover();
  const size_t colon = options.name.rfind(':');
  if (colon != std::string::npos && fs::is_regular_file(options.name.substr(0, colon))) {
    const auto store = open_store_to_read(options);
    const auto [hashes, kind, port, type_name] =
        find_in_record(options.name.substr(0, colon), options.name.substr(colon + 1));
    const plumbline_type* type = registry.type_of_output(kind, port, type_name);
    if (!type) throw UsageError("no plugin brings the type " + type_name);
    if (hashes.size() != 1) std::printf("[\n");
    for (size_t i = 0; i < hashes.size(); ++i)
      std::printf("%s%s\n", blob_to_json(*store, *type, hashes[i]).c_str(), i + 1 < hashes.size() ? "," : "");
    if (hashes.size() != 1) std::printf("]\n");
    return 0;
  }
  if (fs::is_regular_file(options.name)) {
    std::ifstream stream(options.name, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(stream), {}};
    print_of_some_type(registry, {bytes.data(), bytes.size()}, options.role);
    return 0;
  }
  const auto store = open_store_to_read(options);
  const auto found = store->blobs_starting_with(options.name);
  if (found.empty())
    throw UsageError("'" + options.name + "' is no file, no RUN.jsonl:NODE.PORT, and the store " +
                     store->folder().string() + " has no blob whose hash starts so (at least 4 digits)");
  if (found.size() > 1)
    throw UsageError(std::to_string(found.size()) + " blobs start with '" + options.name + "'; write more digits");
  print_of_some_type(registry, store->get(found[0]).bytes(), options.role);
  return 0;
}

}  // namespace plumbline::cli

#include "runtime/run/key.hpp"

#include <cstdlib>
#include <filesystem>
#include <regex>
#include <set>

#include "runtime/base/digest.hpp"
#include "runtime/plugins/elf.hpp"
#include "runtime/plugins/executable_node.hpp"
#include "runtime/plugins/programs.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

std::string sha256(const std::string& text) { return sha256_of(text.data(), text.size()); }

std::vector<std::string> split_list(const std::string& text) {
  std::vector<std::string> parts;
  for (size_t start = 0; !text.empty();) {
    const size_t end = text.find('\x1f', start);
    parts.push_back(text.substr(start, end == std::string::npos ? end : end - start));
    if (end == std::string::npos) break;
    start = end + 1;
  }
  return parts;
}

/// What a parameter's value adds to the key: for paths what they name, for all others the text.
std::string parameter_field(const plumbline_param& param, const std::string& text, FileHashes& files) {
  if (param.kind != PLUMBLINE_FILE && param.kind != PLUMBLINE_FOLDER) return text;
  if (names_program(param)) return fs::path(text).filename().string() + " " + program_field(text, files);
  std::string field;
  for (const std::string& path : split_list(text)) {
    if (!field.empty()) field += '\x1f';
    if (path.empty()) continue;
    try {
      if (param.kind == PLUMBLINE_FILE)
        field += fs::path(path).filename().string() + " sha256:" + files.of_file(path);
      else
        field += "tree:" + files.of_tree(path);
    } catch (const std::exception& error) {
      throw std::runtime_error("parameter '" + std::string(param.name) + "': " + error.what());
    }
  }
  return field;
}

std::string shortened(std::string text) {
  static const std::regex hash("[0-9a-f]{64}");
  std::string result;
  std::smatch match;
  while (std::regex_search(text, match, hash)) {
    result += match.prefix().str() + match.str().substr(0, 12);
    text = match.suffix().str();
  }
  result += text;
  for (char& c : result)
    if (c == '\x1f') c = ',';
  return result.empty() ? "(empty)" : result;
}

/// What Python's choice of modules depends on beside files. Whether another program looks at it nobody can tell.
void add_environment(KeyFields& fields) {
  for (const char* name : {"PYTHONHOME", "PYTHONNOUSERSITE", "PYTHONPATH", "PYTHONSAFEPATH", "PYTHONUSERBASE"})
    if (const char* value = std::getenv(name); value && *value) fields[std::string("environment ") + name] = value;
}

}  // namespace

KeyFields key_fields(const GraphNode& node, FileHashes& files) {
  KeyFields fields;
  fields["abi"] = std::to_string(PLUMBLINE_ABI_MAJOR);
  fields["kind"] = node.kind.node->kind;
  fields["version"] = std::to_string(node.kind.node->version);
  fields["plugin binary"] = node.kind.plugin->sha256;
  for (const std::string& library : node.kind.plugin->linked_build_ids) {
    if (library.ends_with(kNoPartOfKeys)) continue;
    const size_t colon = library.rfind(':');
    fields["library " + library.substr(0, colon)] = colon == std::string::npos ? "" : library.substr(colon + 1);
  }
  if (node.kind.plugin->executable) add_environment(fields);
  for (uint32_t i = 0; i < node.kind.node->param_count; ++i) {
    const plumbline_param& param = *node.kind.node->params[i];
    const auto value = node.parameters.find(param.name);
    if (value != node.parameters.end())
      fields["parameter " + std::string(param.name)] = parameter_field(param, value->second, files);
  }
  return fields;
}

void add_inputs(KeyFields& fields, const std::map<std::string, Hashes>& inputs) {
  for (const auto& [port, hashes] : inputs) {
    std::string text;
    for (const std::string& hash : hashes) text += (text.empty() ? "" : "\x1f") + hash;
    // One line in the record, whatever the number of items.
    fields["input " + port] = hashes.size() == 1 ? text : std::to_string(hashes.size()) + " items " + sha256(text);
  }
}

std::string key_of(const KeyFields& fields) {
  Sha256 hash;
  hash.add_field("plumbline node 1");
  for (const auto& [name, value] : fields) {
    hash.add_field(name);
    hash.add_field(value);
  }
  return hash.hex();
}

std::string key_with_seed(const std::string& key, uint64_t seed) {
  return sha256(key + " seed " + std::to_string(seed));
}

uint64_t seed_of(uint64_t run_seed, const std::string& node_name, size_t item, size_t round) {
  const std::string hex = sha256("seed " + std::to_string(run_seed) + " " + std::to_string(item) + " " + node_name +
                                 (round > 1 ? "\nround " + std::to_string(round) : ""));
  return std::stoull(hex.substr(0, 16), nullptr, 16);
}

std::vector<std::string> compare(const KeyFields& before, const KeyFields& now) {
  std::set<std::string> names;
  for (const auto& [name, value] : before) names.insert(name);
  for (const auto& [name, value] : now) names.insert(name);
  std::vector<std::string> lines;
  for (const std::string& name : names) {
    const auto old = before.find(name), current = now.find(name);
    if (old == before.end())
      lines.push_back(name + ": new, " + shortened(current->second));
    else if (current == now.end())
      lines.push_back(name + ": no longer there, was " + shortened(old->second));
    else if (old->second != current->second)
      lines.push_back(name + ": " + shortened(old->second) + " -> " + shortened(current->second));
  }
  return lines;
}

Stored look_up(Store& store, const std::string& key, uint64_t seed) {
  Stored found;
  for (const std::string& candidate : {key, key_with_seed(key, seed)}) {
    std::string damage, outdated;
    if (auto run = store.find_run(candidate, damage, outdated)) {
      found.key = candidate;
      found.run = std::move(*run);
      return found;
    }
    if (!damage.empty()) found.damage = damage;
    if (!outdated.empty()) found.outdated = outdated;
  }
  return found;
}

}  // namespace plumbline::runtime

// Reads the manifest of a node that is an executable.
#include <unistd.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <deque>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>
#include <stdexcept>

#include "base/text/one_document.hpp"
#include "runtime/base/near_names.hpp"
#include "runtime/plugins/executable_node.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

constexpr std::uintmax_t largest_manifest = 1 << 20;

[[noreturn]] void flaw(const YAML::Mark& at, const std::string& text) {
  throw std::runtime_error(
      (at.is_null() ? "is no manifest: " : "is wrong at line " + std::to_string(at.line + 1) + ": ") + text);
}
[[noreturn]] void flaw(const YAML::Node& at, const std::string& text) { flaw(at.Mark(), text); }

std::string list_text(const std::vector<std::string>& words) {
  std::string text;
  for (size_t i = 0; i < words.size(); ++i) text += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
  return text;
}

void check_keys(const YAML::Node& map, const std::vector<std::string>& known, const std::string& what) {
  if (!map.IsMap()) flaw(map, what + " is a map, {" + known[0] + ": …}");
  std::set<std::string> seen;
  for (const auto& entry : map) {
    if (!entry.first.IsScalar()) flaw(entry.first, "a name in " + what + " is one word");
    const std::string key = entry.first.Scalar();
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      const auto near = near_names(key, known);
      flaw(entry.first, what + " has no '" + key + "'" +
                            (near.empty() ? "; it has " + list_text(known) : " — did you mean '" + near[0] + "'?"));
    }
    if (!seen.insert(key).second) flaw(entry.first, "'" + key + "' stands twice in " + what);
  }
}

std::string text(const YAML::Node& map, const char* key) {
  const YAML::Node value = map[key];
  if (!value) flaw(map, std::string("'") + key + "' is missing");
  if (!value.IsScalar()) flaw(value, std::string("'") + key + "' is one plain value");
  return value.Scalar();
}

std::string text(const YAML::Node& map, const char* key, const std::string& fallback) {
  return map[key] ? text(map, key) : fallback;
}

bool truth(const YAML::Node& map, const char* key, bool fallback) {
  if (!map[key]) return fallback;
  const std::string word = text(map, key);
  if (word != "true" && word != "false") flaw(map[key], std::string("'") + key + "' is true or false");
  return word == "true";
}

size_t choice(const YAML::Node& map, const char* key, const std::string& fallback,
              const std::vector<std::string>& words) {
  const auto found = std::find(words.begin(), words.end(), text(map, key, fallback));
  if (found == words.end()) flaw(map[key], std::string("'") + key + "' is " + list_text(words));
  return static_cast<size_t>(found - words.begin());
}

std::vector<YAML::Node> items(const YAML::Node& map, const char* key) {
  std::vector<YAML::Node> list;
  if (!map[key]) return list;
  if (!map[key].IsSequence()) flaw(map[key], std::string("'") + key + "' is a list, [a, b]");
  for (const auto& item : map[key]) {
    if (!item.IsScalar()) flaw(item, std::string("an item of '") + key + "' is one plain value");
    list.push_back(item);
  }
  return list;
}

/// Builds a table whose texts live in it, to be copied.
class ManifestReader {
 public:
  ManifestReader(ExecutableNode& node, const std::function<const plumbline_type*(const std::string&)>& type_of)
      : node_(node), type_of_(type_of) {}

  void read() {
    if (fs::file_size(node_.manifest) > largest_manifest) throw std::runtime_error("is larger than any manifest");
    std::ifstream stream(node_.manifest, std::ios::binary);
    if (!stream) throw std::runtime_error(std::string("cannot be read: ") + std::strerror(errno));
    std::ostringstream content;
    content << stream.rdbuf();
    const YAML::Node root = text::load_one_document(content.str());
    check_keys(root,
               {"plumbline_node", "kind", "role", "version", "summary", "licence", "run", "needs", "deterministic",
                "lacks", "seed", "time_limit", "memory_limit", "inputs", "outputs", "parameters"},
               "a manifest");
    if (text(root, "plumbline_node") != "1") flaw(root["plumbline_node"], "a manifest says plumbline_node: 1");
    read_files(root);
    read_limits(root);
    node_.wants_seed = truth(root, "seed", false);
    node_.licence = text(root, "licence", "");
    node_.version = text(root, "version");
    plumbline_node entry{};
    entry.size = sizeof entry;
    const char* end = node_.version.data() + node_.version.size();
    const auto number = std::from_chars(node_.version.data(), end, entry.version);
    if (number.ec != std::errc() || number.ptr != end) flaw(root["version"], "'version' is a whole number");
    entry.kind = keep(text(root, "kind"));
    entry.role = keep(text(root, "role", ""));
    entry.summary = keep(text(root, "summary"));
    entry.lacks = keep(text(root, "lacks", ""));
    entry.deterministic = truth(root, "deterministic", true);
    make_table(entry, read_ports(root, "inputs"), read_ports(root, "outputs"), read_params(root));
  }

 private:
  const char* keep(const std::string& text) { return texts_.emplace_back(text).c_str(); }

  void make_table(plumbline_node& entry, const std::vector<const plumbline_port*>& inputs,
                  const std::vector<const plumbline_port*>& outputs,
                  const std::vector<const plumbline_param*>& params) {
    entry.inputs = inputs.data();
    entry.outputs = outputs.data();
    entry.params = params.data();
    entry.input_count = static_cast<uint32_t>(inputs.size());
    entry.output_count = static_cast<uint32_t>(outputs.size());
    entry.param_count = static_cast<uint32_t>(params.size());
    std::string name = entry.kind;
    std::replace(name.begin(), name.end(), '.', '_');
    const plumbline_node* entries[] = {&entry};
    plumbline_plugin_table table{};
    table.magic = PLUMBLINE_MAGIC;
    table.size = sizeof table;
    table.abi_major = PLUMBLINE_ABI_MAJOR;
    table.abi_minor = PLUMBLINE_ABI_MINOR;
    table.name = name.c_str();
    table.version = node_.version.c_str();
    table.licence = node_.licence.c_str();
    table.build_id = "";
    table.nodes = entries;
    table.node_count = 1;
    table.types = types_.data();
    table.type_count = static_cast<uint32_t>(types_.size());
    node_.table = std::make_unique<PluginTable>(table);
    const auto run = [](const plumbline_host* host, const plumbline_node* node) {
      std::vector<std::string> used;
      return static_cast<const ExecutableNode*>(node->user_data)->run(*host, *node, {}, used);
    };
    node_.table->run_by(run, {&node_});
  }

  /// What the node is started with, and all files that its results depend on.
  void read_files(const YAML::Node& root) {
    const fs::path folder = node_.manifest.parent_path();
    node_.files.push_back(node_.manifest);
    for (const auto& word : items(root, "run")) {
      const fs::path beside = folder / word.Scalar();
      const bool is_file = fs::is_regular_file(beside);
      node_.command.push_back(is_file ? beside.string() : word.Scalar());
      if (is_file) node_.files.push_back(beside);
    }
    if (node_.command.empty())
      flaw(root,
           "'run' says how the node is started, for example [/usr/bin/python3, script.py]; files are relative to "
           "the manifest");
    const fs::path program = node_.command[0];
    if (!program.is_absolute() || !fs::is_regular_file(program) || access(program.c_str(), X_OK) != 0)
      flaw(root["run"], "there is no program '" + program.string() +
                            "'; name it by its whole path or by one relative to the manifest, and make it executable");
    for (const auto& needed : items(root, "needs")) {
      node_.files.push_back(folder / needed.Scalar());
      if (!fs::is_regular_file(node_.files.back())) flaw(needed, "there is no file " + node_.files.back().string());
    }
  }

  void read_limits(const YAML::Node& root) {
    if (root["time_limit"]) {
      const auto seconds = parse_seconds(text(root, "time_limit"));
      if (!seconds) flaw(root["time_limit"], "'time_limit' is a time, such as 90 s or 5 min");
      node_.limits.seconds = *seconds;
    }
    if (root["memory_limit"]) {
      const auto bytes = parse_bytes(text(root, "memory_limit"));
      if (!bytes) flaw(root["memory_limit"], "'memory_limit' is a size of memory, such as 2GiB");
      node_.limits.memory = *bytes;
    }
  }

  /// A map of things that have names.
  static YAML::Node named(const YAML::Node& root, const char* key) {
    const YAML::Node map = root[key];
    if (map && !map.IsMap()) flaw(map, std::string("'") + key + "' is a map, {name: {…}}");
    if (map)
      for (const auto& entry : map)
        if (!entry.first.IsScalar()) flaw(entry.first, "a name is one word");
    return map ? map : YAML::Node(YAML::NodeType::Map);
  }

  std::vector<const plumbline_port*> read_ports(const YAML::Node& root, const char* key) {
    std::vector<const plumbline_port*> list;
    for (const auto& entry : named(root, key)) {
      check_keys(entry.second, {"type", "cardinality", "frames", "doc"}, "a port");
      const std::string type_name = text(entry.second, "type");
      const plumbline_type* type = type_of_(type_name);
      if (!type)
        flaw(entry.second, "no plugin brings the type '" + type_name + "'; plumbline describe KIND shows types");
      if (std::none_of(types_.begin(), types_.end(), [&](const auto* t) { return type_name == t->name; }))
        types_.push_back(type);
      plumbline_port port{};
      port.size = sizeof port;
      port.cardinality =
          static_cast<uint32_t>(choice(entry.second, "cardinality", "one", {"one", "optional", "list", "each"}));
      port.name = keep(entry.first.Scalar());
      port.type = keep(type_name);
      port.fingerprint = type->fingerprint;
      port.frames = keep(text(entry.second, "frames", ""));
      port.doc = keep(text(entry.second, "doc"));
      list.push_back(&ports_.emplace_back(port));
    }
    return list;
  }

  std::vector<const plumbline_param*> read_params(const YAML::Node& root) {
    std::vector<const plumbline_param*> list;
    for (const auto& entry : named(root, "parameters")) {
      const YAML::Node& given = entry.second;
      check_keys(given, {"kind", "list", "default", "unit", "minimum", "maximum", "choices", "doc"}, "a parameter");
      constexpr double infinity = std::numeric_limits<double>::infinity();
      plumbline_param param{};
      param.size = sizeof param;
      param.kind =
          static_cast<uint32_t>(choice(given, "kind", "", {"number", "integer", "boolean", "text", "file", "folder"}));
      param.is_list = truth(given, "list", false);
      param.name = keep(entry.first.Scalar());
      param.default_text = given["default"] ? keep(default_of(given, param.is_list)) : nullptr;
      param.unit = keep(text(given, "unit", ""));
      param.doc = keep(text(given, "doc"));
      param.minimum = bound(given, "minimum", -infinity);
      param.maximum = bound(given, "maximum", infinity);
      auto& choices = choices_.emplace_back();
      for (const auto& item : items(given, "choices")) choices.push_back(keep(item.Scalar()));
      param.choices = choices.data();
      param.choice_count = static_cast<uint32_t>(choices.size());
      list.push_back(&params_.emplace_back(param));
    }
    return list;
  }

  static std::string default_of(const YAML::Node& given, bool is_list) {
    if (!is_list) return text(given, "default");
    std::string joined;
    const auto list = items(given, "default");
    for (size_t i = 0; i < list.size(); ++i) joined += (i ? "\x1f" : "") + list[i].Scalar();
    return joined;
  }

  static double bound(const YAML::Node& given, const char* key, double fallback) {
    double value = fallback;
    if (given[key] && !YAML::convert<double>::decode(given[key], value))
      flaw(given[key], std::string("'") + key + "' is a number");
    return value;
  }

  ExecutableNode& node_;
  const std::function<const plumbline_type*(const std::string&)>& type_of_;
  std::deque<std::string> texts_;
  std::deque<plumbline_port> ports_;
  std::deque<plumbline_param> params_;
  std::deque<std::vector<const char*>> choices_;
  std::vector<const plumbline_type*> types_;
};

}  // namespace

std::unique_ptr<ExecutableNode> read_manifest(const fs::path& manifest,
                                              const std::function<const plumbline_type*(const std::string&)>& type_of) {
  auto node = std::make_unique<ExecutableNode>();
  node->manifest = fs::absolute(manifest);
  try {
    ManifestReader(*node, type_of).read();
  } catch (const YAML::Exception& error) {
    flaw(error.mark, error.msg);
  } catch (const fs::filesystem_error& error) {
    throw std::runtime_error(std::string("cannot be read: ") + error.code().message());
  }
  return node;
}

}  // namespace plumbline::runtime

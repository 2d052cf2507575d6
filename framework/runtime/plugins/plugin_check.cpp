#include "runtime/plugins/plugin_check.hpp"

#include <charconv>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <stdexcept>
#include <string_view>

#include "runtime/base/near_names.hpp"
#include "runtime/plugins/frames.hpp"
#include "runtime/plugins/type_schema.hpp"

namespace plumbline::runtime {

namespace {

/// Thrown within this file only: the first problem ends the check.
struct Flaw : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A name of a megabyte is no reading: of a long text the ends are kept, whole letters of it.
std::string shortened(const std::string& text) {
  constexpr size_t head = 600, tail = 300;
  if (text.size() <= 2 * (head + tail)) return text;
  const auto inside_letter = [&](size_t at) { return (static_cast<unsigned char>(text[at]) & 0xC0) == 0x80; };
  size_t end = head, begin = text.size() - tail;
  for (int i = 0; i < 3 && inside_letter(end); ++i) --end;
  for (int i = 0; i < 3 && inside_letter(begin); ++i) ++begin;
  return text.substr(0, end) + " … " + text.substr(begin);
}

[[noreturn]] void flaw(const std::string& text) { throw Flaw(shortened(text)); }

constexpr uint32_t most_entries = 100000;  // a count beyond is rubbish in memory, not a plugin
constexpr size_t longest_text = 1 << 20;

bool is_utf8(std::string_view text) {
  for (size_t i = 0; i < text.size();) {
    const auto c = static_cast<unsigned char>(text[i]);
    const size_t more = c < 0x80                ? 0
                        : c >= 0xC2 && c < 0xE0 ? 1
                        : (c & 0xF0) == 0xE0    ? 2
                        : c >= 0xF0 && c < 0xF5 ? 3
                                                : 9;
    if (more == 9 || i + more >= text.size()) return false;
    for (size_t k = 1; k <= more; ++k)
      if ((static_cast<unsigned char>(text[i + k]) & 0xC0) != 0x80) return false;
    i += more + 1;
  }
  return true;
}

std::string text(const char* given, const std::string& what) {
  if (!given) flaw("gives a null pointer as " + what + "; give \"\" where there is nothing to say");
  const size_t size = strnlen(given, longest_text);
  if (size == longest_text) flaw("gives a text without end as " + what);
  if (!is_utf8({given, size})) flaw("gives a text that is not UTF-8 as " + what);
  return {given, size};
}

/// A name as pipelines write it: letters, digits and '_'; with dots for a kind.
std::string name(const char* given, const std::string& what, bool dotted = false) {
  const std::string word = text(given, what);
  bool good = !word.empty() && word.back() != '.' && word.front() != '.';
  for (const char c : word) good &= (dotted && c == '.') || c == '_' || std::isalnum(static_cast<unsigned char>(c));
  if (!good)
    flaw("gives '" + word + "' as " + what + "; a name has letters, digits and '_'" +
         (dotted ? ", and dots between its parts" : ""));
  return word;
}

void size_of(uint32_t given, size_t expected, const std::string& what) {
  if (given < expected)
    flaw("says that the struct of " + what + " has " + std::to_string(given) + " bytes, in this ABI it has " +
         std::to_string(expected) + "; set `size` to its sizeof, and rebuild the plugin against this host's plugin.h");
}

/// The entries of an array of pointers, none of them null.
template <typename Entry>
std::vector<const Entry*> entries(const Entry* const* array, uint32_t count, const std::string& what,
                                  size_t least = sizeof(Entry)) {
  if (count > most_entries) flaw("says it has " + std::to_string(count) + " " + what);
  if (count && !array) flaw("gives a null pointer in place of its " + std::to_string(count) + " " + what);
  std::vector<const Entry*> list(array, array + count);
  for (size_t i = 0; i < list.size(); ++i) {
    if (!list[i]) flaw("gives a null pointer as number " + std::to_string(i + 1) + " of its " + what);
    size_of(list[i]->size, least, "number " + std::to_string(i + 1) + " of its " + what);
  }
  return list;
}

std::string of_node(const std::string& what, const std::string& kind) { return what + " of '" + kind + "'"; }

class Checker {
 public:
  Checker(const plumbline_plugin_table& table, const Roles& roles) : table_(table), roles_(roles) {}

  void check() {
    size_of(table_.size, sizeof table_, "the table");
    name(table_.name, "the plugin's name");
    text(table_.version, "the plugin's version");
    text(table_.licence, "the plugin's licence");
    text(table_.build_id, "the plugin's build id");
    for (const plumbline_type* type : entries(table_.types, table_.type_count, "types")) check_type(*type);
    // Members that came with a minor version may be missing from plugins that are older.
    const size_t node_size = table_.abi_minor >= 1 ? sizeof(plumbline_node) : offsetof(plumbline_node, lacks);
    std::set<std::string> kinds;
    for (const plumbline_node* node : entries(table_.nodes, table_.node_count, "nodes", node_size)) {
      const std::string kind = name(node->kind, "the kind of a node", true);
      if (!kinds.insert(kind).second) flaw("offers the node '" + kind + "' twice; rename one of them");
      check_node(*node, kind);
    }
  }

 private:
  void check_type(const plumbline_type& type) {
    const std::string known = text(type.name, "the name of a type");
    const std::string fingerprint = text(type.fingerprint, "the fingerprint of " + known);
    const auto [earlier, fresh] = types_.emplace(known, &type);
    if (!fresh && fingerprint != earlier->second->fingerprint)
      flaw("brings the type " + known + " twice, not the same");
    if (const std::string problem = check_schema(type); !problem.empty())
      flaw("brings the type " + known + ", which " + problem);
  }

  void check_node(const plumbline_node& node, const std::string& kind) {
    text(node.summary, of_node("the summary", kind));
    text(node.role, of_node("the role", kind));
    if (node.size >= sizeof node && node.lacks) text(node.lacks, of_node("what it lacks", kind));
    if (!node.run) flaw("gives a null pointer as " + of_node("run()", kind));
    if (node.deterministic > 1) flaw("says neither 0 nor 1 for " + of_node("`deterministic`", kind));
    const auto inputs = entries(node.inputs, node.input_count, of_node("inputs", kind));
    const auto outputs = entries(node.outputs, node.output_count, of_node("outputs", kind));
    check_ports(inputs, "input", kind, PLUMBLINE_EACH);
    check_ports(outputs, "output", kind, PLUMBLINE_LIST);
    size_t each = 0;
    for (const plumbline_port* port : inputs) each += port->cardinality == PLUMBLINE_EACH;
    if (each > 1)
      flaw("declares " + std::to_string(each) + " inputs of '" + kind +
           "' of which it runs once for each item; one may be");
    std::set<std::string> names;
    for (const plumbline_param* param : entries(node.params, node.param_count, of_node("parameters", kind))) {
      const std::string known = name(param->name, of_node("the name of a parameter", kind));
      if (!names.insert(known).second)
        flaw("declares " + of_node("the parameter '" + known + "'", kind) + " twice; rename one of them");
      check_param(*param, of_node("parameter '" + known + "'", kind));
    }
    if (const std::string problem = roles_.problem_of(node); !problem.empty()) flaw(problem);
  }

  void check_ports(const std::vector<const plumbline_port*>& ports, const std::string& what, const std::string& kind,
                   uint32_t last_cardinality) {
    std::set<std::string> names;
    for (const plumbline_port* port : ports) {
      const std::string known = name(port->name, of_node("the name of an " + what, kind));
      const std::string where = of_node(what + " '" + known + "'", kind);
      if (!names.insert(known).second) flaw("declares " + where + " twice; rename one of them");
      text(port->doc, "the doc of " + where);
      if (port->cardinality > last_cardinality ||
          (last_cardinality == PLUMBLINE_LIST && port->cardinality == PLUMBLINE_OPTIONAL))
        flaw("declares " + where + " with the cardinality " + std::to_string(port->cardinality) +
             "; an input is one, optional, list or each, an output one or list");
      const auto type = types_.find(text(port->type, "the type of " + where));
      if (type == types_.end())
        flaw("declares " + where + " of the type " + port->type +
             ", which it does not bring; add it to the table's types");
      if (text(port->fingerprint, "the fingerprint of " + where) != type->second->fingerprint)
        flaw("declares " + where + " with the fingerprint " + port->fingerprint + ", but brings " + port->type +
             " with " + type->second->fingerprint + "; build all its sources from the same schemas");
      check_frames(text(port->frames, "the frames of " + where), *type->second, where);
    }
  }

  static void check_frames(const std::string& frames, const plumbline_type& type, const std::string& where) {
    const std::set<std::string> known = frame_parameters(type);
    std::string list;
    for (const std::string& frame : known) list += (list.empty() ? "" : ", ") + frame;
    for (const auto& [key, value] : split_frames(frames)) {
      if (!known.count(key)) {
        const auto near = near_names(key, {known.begin(), known.end()});
        flaw("binds the frame parameter '" + key + "' of " + where + ", which " + type.name + " does not have" +
             (near.empty() ? (known.empty() ? "; it has none" : "; it has: " + list)
                           : " — did you mean '" + near[0] + "'?"));
      }
      if (value.empty() || value == "?" || value.find_first_of(" \t=?", 1) != std::string::npos)
        flaw("binds the frame parameter '" + key + "' of " + where + " to '" + value +
             "'; write key=name or key=?Variable, separated by commas");
    }
  }

  static void check_param(const plumbline_param& param, const std::string& where) {
    text(param.unit, "the unit of " + where);
    text(param.doc, "the doc of " + where);
    if (param.kind > PLUMBLINE_FOLDER)
      flaw("declares " + where + " of the kind " + std::to_string(param.kind) + ", which this host does not know");
    if (param.is_list > 1) flaw("says neither 0 nor 1 for `is_list` of " + where);
    if (!(param.minimum <= param.maximum))
      flaw("declares " + where +
           " with bounds that nothing is between; give -INFINITY and INFINITY where there are none");
    if (param.choice_count > most_entries || (param.choice_count && !param.choices))
      flaw("gives a null pointer in place of the choices of " + where);
    std::set<std::string> choices;
    for (uint32_t i = 0; i < param.choice_count; ++i)
      if (!choices.insert(text(param.choices[i], "a choice of " + where)).second)
        flaw("gives the choice '" + std::string(param.choices[i]) + "' of " + where + " twice");
    if (param.choice_count && param.kind != PLUMBLINE_TEXT)
      flaw("declares choices for " + where + ", which is no text");
    if (!param.default_text) return;
    const std::string given = text(param.default_text, "the default of " + where);
    if (param.is_list && given.empty()) return;
    for (size_t at = 0; at <= given.size();) {
      const size_t end = param.is_list ? std::min(given.find('\x1f', at), given.size()) : given.size();
      check_default(param, given.substr(at, end - at), choices, where);
      at = end + 1;
    }
  }

  static void check_default(const plumbline_param& param, const std::string& value,
                            const std::set<std::string>& choices, const std::string& where) {
    const auto refuse = [&](const std::string& expected) {
      flaw("has the default '" + value + "' for " + where + ", which is not " + expected +
           "; a pipeline could not even write it");
    };
    const char* end = value.data() + value.size();
    if (param.kind == PLUMBLINE_NUMBER) {
      double number = 0;
      if (value == "nan") return;  // "not given", as a declaration alone can say it
      if (const auto read = std::from_chars(value.data(), end, number); read.ec != std::errc() || read.ptr != end)
        refuse("a number");
      if (!(number >= param.minimum && number <= param.maximum)) refuse("within its bounds");
    } else if (param.kind == PLUMBLINE_INTEGER) {
      int64_t number = 0;
      if (const auto read = std::from_chars(value.data(), end, number); read.ec != std::errc() || read.ptr != end)
        refuse("a whole number");
      if (!(static_cast<double>(number) >= param.minimum && static_cast<double>(number) <= param.maximum))
        refuse("within its bounds");
    } else if (param.kind == PLUMBLINE_BOOLEAN) {
      if (value != "true" && value != "false") refuse("true or false");
    } else if (!choices.empty() && !choices.count(value)) {
      refuse("one of its choices");
    }
  }

  const plumbline_plugin_table& table_;
  const Roles& roles_;
  std::map<std::string, const plumbline_type*> types_;
};

}  // namespace

std::string abi_problem(uint32_t major, uint32_t minor) {
  const std::string host = std::to_string(PLUMBLINE_ABI_MAJOR) + "." + std::to_string(PLUMBLINE_ABI_MINOR);
  const std::string plugin = std::to_string(major) + "." + std::to_string(minor);
  if (major != PLUMBLINE_ABI_MAJOR)
    return "is built for plugin ABI " + plugin + ", this host has " + host +
           "; rebuild the plugin against this host's plugin.h";
  if (minor > PLUMBLINE_ABI_MINOR)
    return "needs plugin ABI " + plugin + ", this host has only " + host + "; update plumbline or rebuild the plugin";
  return "";
}

std::string check_table(const plumbline_plugin_table* table, const Roles& roles) {
  if (!table) return "returns no table from plumbline_plugin()";
  if (table->magic != PLUMBLINE_MAGIC)
    return "returns a table without Plumbline's magic number; use PLUMBLINE_PLUGIN() of node.hpp";
  if (const std::string problem = abi_problem(table->abi_major, table->abi_minor); !problem.empty()) return problem;
  try {
    Checker(*table, roles).check();
    return "";
  } catch (const Flaw& found) {
    return found.what();
  }
}

const plumbline_type* type_of_port(const plumbline_plugin_table& table, const plumbline_port& port) {
  for (uint32_t i = 0; i < table.type_count; ++i)
    if (std::string_view(table.types[i]->name) == port.type) return table.types[i];
  return nullptr;
}

}  // namespace plumbline::runtime

#include "runtime/plugins/roles.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "base/text/one_document.hpp"
#include "builtin_roles.hpp"
#include "runtime/base/near_names.hpp"
#include "runtime/plugins/frames.hpp"

namespace plumbline::runtime {

namespace {

constexpr const char* cardinalities[] = {"one", "optional", "list", "each"};

std::string text_of(const YAML::Node& map, const char* key, const std::string& fallback) {
  const YAML::Node value = map[key];
  return value && value.IsScalar() ? value.Scalar() : fallback;
}

std::vector<RolePort> read_ports(const YAML::Node& map, const std::string& where) {
  std::vector<RolePort> ports;
  for (const auto& entry : map) {
    RolePort port;
    port.name = entry.first.as<std::string>();
    port.type = text_of(entry.second, "type", "");
    port.frames = text_of(entry.second, "frames", "");
    port.doc = text_of(entry.second, "doc", "");
    const std::string may_lack = text_of(entry.second, "may_lack", "false");
    if (may_lack != "true" && may_lack != "false")
      throw std::runtime_error(where + ": port '" + port.name + "' has may_lack: " + may_lack +
                               "; it is true or false");
    port.may_lack = may_lack == "true";
    const std::string cardinality = text_of(entry.second, "cardinality", "one");
    while (port.cardinality < 4 && cardinality != cardinalities[port.cardinality]) ++port.cardinality;
    if (port.type.empty()) throw std::runtime_error(where + ": port '" + port.name + "' has no type");
    if (port.cardinality == 4)
      throw std::runtime_error(where + ": port '" + port.name + "' has the cardinality '" + cardinality +
                               "'; it is one, optional, list or each");
    ports.push_back(port);
  }
  return ports;
}

std::vector<RoleMeasure> read_measures(const YAML::Node& map, const std::string& where) {
  std::vector<RoleMeasure> measures;
  for (const auto& entry : map) {
    RoleMeasure measure;
    measure.quantity = entry.first.as<std::string>();
    measure.use = text_of(entry.second, "use", "");
    measure.metric = text_of(entry.second, "metric", "");
    for (const auto& port : entry.second["in"]) {
      const auto from = port.second.as<std::string>();
      if (from.rfind("in.", 0) != 0 && from.rfind("out.", 0) != 0)
        throw std::runtime_error(where + ": measure '" + measure.quantity + "' takes '" + from +
                                 "'; it takes in.PORT or out.PORT of the node that is judged");
      measure.inputs[port.first.as<std::string>()] = from;
    }
    for (const auto& parameter : entry.second["with"])
      measure.parameters[parameter.first.as<std::string>()] = parameter.second.as<std::string>();
    if (measure.use.empty() || measure.metric.empty())
      throw std::runtime_error(where + ": measure '" + measure.quantity +
                               "' is {use: KIND, metric: NAME, in: {…}, with: {…}}");
    measures.push_back(measure);
  }
  return measures;
}

bool same_ports(const std::vector<RolePort>& a, const std::vector<RolePort>& b) {
  if (a.size() != b.size()) return false;
  for (size_t i = 0; i < a.size(); ++i)
    if (a[i].name != b[i].name || a[i].type != b[i].type || a[i].frames != b[i].frames ||
        a[i].cardinality != b[i].cardinality || a[i].may_lack != b[i].may_lack)
      return false;
  return true;
}

/// Compares the ports of one node with those of its role; variables are matched in the order in which they are met.
class Comparison {
 public:
  Comparison(const Role& role, const plumbline_node& node) : role_(role), node_(node) {}

  std::string problem() {
    std::string text = compare(role_.inputs, node_.inputs, node_.input_count, "input");
    if (text.empty()) text = compare(role_.outputs, node_.outputs, node_.output_count, "output");
    if (text.empty()) return "";
    return "offers the node '" + std::string(node_.kind) + "' in the role '" + role_.name + "', but " + text +
           "; give it the ports of the role, or no role";
  }

 private:
  std::string compare(const std::vector<RolePort>& wanted, const plumbline_port* const* ports, uint32_t count,
                      const std::string& what) {
    for (const RolePort& port : wanted) {
      const plumbline_port* found = nullptr;
      for (uint32_t i = 0; i < count; ++i)
        if (port.name == ports[i]->name) found = ports[i];
      if (!found && port.may_lack) continue;
      if (!found)
        return "it has no " + what + " '" + port.name + "' (" + port.type + ", " + cardinalities[port.cardinality] +
               ")";
      const std::string where = "its " + what + " '" + port.name + "' ";
      if (port.type != found->type)
        return where + "is of the type " + found->type + ", that of the role of " + port.type;
      if (port.cardinality != found->cardinality)
        return where + "takes " + cardinality_text(found->cardinality) + ", that of the role " +
               cardinality_text(port.cardinality);
      if (!frames_agree(port.frames, found->frames))
        return where + "has the frames '" + found->frames + "', that of the role '" + port.frames + "'";
    }
    for (uint32_t i = 0; i < count; ++i) {
      bool known = false;
      for (const RolePort& port : wanted) known |= port.name == ports[i]->name;
      known |= what == "input" && ports[i]->cardinality == PLUMBLINE_OPTIONAL;  // it can stand in without it
      if (!known) return "the role has no " + what + " '" + ports[i]->name + "'";
    }
    return "";
  }

  bool frames_agree(const std::string& wanted, const std::string& found) {
    const auto a = split_frames(wanted), b = split_frames(found);
    if (a.size() != b.size()) return false;
    for (const auto& [key, value] : a) {
      const std::string* other = nullptr;
      for (const auto& [other_key, other_value] : b)
        if (other_key == key) other = &other_value;
      if (!other || is_frame_variable(value) != is_frame_variable(*other)) return false;
      if (!is_frame_variable(value)) {
        if (value != *other) return false;
        continue;
      }
      if (names_.emplace(value, *other).first->second != *other) return false;
      if (back_.emplace(*other, value).first->second != value) return false;
    }
    return true;
  }

  const Role& role_;
  const plumbline_node& node_;
  std::map<std::string, std::string> names_, back_;  // variables of the role -> those of the node, and back
};

}  // namespace

const char* cardinality_text(uint32_t cardinality) { return cardinality < 4 ? cardinalities[cardinality] : "?"; }

Roles Roles::builtin() {
  Roles roles;
  for (const BuiltinRole& role : kBuiltinRoles) roles.add(role.yaml, std::string("schemas/roles/") + role.name);
  return roles;
}

void Roles::add(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error("cannot be read");
  std::ostringstream content;
  content << stream.rdbuf();
  add(content.str(), file.filename().string());
}

void Roles::add(const std::string& yaml, const std::string& where) {
  Role role;
  try {
    const YAML::Node document = text::load_one_document(yaml);
    if (!document.IsMap()) throw std::runtime_error(where + ": a role is a map of role, doc, inputs, outputs");
    for (const auto& entry : document) {
      const auto key = entry.first.as<std::string>();
      if (key != "role" && key != "doc" && key != "inputs" && key != "outputs" && key != "measures")
        throw std::runtime_error(where + ": a role has no '" + key + "'; it has role, doc, inputs, outputs, measures");
    }
    role.name = text_of(document, "role", "");
    role.doc = text_of(document, "doc", "");
    if (role.name.empty()) throw std::runtime_error(where + ": says no name: role: NAME");
    role.inputs = read_ports(document["inputs"], where);
    role.outputs = read_ports(document["outputs"], where);
    role.measures = read_measures(document["measures"], where);
  } catch (const YAML::Exception& error) {
    throw std::runtime_error(where + ": " + error.what());
  }
  const auto [earlier, fresh] = roles_.emplace(role.name, role);
  if (!fresh && !(same_ports(role.inputs, earlier->second.inputs) && same_ports(role.outputs, earlier->second.outputs)))
    throw std::runtime_error(where + ": the role '" + role.name + "' is declared already, with other ports; rename it");
}

bool Roles::may_lack(const plumbline_node& node, const std::string& input) const {
  const auto role = roles_.find(node.role ? node.role : "");
  return role != roles_.end() && std::any_of(role->second.inputs.begin(), role->second.inputs.end(),
                                             [&](const RolePort& port) { return port.name == input && port.may_lack; });
}

std::string Roles::problem_of(const plumbline_node& node) const {
  if (!node.role) return std::string("gives a null pointer as the role of '") + node.kind + "'; give \"\" for none";
  if (!*node.role) return "";
  const auto found = roles_.find(node.role);
  if (found != roles_.end()) return Comparison(found->second, node).problem();
  std::vector<std::string> names;
  for (const auto& [name, role] : roles_) names.push_back(name);
  const auto near = near_names(node.role, names);
  return std::string("offers the node '") + node.kind + "' in the role '" + node.role + "', which is declared nowhere" +
         (near.empty()
              ? "; a role of your own is declared in roles/" + std::string(node.role) + ".yaml beside the library"
              : " — did you mean '" + near[0] + "'?");
}

}  // namespace plumbline::runtime

#include "runtime/plugins/plugin_table.hpp"

#include <tuple>
#include <utility>

#include "runtime/base/wire.hpp"

namespace plumbline::runtime {

namespace {

void write_ports(WireWriter& out, const plumbline_port* const* ports, uint32_t count) {
  out.number(count);
  for (uint32_t i = 0; i < count; ++i) {
    out.number(ports[i]->cardinality);
    for (const char* text : {ports[i]->name, ports[i]->type, ports[i]->fingerprint, ports[i]->frames, ports[i]->doc})
      out.text(text);
  }
}

void write_node(WireWriter& out, const plumbline_node& node) {
  out.number(node.version);
  out.number(node.deterministic);
  for (const char* text : {node.kind, node.role, node.summary}) out.text(text);
  const bool says_it = node.size >= sizeof(plumbline_node);  // ABI 2.0 had no such member
  out.text(says_it && node.lacks ? node.lacks : "");
  write_ports(out, node.inputs, node.input_count);
  write_ports(out, node.outputs, node.output_count);
  out.number(node.param_count);
  for (uint32_t i = 0; i < node.param_count; ++i) {
    const plumbline_param& param = *node.params[i];
    out.number(param.kind);
    out.number(param.is_list);
    out.number(param.minimum);
    out.number(param.maximum);
    for (const char* text : {param.name, param.default_text, param.unit, param.doc}) out.text(text);
    out.number(param.choice_count);
    for (uint32_t k = 0; k < param.choice_count; ++k) out.text(param.choices[k]);
  }
}

}  // namespace

namespace {

int run_nothing(const plumbline_host* host, const plumbline_node*) {
  host->fail(host->context, "this is only the description of a node");
  return 1;
}

}  // namespace

class PluginTable::Parser {
 public:
  Parser(const std::string& bytes, PluginTable& into) : in_(bytes), to_(into) {}

  void parse() {
    plumbline_plugin_table& table = to_.table_;
    table.magic = PLUMBLINE_MAGIC;
    table.size = sizeof table;
    table.abi_major = in_.number<uint32_t>();
    table.abi_minor = in_.number<uint32_t>();
    for (const char** text : {&table.name, &table.version, &table.licence, &table.build_id}) *text = this->text();
    table.type_count = in_.count();
    for (uint32_t i = 0; i < table.type_count; ++i) to_.type_list_.push_back(type());
    table.node_count = in_.count();
    for (uint32_t i = 0; i < table.node_count; ++i) to_.node_list_.push_back(node());
    in_.end();
    table.types = to_.type_list_.data();
    table.nodes = to_.node_list_.data();
  }

 private:
  const char* text() { return in_.there() ? to_.texts_.emplace_back(in_.bytes()).c_str() : nullptr; }

  const plumbline_type* type() {
    plumbline_type type{};
    type.size = sizeof type;
    type.name = text();
    type.fingerprint = text();
    const std::string& schema = to_.texts_.emplace_back(in_.bytes());
    type.schema = {schema.data(), schema.size()};
    return &to_.types_.emplace_back(type);
  }

  std::pair<const plumbline_port* const*, uint32_t> ports() {
    const uint32_t count = in_.count();
    auto& list = to_.port_lists_.emplace_back();
    for (uint32_t i = 0; i < count; ++i) {
      plumbline_port port{};
      port.size = sizeof port;
      port.cardinality = in_.number<uint32_t>();
      for (const char** text : {&port.name, &port.type, &port.fingerprint, &port.frames, &port.doc})
        *text = this->text();
      list.push_back(&to_.ports_.emplace_back(port));
    }
    return {list.data(), count};
  }

  const plumbline_node* node() {
    plumbline_node node{};
    node.size = sizeof node;
    node.version = in_.number<uint32_t>();
    node.deterministic = in_.number<uint32_t>();
    for (const char** text : {&node.kind, &node.role, &node.summary, &node.lacks}) *text = this->text();
    std::tie(node.inputs, node.input_count) = ports();
    std::tie(node.outputs, node.output_count) = ports();
    node.param_count = in_.count();
    auto& list = to_.param_lists_.emplace_back();
    for (uint32_t i = 0; i < node.param_count; ++i) list.push_back(param());
    node.params = list.data();
    node.run = &run_nothing;
    return &to_.nodes_.emplace_back(node);
  }

  const plumbline_param* param() {
    plumbline_param param{};
    param.size = sizeof param;
    param.kind = in_.number<uint32_t>();
    param.is_list = in_.number<uint32_t>();
    param.minimum = in_.number<double>();
    param.maximum = in_.number<double>();
    for (const char** text : {&param.name, &param.default_text, &param.unit, &param.doc}) *text = this->text();
    param.choice_count = in_.count();
    auto& choices = to_.choice_lists_.emplace_back();
    for (uint32_t k = 0; k < param.choice_count; ++k) choices.push_back(text());
    param.choices = choices.data();
    return &to_.params_.emplace_back(param);
  }

  WireReader in_;
  PluginTable& to_;
};

PluginTable::PluginTable(const plumbline_plugin_table& table) : PluginTable(serialise(table)) {}

PluginTable::PluginTable(const std::string& bytes) { Parser(bytes, *this).parse(); }

void PluginTable::run_by(int (*run)(const plumbline_host*, const plumbline_node*),
                         const std::vector<void*>& user_data) {
  for (size_t i = 0; i < nodes_.size(); ++i) {
    nodes_[i].run = run;
    nodes_[i].user_data = user_data.at(i);
  }
}

std::string serialise(const plumbline_plugin_table& table) {
  WireWriter out;
  out.number(table.abi_major);
  out.number(table.abi_minor);
  for (const char* text : {table.name, table.version, table.licence, table.build_id}) out.text(text);
  out.number(table.type_count);
  for (uint32_t i = 0; i < table.type_count; ++i) {
    out.text(table.types[i]->name);
    out.text(table.types[i]->fingerprint);
    out.bytes(table.types[i]->schema.data, table.types[i]->schema.size);
  }
  out.number(table.node_count);
  for (uint32_t i = 0; i < table.node_count; ++i) write_node(out, *table.nodes[i]);
  return out.take();
}

}  // namespace plumbline::runtime

// A plugin's table that is wrong somewhere: a copy of a sound one whose every member can be changed.
#pragma once

#include <deque>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "plumbline/plugin.h"

namespace plumbline::test {

using Random = std::mt19937_64;

inline size_t below(Random& random, size_t limit) { return static_cast<size_t>(random() % limit); }

class RandomTable {
 public:
  RandomTable(const plumbline_plugin_table& sound, Random& random) : random_(random), table_(sound) {
    for (uint32_t i = 0; i < sound.type_count; ++i) type_list_.push_back(&types_.emplace_back(*sound.types[i]));
    for (uint32_t i = 0; i < sound.node_count; ++i) {
      plumbline_node& node = nodes_.emplace_back(*sound.nodes[i]);
      node_list_.push_back(&node);
      copy_ports(node.inputs, node.input_count);
      copy_ports(node.outputs, node.output_count);
      auto& list = param_lists_.emplace_back();
      for (uint32_t k = 0; k < node.param_count; ++k) list.push_back(&params_.emplace_back(*node.params[k]));
      node.params = list.data();
    }
    relink();
  }

  const plumbline_plugin_table& table() const { return table_; }

  /// Changes one thing. Addresses stay sound or null: a wild one ends the process, which is why a host looks at a
  /// library in a child.
  void change() {
    switch (below(random_, 9)) {
      case 0:
        return change_table();
      case 1:
        return change(types_);
      case 2:
      case 3:
        return change(nodes_);
      case 4:
      case 5:
        return change(ports_);
      case 6:
      case 7:
        return change(params_);
      default:
        return change_lists();
    }
  }

 private:
  void copy_ports(const plumbline_port* const*& ports, uint32_t count) {
    auto& list = port_lists_.emplace_back();
    for (uint32_t i = 0; i < count; ++i) list.push_back(&ports_.emplace_back(*ports[i]));
    ports = list.data();
  }
  void relink() {
    table_.types = type_list_.data();
    table_.nodes = node_list_.data();
  }

  const char* text() {
    static const std::string long_text(2000, 'x'), endless((1 << 20) + 1, 'x');
    static const std::vector<const char*> texts = {nullptr,
                                                   "",
                                                   "a",
                                                   "number",
                                                   "story.add",
                                                   "story.",
                                                   ".a",
                                                   "a b",
                                                   "a/b",
                                                   "\xff\xfe",
                                                   "ä",
                                                   "\xf4\x90\x80\x80",
                                                   "nan",
                                                   "inf",
                                                   "-1",
                                                   "1e999",
                                                   "99999999999999999999",
                                                   "true",
                                                   "1\x1f"
                                                   "2",
                                                   "\x1f",
                                                   "source",
                                                   "detector",
                                                   "adjuster",
                                                   "plumbline.Number/1",
                                                   "plumbline.Folder/1",
                                                   "frame=?S",
                                                   "frame=",
                                                   "=",
                                                   ",,",
                                                   "frame=?,frame=?S",
                                                   "to=?T,from=?T",
                                                   "00000000",
                                                   "m",
                                                   long_text.c_str(),
                                                   endless.c_str()};
    if (below(random_, 3) > 0) return texts[below(random_, texts.size() - (below(random_, 50) ? 1 : 0))];
    std::string random;
    for (size_t i = below(random_, 12); i > 0; --i) random += static_cast<char>(1 + below(random_, 255));
    return texts_.emplace_back(random).c_str();
  }
  uint32_t number() {
    static const uint32_t numbers[] = {0, 1, 2, 3, 4, 5, 6, 8, 255, 1u << 16, 1u << 31, UINT32_MAX};
    return numbers[below(random_, std::size(numbers))];
  }
  double bound() {
    static const double infinity = std::numeric_limits<double>::infinity(),
                        nan = std::numeric_limits<double>::quiet_NaN();
    const double bounds[] = {0, -1, 1, 1e300, -1e300, infinity, -infinity, nan};
    return bounds[below(random_, std::size(bounds))];
  }
  /// A count that says less than there is, or more than any plugin has.
  uint32_t count(uint32_t is) { return below(random_, 3) ? static_cast<uint32_t>(below(random_, is + 1)) : 1u << 30; }

  void change_table() {
    const char** texts[] = {&table_.name, &table_.version, &table_.licence, &table_.build_id};
    switch (below(random_, 6)) {
      case 0:
        table_.size = number();
        break;
      case 1:
        table_.type_count = count(static_cast<uint32_t>(type_list_.size()));
        break;
      case 2:
        table_.node_count = count(static_cast<uint32_t>(node_list_.size()));
        break;
      case 3:
        table_.types = nullptr;
        break;
      default:
        *texts[below(random_, 4)] = text();
    }
  }

  template <typename Entry>
  void change(std::deque<Entry>& entries) {
    if (!entries.empty()) change(entries[below(random_, entries.size())]);
  }

  void change(plumbline_type& type) {
    switch (below(random_, 5)) {
      case 0:
        type.size = number();
        break;
      case 1:
        type.name = text();
        break;
      case 2:
        type.fingerprint = text();
        break;
      default:
        change_schema(type.schema);
    }
  }

  void change_schema(plumbline_bytes& schema) {
    if (!schema.data || !schema.size) return;
    std::string& bytes = texts_.emplace_back(static_cast<const char*>(schema.data), schema.size);
    for (size_t i = 1 + below(random_, 4); i > 0; --i)
      bytes[below(random_, bytes.size())] = static_cast<char>(random_());
    schema = {below(random_, 20) ? bytes.data() : nullptr,
              below(random_, 4) ? bytes.size() : below(random_, bytes.size())};
  }

  void change(plumbline_node& node) {
    const char** texts[] = {&node.kind, &node.role, &node.summary};
    switch (below(random_, 10)) {
      case 0:
        node.size = number();
        break;
      case 1:
        node.deterministic = number();
        break;
      case 2:
        node.run = nullptr;
        break;
      case 3:
        node.input_count = count(node.input_count);
        break;
      case 4:
        node.output_count = count(node.output_count);
        break;
      case 5:
        node.param_count = count(node.param_count);
        break;
      case 6:
        node.inputs = nullptr;
        break;
      default:
        *texts[below(random_, 3)] = text();
    }
  }

  void change(plumbline_port& port) {
    const char** texts[] = {&port.name, &port.type, &port.fingerprint, &port.frames, &port.doc};
    switch (below(random_, 7)) {
      case 0:
        port.size = number();
        break;
      case 1:
        port.cardinality = number();
        break;
      default:
        *texts[below(random_, 5)] = text();
    }
  }

  void change(plumbline_param& param) {
    const char** texts[] = {&param.name, &param.default_text, &param.default_text, &param.unit, &param.doc};
    switch (below(random_, 10)) {
      case 0:
        param.size = number();
        break;
      case 1:
        param.kind = number();
        break;
      case 2:
        param.is_list = number();
        break;
      case 3:
        param.minimum = bound();
        break;
      case 4:
        param.maximum = bound();
        break;
      case 5: {
        auto& choices = choice_lists_.emplace_back();
        for (size_t i = below(random_, 4); i > 0; --i) choices.push_back(text());
        param.choice_count = below(random_, 8) ? static_cast<uint32_t>(choices.size()) : 1u << 30;
        param.choices = below(random_, 8) ? choices.data() : nullptr;
        break;
      }
      default:
        *texts[below(random_, 5)] = text();
    }
  }

  /// Entries that are null or stand twice.
  void change_lists() {
    if (below(random_, 2) && !type_list_.empty())
      type_list_[below(random_, type_list_.size())] = below(random_, 3) ? type_list_[0] : nullptr;
    else if (!node_list_.empty())
      node_list_[below(random_, node_list_.size())] = below(random_, 3) ? node_list_[0] : nullptr;
  }

  Random& random_;
  plumbline_plugin_table table_;
  std::deque<plumbline_type> types_;
  std::deque<plumbline_node> nodes_;
  std::deque<plumbline_port> ports_;
  std::deque<plumbline_param> params_;
  std::deque<std::string> texts_;
  std::vector<const plumbline_type*> type_list_;
  std::vector<const plumbline_node*> node_list_;
  std::deque<std::vector<const plumbline_port*>> port_lists_;
  std::deque<std::vector<const plumbline_param*>> param_lists_;
  std::deque<std::vector<const char*>> choice_lists_;
};

}  // namespace plumbline::test

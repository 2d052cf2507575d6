// The C++ layer over plugin.h: a node is a struct whose members are its ports and parameters.
//
//   struct Shift : plumbline::Node {
//     static constexpr plumbline::Info info{"demo.shift", "", 1, "Moves points along z"};
//     In<Points>     source{"source", frame("frame=?S"), "points to move"};
//     Param<double>  height{"height", 0.0, "m", between(-100, 100), "how far up"};
//     Out<Points>    moved{"points", frame("frame=?S"), "the moved points"};
//     void run(Context&) override {
//       PointsT points = source.unpack();
//       for (auto& point : points.points) point->position.z() += *height;
//       moved.commit(points);
//     }
//   };
//   PLUMBLINE_PLUGIN("demo", "0.1.0", "MIT", Shift)
//
// A node object lives for one run. What run() throws becomes the error of the node; nothing else leaves the plugin.
// Members register themselves with the node under construction, so a line each is all there is to declare.
#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "plumbline/artifact.hpp"
#include "plumbline/plugin.h"

namespace plumbline {

struct Info {
  const char* kind;
  const char* role;
  uint32_t version;
  const char* summary;
  bool deterministic = true;
};

/// Frame binding of a port: "frame=?S" binds the type's parameter `frame` to the variable S, "frame=building" to a
/// name.
struct Frames {
  const char* text = "";
};
constexpr Frames frame(const char* text) { return {text}; }

struct Bounds {
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
};
constexpr Bounds between(double minimum, double maximum) { return {minimum, maximum}; }
constexpr Bounds at_least(double minimum) { return {minimum, std::numeric_limits<double>::infinity()}; }

struct Choices {
  std::vector<const char*> values;
};
template <typename... Text>
Choices one_of(Text... texts) {
  return {{texts...}};
}

/// In place of a default: the pipeline must give the parameter.
struct Required {};
inline constexpr Required required{};

/// Path parameters; the host makes them absolute and puts the content they name into the cache key.
struct FilePath {
  std::string path;
};
struct FolderPath {
  std::string path;
};

/// What the host offers beside ports and parameters.
class Context {
 public:
  explicit Context(const plumbline_host& host) : host_(host) {}
  void info(const std::string& text) const { host_.log(host_.context, PLUMBLINE_INFO, text.c_str()); }
  void warn(const std::string& text) const { host_.log(host_.context, PLUMBLINE_WARNING, text.c_str()); }
  void progress(double fraction, const std::string& text = "") const {
    host_.progress(host_.context, fraction, text.c_str());
  }
  bool cancelled() const { return host_.cancelled(host_.context) != 0; }
  uint64_t seed() const { return host_.seed(host_.context); }
  void metric(const std::string& name, double value, const std::string& unit) const {
    host_.metric(host_.context, name.c_str(), value, unit.c_str());
  }
  /// Path of the file that an artifact names by `uri`. Throws if there is none.
  std::string resolve(const std::string& uri) const {
    const char* path = host_.resolve(host_.context, uri.c_str());
    if (!path) throw std::runtime_error("cannot find '" + uri + "'");
    return path;
  }
  /// SHA-256 of a file as 64 hexadecimal digits. Throws if it cannot be read.
  std::string digest(const std::string& path) const {
    const char* hex = host_.digest(host_.context, path.c_str());
    if (!hex) throw std::runtime_error("cannot read '" + path + "'");
    return hex;
  }
  /// Waits until so much memory is free under the run's limit; it is given back when the node ends. Call it once,
  /// before the allocation, with the whole amount.
  void reserve_memory(uint64_t bytes) const {
    if (host_.reserve_memory(host_.context, bytes)) throw std::runtime_error("cancelled while waiting for memory");
  }
  const plumbline_host& host() const { return host_; }

 private:
  const plumbline_host& host_;
};

namespace detail {
struct NodeParts {
  std::vector<const plumbline_port*> inputs, outputs;
  std::vector<const plumbline_param*> params;
  std::vector<const plumbline_type*> types;
};
inline thread_local NodeParts* parts_under_construction = nullptr;
inline thread_local const plumbline_host* host_of_this_run = nullptr;
}  // namespace detail

/// Base of every node.
class Node {
 public:
  Node() { detail::parts_under_construction = &parts_; }
  virtual ~Node() = default;
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;
  virtual void run(Context& context) = 0;
  const detail::NodeParts& parts() const { return parts_; }

 private:
  detail::NodeParts parts_;

 protected:
  template <typename Table, uint32_t Cardinality>
  class Port;
  template <typename Table>
  struct In;
  template <typename Table>
  struct Optional;
  template <typename Table>
  struct List;
  template <typename Table>
  struct Each;
  template <typename Table>
  class Out;
  template <typename Table>
  class OutList;
  template <typename T>
  class Param;
};

/// An input or output: its declaration, and the host while the node runs.
template <typename Table, uint32_t Cardinality>
class Node::Port {
 public:
  using Native = typename artifact_traits<Table>::Native;
  Port(const char* name, Frames frames, const char* doc)
      : port_{sizeof(plumbline_port),
              Cardinality,
              name,
              artifact_traits<Table>::name,
              artifact_traits<Table>::fingerprint,
              frames.text,
              doc},
        host_(detail::host_of_this_run) {
    detail::parts_under_construction->types.push_back(&artifact_traits<Table>::type());
  }
  const char* name() const { return port_.name; }

 protected:
  const Table* table(size_t index) const {
    plumbline_bytes bytes{};
    if (host_->get(host_->context, port_.name, index, &bytes))
      throw std::runtime_error(std::string("cannot read input '") + port_.name + "'");
    return flatbuffers::GetRoot<Table>(bytes.data);
  }
  Native unpack_item(size_t index) const {
    Native native;
    table(index)->UnPackTo(&native);
    return native;
  }
  size_t count() const { return host_->item_count(host_->context, port_.name); }
  void commit_native(const Native& native) const {
    flatbuffers::FlatBufferBuilder builder;
    builder.Finish(Table::Pack(builder, &native));
    commit_bytes(builder.GetBufferPointer(), builder.GetSize());
  }
  void commit_bytes(const void* data, size_t size) const {
    if (host_->commit(host_->context, port_.name, data, size))
      throw std::runtime_error(std::string("output '") + port_.name + "' was refused");
  }
  plumbline_port port_;
  const plumbline_host* host_;
};

/// An input that must be connected. `->` reads it in place, unpack() gives the C++ object.
template <typename Table>
struct Node::In : Node::Port<Table, PLUMBLINE_ONE> {
  using Base = Node::Port<Table, PLUMBLINE_ONE>;
  In(const char* name, const char* doc) : In(name, Frames{}, doc) {}
  In(const char* name, Frames frames, const char* doc) : Base(name, frames, doc) {
    detail::parts_under_construction->inputs.push_back(&this->port_);
  }
  const Table* operator->() const { return this->table(0); }
  const Table& operator*() const { return *this->table(0); }
  typename Base::Native unpack() const { return this->unpack_item(0); }
};

/// An input that may be left unconnected: test it before use.
template <typename Table>
struct Node::Optional : Node::Port<Table, PLUMBLINE_OPTIONAL> {
  using Base = Node::Port<Table, PLUMBLINE_OPTIONAL>;
  Optional(const char* name, const char* doc) : Optional(name, Frames{}, doc) {}
  Optional(const char* name, Frames frames, const char* doc) : Base(name, frames, doc) {
    detail::parts_under_construction->inputs.push_back(&this->port_);
  }
  explicit operator bool() const { return this->count() > 0; }
  const Table* operator->() const { return this->table(0); }
  const Table& operator*() const { return *this->table(0); }
  typename Base::Native unpack() const { return this->unpack_item(0); }
};

/// All items of an edge, in order.
template <typename Table>
struct Node::List : Node::Port<Table, PLUMBLINE_LIST> {
  using Base = Node::Port<Table, PLUMBLINE_LIST>;
  List(const char* name, const char* doc) : List(name, Frames{}, doc) {}
  List(const char* name, Frames frames, const char* doc) : Base(name, frames, doc) {
    detail::parts_under_construction->inputs.push_back(&this->port_);
  }
  size_t size() const { return this->count(); }
  const Table& operator[](size_t index) const { return *this->table(index); }
  typename Base::Native unpack(size_t index) const { return this->unpack_item(index); }
};

/// One item of an edge: the host runs the node for each of them, in parallel, and joins the outputs in the items'
/// order.
template <typename Table>
struct Node::Each : Node::Port<Table, PLUMBLINE_EACH> {
  using Base = Node::Port<Table, PLUMBLINE_EACH>;
  Each(const char* name, const char* doc) : Each(name, Frames{}, doc) {}
  Each(const char* name, Frames frames, const char* doc) : Base(name, frames, doc) {
    detail::parts_under_construction->inputs.push_back(&this->port_);
  }
  const Table* operator->() const { return this->table(0); }
  const Table& operator*() const { return *this->table(0); }
  typename Base::Native unpack() const { return this->unpack_item(0); }
};

/// An output of one item; every run must commit it once.
template <typename Table>
class Node::Out : public Node::Port<Table, PLUMBLINE_ONE> {
 public:
  using Base = Node::Port<Table, PLUMBLINE_ONE>;
  Out(const char* name, const char* doc) : Out(name, Frames{}, doc) {}
  Out(const char* name, Frames frames, const char* doc) : Base(name, frames, doc) {
    detail::parts_under_construction->outputs.push_back(&this->port_);
  }
  void commit(const typename Base::Native& native) const { this->commit_native(native); }
  /// For builders: a finished buffer whose root is `Table`.
  void commit(const flatbuffers::FlatBufferBuilder& builder) const {
    this->commit_bytes(builder.GetBufferPointer(), builder.GetSize());
  }
  /// For outputs of type Folder: an empty folder to fill, and the uri by which artifacts name it.
  struct NewFolder {
    std::string path, uri;
  };
  NewFolder make_folder() const {
    const char *path = nullptr, *uri = nullptr;
    if (this->host_->make_folder(this->host_->context, this->port_.name, &path, &uri))
      throw std::runtime_error(std::string("cannot make a folder for output '") + this->port_.name + "'");
    return {path, uri};
  }
};

/// An output of any number of items, in the order of the commits.
template <typename Table>
class Node::OutList : public Node::Port<Table, PLUMBLINE_LIST> {
 public:
  using Base = Node::Port<Table, PLUMBLINE_LIST>;
  OutList(const char* name, const char* doc) : OutList(name, Frames{}, doc) {}
  OutList(const char* name, Frames frames, const char* doc) : Base(name, frames, doc) {
    detail::parts_under_construction->outputs.push_back(&this->port_);
  }
  void commit(const typename Base::Native& native) const { this->commit_native(native); }
};

namespace detail {

inline std::string to_text(double v) {
  if (std::isnan(v)) return "nan";
  char buffer[40];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, v).ptr;  // shortest text that reads back the same
  return {buffer, end};
}
inline std::string to_text(int64_t v) { return std::to_string(v); }
inline std::string to_text(bool v) { return v ? "true" : "false"; }
inline std::string to_text(const std::string& v) { return v; }
inline std::string to_text(const FilePath& v) { return v.path; }
inline std::string to_text(const FolderPath& v) { return v.path; }
template <typename T>
std::string to_text(const std::vector<T>& list) {
  std::string text;
  for (size_t i = 0; i < list.size(); ++i) text += (i ? "\x1f" : "") + to_text(list[i]);
  return text;
}

inline void from_text(std::string_view text, double& v) {
  if (text == "nan") {
    v = std::numeric_limits<double>::quiet_NaN();
    return;
  }
  std::from_chars(text.data(), text.data() + text.size(), v);
}
inline void from_text(std::string_view text, int64_t& v) { std::from_chars(text.data(), text.data() + text.size(), v); }
inline void from_text(std::string_view text, bool& v) { v = text == "true"; }
inline void from_text(std::string_view text, std::string& v) { v = text; }
inline void from_text(std::string_view text, FilePath& v) { v.path = text; }
inline void from_text(std::string_view text, FolderPath& v) { v.path = text; }
template <typename T>
void from_text(std::string_view text, std::vector<T>& list) {
  list.clear();
  while (!text.empty()) {
    const size_t end = text.find('\x1f');
    from_text(text.substr(0, end), list.emplace_back());
    if (end == std::string_view::npos) break;
    text.remove_prefix(end + 1);
  }
}

template <typename T>
struct ParamKind;
template <>
struct ParamKind<double> {
  static constexpr uint32_t kind = PLUMBLINE_NUMBER, is_list = 0;
};
template <>
struct ParamKind<int64_t> {
  static constexpr uint32_t kind = PLUMBLINE_INTEGER, is_list = 0;
};
template <>
struct ParamKind<bool> {
  static constexpr uint32_t kind = PLUMBLINE_BOOLEAN, is_list = 0;
};
template <>
struct ParamKind<std::string> {
  static constexpr uint32_t kind = PLUMBLINE_TEXT, is_list = 0;
};
template <>
struct ParamKind<FilePath> {
  static constexpr uint32_t kind = PLUMBLINE_FILE, is_list = 0;
};
template <>
struct ParamKind<FolderPath> {
  static constexpr uint32_t kind = PLUMBLINE_FOLDER, is_list = 0;
};
template <typename T>
struct ParamKind<std::vector<T>> {
  static constexpr uint32_t kind = ParamKind<T>::kind, is_list = 1;
};

}  // namespace detail

/// A parameter: double, int64_t, bool, std::string, FilePath, FolderPath, or a std::vector of them. `*height` is its
/// value.
template <typename T>
class Node::Param {
 public:
  Param(const char* name, T fallback, const char* doc) : Param(name, fallback, "", Bounds{}, doc) {}
  Param(const char* name, T fallback, const char* unit, const char* doc) : Param(name, fallback, unit, Bounds{}, doc) {}
  Param(const char* name, T fallback, Bounds bounds, const char* doc) : Param(name, fallback, "", bounds, doc) {}
  Param(const char* name, T fallback, const char* unit, Bounds bounds, const char* doc)
      : default_(detail::to_text(fallback)) {
    declare(name, unit, bounds, doc, default_.c_str());
  }
  Param(const char* name, T fallback, Choices choices, const char* doc)
      : default_(detail::to_text(fallback)), choices_(std::move(choices)) {
    declare(name, "", {}, doc, default_.c_str());
  }
  Param(const char* name, Required, const char* doc) { declare(name, "", {}, doc, nullptr); }
  Param(const char* name, Required, const char* unit, Bounds bounds, const char* doc) {
    declare(name, unit, bounds, doc, nullptr);
  }
  Param(const char* name, Required, Choices choices, const char* doc) : choices_(std::move(choices)) {
    declare(name, "", {}, doc, nullptr);
  }
  const T& operator*() const { return value_; }
  const T* operator->() const { return &value_; }

 private:
  void declare(const char* name, const char* unit, Bounds bounds, const char* doc, const char* default_text) {
    param_ = {sizeof(plumbline_param),
              detail::ParamKind<T>::kind,
              detail::ParamKind<T>::is_list,
              static_cast<uint32_t>(choices_.values.size()),
              name,
              default_text,
              unit,
              doc,
              bounds.minimum,
              bounds.maximum,
              choices_.values.data()};
    detail::parts_under_construction->params.push_back(&param_);
    if (const plumbline_host* host = detail::host_of_this_run)
      if (const char* text = host->parameter(host->context, name)) detail::from_text(text, value_);
  }
  std::string default_;
  Choices choices_;
  plumbline_param param_{};
  T value_{};
};

namespace detail {

template <typename N>
int run_node(const plumbline_host* host) noexcept {
  try {
    host_of_this_run = host;
    N node;
    host_of_this_run = nullptr;
    Context context(*host);
    static_cast<Node&>(node).run(context);
    return 0;
  } catch (const std::exception& error) {
    host->fail(host->context, error.what());
  } catch (...) {
    host->fail(host->context, "an exception that is not a std::exception");
  }
  host_of_this_run = nullptr;
  return 1;
}

/// A node object that lives as long as the library, because the declarations point into it.
template <typename N>
const NodeParts& parts_of() {
  static const N prototype;
  return prototype.parts();
}

template <typename N>
const plumbline_node* declare_node() {
  const NodeParts& parts = parts_of<N>();
  static const plumbline_node entry = {sizeof(plumbline_node),
                                       N::info.version,
                                       N::info.kind,
                                       N::info.role,
                                       N::info.summary,
                                       parts.inputs.data(),
                                       parts.outputs.data(),
                                       parts.params.data(),
                                       static_cast<uint32_t>(parts.inputs.size()),
                                       static_cast<uint32_t>(parts.outputs.size()),
                                       static_cast<uint32_t>(parts.params.size()),
                                       N::info.deterministic ? 1u : 0u,
                                       &run_node<N>};
  return &entry;
}

template <typename... Nodes>
const plumbline_plugin_table* make_table(const char* name, const char* version, const char* licence,
                                         const char* build) {
  static const std::vector<const plumbline_node*> nodes{declare_node<Nodes>()...};
  static const std::vector<const plumbline_type*> types = [] {
    std::vector<const plumbline_type*> all;
    for (const NodeParts* parts : {&parts_of<Nodes>()...})
      for (const plumbline_type* type : parts->types)
        if (std::find(all.begin(), all.end(), type) == all.end()) all.push_back(type);
    return all;
  }();
  static const plumbline_plugin_table table = {PLUMBLINE_MAGIC,
                                               sizeof(plumbline_plugin_table),
                                               PLUMBLINE_ABI_MAJOR,
                                               PLUMBLINE_ABI_MINOR,
                                               name,
                                               version,
                                               licence,
                                               build,
                                               nodes.data(),
                                               types.data(),
                                               static_cast<uint32_t>(nodes.size()),
                                               static_cast<uint32_t>(types.size())};
  return &table;
}

constexpr plumbline_note make_note(const char* name, const char* version, const char* licence, const char* build) {
  plumbline_note note{10, sizeof(plumbline_note::text) + 8, 1, "plumbline\0", PLUMBLINE_ABI_MAJOR, PLUMBLINE_ABI_MINOR,
                      {}};
  size_t used = 0;
  for (const char* part : {name, version, licence, build}) {
    for (; *part && used + 5 < sizeof note.text; ++part) note.text[used++] = *part;
    ++used;
  }
  return note;
}

}  // namespace detail
}  // namespace plumbline

#ifndef PLUMBLINE_BUILD_ID
#define PLUMBLINE_BUILD_ID "unknown"
#endif

/// Exports the plugin: its name, version, licence, and the list of its nodes. Once in a library.
#define PLUMBLINE_PLUGIN(name, version, licence, ...)                                              \
  __attribute__((used, section(".note.plumbline"),                                                 \
                 aligned(4))) static constinit const plumbline_note plumbline_note_data =          \
      plumbline::detail::make_note(name, version, licence, PLUMBLINE_BUILD_ID);                    \
  extern "C" PLUMBLINE_EXPORT const plumbline_plugin_table* plumbline_plugin(void) {               \
    return plumbline::detail::make_table<__VA_ARGS__>(name, version, licence, PLUMBLINE_BUILD_ID); \
  }

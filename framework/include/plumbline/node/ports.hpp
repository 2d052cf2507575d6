// The base of every node, and its inputs and outputs.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "plumbline/artifact.hpp"
#include "plumbline/node/context.hpp"
#include "plumbline/node/declarations.hpp"

namespace plumbline {

namespace detail {
struct NodeParts {
  std::vector<const plumbline_port*> inputs, outputs;
  std::vector<const plumbline_param*> params;
  std::vector<const plumbline_type*> types;
};
template <typename Table>
concept IsArtifact = requires {
  typename artifact_traits<Table>::Native;
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
  static_assert(
      detail::IsArtifact<Table>,
      "a port carries an artifact: include \"artifacts/NAME.hpp\", made by plumbline_add_artifacts() from a schema");

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

}  // namespace plumbline

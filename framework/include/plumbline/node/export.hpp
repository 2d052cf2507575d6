// From the nodes of a library to the table and the ELF note that plugin.h asks for.
#pragma once

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "plumbline/failure.hpp"
#include "plumbline/node/ports.hpp"
#include "plumbline/stop.hpp"

namespace plumbline {

namespace detail {

template <typename N>
int run_node(const plumbline_host* host, const plumbline_node* entry) noexcept {
  int answer = PLUMBLINE_FAILED;
  try {
    if (host->size < sizeof(plumbline_host))
      throw std::logic_error("this host lends fewer services than the plugin was built for; update plumbline");
    host_of_this_run = host;
    N node;
    host_of_this_run = nullptr;
    Context context(*host, *entry);
    const StopScope scope([](const void* of) { return static_cast<const Context*>(of)->cancelled(); }, &context);
    static_cast<Node&>(node).run(context);
    return PLUMBLINE_DONE;
  } catch (const Failure& failure) {
    host->fail(host->context, failure.what());
    answer = failure.kind();
  } catch (const std::exception& error) {
    host->fail(host->context, error.what());
  } catch (const Stopped&) {
    host->fail(host->context, "stopped");
  } catch (...) {
    host->fail(host->context, "an exception that is not a std::exception");
  }
  host_of_this_run = nullptr;
  return answer;
}

template <typename N>
concept HasInfo = std::is_same_v<std::remove_cvref_t<decltype(N::info)>, Info>;

/// A node object that lives as long as the library, because the declarations point into it.
template <typename N>
const NodeParts& parts_of() {
  static_assert(std::is_base_of_v<Node, N>, "PLUMBLINE_PLUGIN lists a type that does not derive from plumbline::Node");
  static_assert(!std::is_abstract_v<N>, "a node overrides `void run(plumbline::Context&)`");
  static_assert(std::is_default_constructible_v<N>,
                "a node has no constructor arguments: its ports and parameters are members");
  static_assert(
      HasInfo<N>,
      "a node says what it is: static constexpr plumbline::Info info{\"family.name\", \"role\", 1, \"what it does\"};");
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
                                       &run_node<N>,
                                       nullptr,
                                       N::info.lacks};
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

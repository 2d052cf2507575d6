// The key of a node: the hash of everything that its outputs depend on.
//
// That is its kind, the version of its algorithm, the plugin's binary and the libraries it is linked with, its
// parameters, the content of its inputs, and the ABI. The fields are kept by name, so that two keys can be compared and
// the difference named.
//
// Randomness: a node gets its seed from the host, derived from the run's seed, the node's name and the item's index,
// and so the same on every machine and with every build. Whether a node asks for it can depend on nothing but the
// fields above. A run that did not ask is stored under the key of the fields alone, and serves every seed; one that
// did, under the key of fields and seed. Looking up both is therefore sound, and `seed=2` reruns only what draws.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "runtime/graph/graph.hpp"
#include "runtime/store/store.hpp"

namespace plumbline::runtime {

using KeyFields = std::map<std::string, std::string>;
using Hashes = std::vector<std::string>;

/// The fields that are equal for all items of a node. Reads the files and folders that parameters name; throws
/// std::runtime_error if one cannot be read.
KeyFields key_fields(const GraphNode& node, FileHashes& files);

/// Adds the inputs, by port.
void add_inputs(KeyFields& fields, const std::map<std::string, Hashes>& inputs);

std::string key_of(const KeyFields& fields);
std::string key_with_seed(const std::string& key, uint64_t seed);

/// Seed of a node's run on one item (0 for a node that does not map). The first round has that of a graph without.
uint64_t seed_of(uint64_t run_seed, const std::string& node_name, size_t item, size_t round = 0);

/// What differs, one line each, hashes shortened: "parameter solver: epnp -> upnp".
std::vector<std::string> compare(const KeyFields& before, const KeyFields& now);

/// The stored result of a node's run on one item.
struct Stored {
  std::string key;  ///< under which it was found; empty: not found
  StoredRun run;
  std::string damage;    ///< why a result that was there cannot be used
  std::string outdated;  ///< which file that a result depends on has changed since
};
Stored look_up(Store& store, const std::string& key, uint64_t seed);

}  // namespace plumbline::runtime

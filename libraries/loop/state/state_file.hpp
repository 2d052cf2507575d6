// The state of a loop as a file that the next round reads, on a site where days lie between rounds.
#pragma once

#include <string>

#include "artifacts/loop_state.hpp"

namespace plumbline::loop {

/// JSON with all of the state, its journal included, and a seal: the SHA-256 of the rest. The same state gives the same
/// bytes. Lengths in metres; null: not known.
std::string state_json(const LoopStateT& state);

/// Back, bit for bit. Throws std::runtime_error that begins with `source` for what is no such file, was changed since
/// it was written (the seal, or the chain of the journal, does not hold), or says of an item what its journal does not.
/// The seal shows accidents and edits by hand; it is no signature.
LoopStateT read_state_json(const std::string& text, const std::string& source);

}  // namespace plumbline::loop

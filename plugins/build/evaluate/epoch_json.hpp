// as_built.json: what a campaign leaves for the next one.
#pragma once

#include <string>

#include "building/judgement/epochs.hpp"

namespace plumbline::judgement {

/// The record, and what changed since the campaign before; lengths in m, in the frame of the design, unknown ones null.
std::string epoch_json(const EpochRecord& record, const AsBuiltChangesT& changes);

/// Reads the record of `path`. Throws BadInput that names the file, what it is and what is expected.
EpochRecord read_epoch(const std::string& path);

}  // namespace plumbline::judgement

// Short names for drawings and tables: what anchors of a floor or of a column have in common is said once.
#pragma once

#include <map>
#include <string>

#include "artifacts/accuracy.hpp"

namespace plumbline::report {

/// The part of the names that all anchors of a floor share, up to a separator, by floor: "F02-" for F02-C01-R1 and
/// F02-K1. Floors of one anchor and anchors of no floor are left out.
std::map<int, std::string> common_prefixes(const AccuracyT& accuracy);

/// What to call each marker column, by its number: what its anchors' names share without the floor's part ("C01" of
/// F01-C01-R1, F02-C01-R2; "K1" of F01-K1, F02-K1), else "column 3".
std::map<int, std::string> column_names(const AccuracyT& accuracy);

/// Where a long name has no room: its end, in which the names of programs differ ("…1043775" of
/// "Anchor:HTA 38/17:1043775", "…Cp8h60o" of a GlobalId). Short names stay as they are.
std::string end_of(const std::string& name);

}  // namespace plumbline::report

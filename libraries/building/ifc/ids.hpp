// asbuilt.ids: what an as-built file of a campaign has to hold, as an Information Delivery Specification (buildingSMART
// IDS 1.0), so that whoever receives the file can check it with a program of their own.
#pragma once

#include <string>

#include "artifacts/deviation.hpp"

namespace plumbline::ifc {

struct Design;

struct IdsOptions {
  std::string epoch;       ///< as in AsBuiltIfcOptions: part of the names of the sets
  std::string date;        ///< xs:date; empty: left out
  bool must_pass = false;  ///< also ask that every anchor and panel passes: the acceptance of the work
};

/// Asks of every anchor that is an element, by GlobalId: a verdict; of every one that was measured: deviations, the
/// measured position and, where it is known, its uncertainty; of every panel that was judged: verdict and fit; of
/// the project: that it is this one, and a verdict on the whole. With `must_pass` all of these verdicts are PASS, also
/// of panels that nobody judged, and the whole's, which is none while anything that was asked for is not judged.
/// Facets: entity, attribute GlobalId, property with type and values. The same input gives the same bytes.
std::string write_ids(const Design& design, const DeviationT& deviation, const IdsOptions& options);

}  // namespace plumbline::ifc

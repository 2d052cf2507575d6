// Part of network_model.cpp: the steps from a survey to a model, in the order they are taken.
#pragma once

#include "survey/network/network_model.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

inline bool is_free(CoordinateRole role) { return role == CoordinateRole::free || role == CoordinateRole::constrained; }

/// What orients a network with fewer than two known points is not measured: it is stated first, so that nobody takes
/// such coordinates for those of a site grid.
void tell_orientation(NetworkModel& model);

/// Where a single point is held, only the stated orientation says where north is: it is held too, by an azimuth to the
/// set-up's first target. A free network gets it with its approximate coordinates.
void hold_stated_orientation(NetworkModel& model);

/// Decides which datum is meant and gives every coordinate its role accordingly.
void apply_datum(NetworkModel& model, const AdjustOptions& options, const ControlPoints& control);

/// Lengths that standard deviations depend on: as measured where the sight has a distance, else from approximate
/// coordinates.
void find_lengths(NetworkModel& model);

/// Leaves out observations that cannot be used with the points as they are.
void drop_unusable(NetworkModel& model);

/// Vectors of the earth need a map, vectors of a plane have none. A file whose reader has drawn its own map of
/// latitudes and longitudes, as PROJ writes it, is on that one. Throws NetworkError.
void take_map(NetworkModel& model, const AdjustOptions& options);

/// What the map makes of each observation at the approximate coordinates. Throws NetworkError where these cannot be on
/// the map.
void find_map_corrections(NetworkModel& model);

/// Adjusts each model, if there are several, and returns the one that fits best. Throws NetworkError if two of them fit
/// equally well and are not the same network: with what would tell them apart.
NetworkModel choose_alternative(std::vector<NetworkModel> models, const AdjustOptions& options);

/// Leaves out what contradicts the approximate coordinates by more than the file allows (gama-local: tol-abs), because
/// linearised it would spoil everything.
void drop_outlying(NetworkModel& model);

}  // namespace plumbline::survey

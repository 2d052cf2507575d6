// The way into the design where nothing says it but the anchors themselves.
#pragma once

#include "building/ifc/georeference.hpp"
#include "geometry/frame_graph.hpp"

namespace plumbline::frames {

/// What may turn: a survey is level, so that only its north is open; a block of photographs alone may lean.
enum class Freedom { level, space };

/// building_from_survey, shift and turn without scale, by least squares of the anchors, over and over without those
/// that are far from it: one that stands 200 mm out would move all others by 200 mm over their number. Its covariance
/// is that of the fit, from what is left of the anchors, plus that of `datum_sigma` (add_datum). `origin` says how many
/// anchors it rests on and names the others. Throws std::runtime_error where they do not tell it.
FrameLink fit_frame(const ifc::CommonPoints& common, Freedom freedom, double datum_sigma);

/// Makes a way into the building uncertain by `datum_sigma` [m]: each axis of the shift, and what the turn does at the
/// anchors' mean distance from their middle; nan adds nothing.
void add_datum(const ifc::CommonPoints& common, Freedom freedom, double datum_sigma, FrameLink& link);

}  // namespace plumbline::frames

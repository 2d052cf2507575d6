// deviations.dxf: the judgement as a drawing for CAD.
#pragma once

#include <string>

#include "artifacts/deviation.hpp"

namespace plumbline::judgement {

/// DXF R12, metres, in the frame of the design. Layers by verdict: ANCHOR_PASS, ANCHOR_FAIL, …: a point at the design
/// position, and a text with the name and what is to be said (as-built minus design, to the right, up and out as one
/// stands before the facade; along x, y, z where it is not known which way that is), upright on the facade; DEVIATION:
/// a line from the design along the deviation, `exaggeration` times as long; PANEL_PASS, …: outlines by design. What is
/// not ASCII in a name is written as \U+XXXX.
std::string deviation_dxf(const DeviationT& deviation, double exaggeration = 100);

}  // namespace plumbline::judgement

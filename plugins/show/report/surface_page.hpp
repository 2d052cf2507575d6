// Panels as they stand: a heat map on the elevation of each facade, the facades' pictures, and a table of
// joints with their narrowest and widest places.
#pragma once

#include <string>

#include "artifacts/surface_judgement.hpp"
#include "artifacts/surfaces.hpp"
#include "show/report/facade_backdrop.hpp"

namespace plumbline::report {

/// What no table of joints can say of itself: what the temperature does to them. Coefficients of EN 1991-1-5, table C.1
/// (aluminium 24e-6, steel 12e-6 a kelvin), and of soda lime glass (EN 572-1: 9e-6).
inline constexpr const char* kTemperature =
    "Widths are as they were when they were measured: in 10 K a metre of aluminium changes by 0.24 mm, of steel by "
    "0.12 mm, of glass by 0.09 mm, and nothing here says at which temperature the design holds.";

/// One offline HTML page. `judgement` may be null. Deterministic; all text from the input is escaped.
std::string render_surface_page(const SurfacesT& surfaces, const SurfaceJudgementT* judgement, const std::string& title,
                                const std::vector<FacadePicture>& pictures = {});

}  // namespace plumbline::report

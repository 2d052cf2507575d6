// Panels as they stand: a heat map on the elevation of each facade, the facades' pictures, and a table of
// joints with their narrowest and widest places.
#pragma once

#include <string>

#include "artifacts/surface_judgement.hpp"
#include "artifacts/surfaces.hpp"
#include "show/report/facade_backdrop.hpp"

namespace plumbline::report {

/// One offline HTML page. `judgement` may be null. Deterministic; all text from the input is escaped.
std::string render_surface_page(const SurfacesT& surfaces, const SurfaceJudgementT* judgement, const std::string& title,
                                const std::vector<FacadePicture>& pictures = {});

}  // namespace plumbline::report

// sheets.html: one sheet of paper for each facade and floor, to take along and to sign.
#pragma once

#include <string>

#include "show/report/report.hpp"

namespace plumbline::report {

/// A page that prints as sheets: of every facade and floor the elevation of its anchors and panels, and a list of what
/// stands there, what is to be done, and room for who did it. Of the input the deviation (which must be there), the
/// grid, title and subtitle are shown. Floors from below within a facade; anchors that are in no facade or on no known
/// floor have sheets of their own, none is left out.
std::string render_sheets(const ReportInput& input);

}  // namespace plumbline::report

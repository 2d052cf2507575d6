// Plan and elevation of the survey network with error ellipses.
#pragma once

#include "show/report/markup.hpp"
#include "show/report/report.hpp"

namespace plumbline::report {

void write_network_drawings(Markup& html, const NetworkPage& network);

}  // namespace plumbline::report

// bench.html: everything in one file that needs no network.
#pragma once

#include <string>

#include "show/bench/analysis.hpp"

namespace plumbline::bench {

std::string to_html(const Bench& bench, const Analysis& analysis);

}  // namespace plumbline::bench

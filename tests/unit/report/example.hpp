// An example with everything in it: five floors, four columns, two rows, every third anchor withheld, one bad, one
// missing.
#pragma once

#include "show/report/report.hpp"

namespace plumbline::report::test {

/// `floors` floors of eight anchors.
ReportInput example(int floors = 5);

}  // namespace plumbline::report::test

// What a plan of installation does not see of the edges that sills hold. The same for its text and the loop's page.
#pragma once

#include <string>

#include "artifacts/installation_plan.hpp"

namespace plumbline::ifc {

/// One sentence with the panels on sills; empty: there are none.
std::string edge_words(const InstallationPlanT& plan);

}  // namespace plumbline::ifc

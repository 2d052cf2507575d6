// The result in a few lines of plain text: what a terminal shows after a run.
#pragma once

#include <string>

#include "artifacts/accuracy.hpp"
#include "artifacts/as_built_changes.hpp"
#include "artifacts/deviation.hpp"

namespace plumbline::report {

/// At most about 25 lines of at most 100 characters; in the language and units spoken. Comparisons in the order of the
/// artifact, the floors of the first one, the inter-floor transfers of the first one, and the warnings; what changed
/// since the campaign before, where there was one.
std::string summary_text(const AccuracyT& accuracy, const DeviationT* deviation = nullptr,
                         const AsBuiltChangesT* changes = nullptr);

}  // namespace plumbline::report

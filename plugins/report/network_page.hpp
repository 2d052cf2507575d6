// From the artifact of a network adjustment to what its page shows.
#pragma once

#include "artifacts/survey_network.hpp"
#include "report/report.hpp"

namespace plumbline::report {

NetworkPage network_page(const SurveyNetworkT& network);

}  // namespace plumbline::report

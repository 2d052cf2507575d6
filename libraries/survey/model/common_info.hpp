// What the files of one network say of themselves, as far as all say the same. The order of the files decides nothing.
#pragma once

#include <string>
#include <vector>

#include "survey/model/adjust_options.hpp"

namespace plumbline::survey {

struct CommonInfo {
  NetworkInfo info;  ///< what differs is as if no file had said it; format: "several"
  bool several_instruments = false, several_formats = false;
  std::vector<Finding> findings;  ///< what differs, with the values and the files that have them
};

/// `names` of the files, as findings call them. Precondition: there is at least one survey, and a name of each.
CommonInfo common_info(const std::vector<SurveyObservations>& surveys, const std::vector<std::string>& names);

}  // namespace plumbline::survey

// What a request of Pset_Tolerance is known by, for who reads requests (JudgementRequest) and not the design.
#pragma once

#include <algorithm>
#include <cctype>
#include <string_view>

namespace plumbline::judgement {

/// `not_judged` of a property that no axis here stands for: it says nothing of where things hang.
inline constexpr std::string_view kNothingMeasuresIt = "nothing here measures it";

/// Whether `asked` is a property of Pset_Tolerance, in whatever case the set is written.
inline bool is_property_of_tolerance(std::string_view asked) {
  constexpr std::string_view set = "pset_tolerance.";
  return asked.size() > set.size() && std::equal(set.begin(), set.end(), asked.begin(), [](char expected, char found) {
           return expected == std::tolower(static_cast<unsigned char>(found));
         });
}

}  // namespace plumbline::judgement

#pragma once

#include <string>

#include "survey/adjust/adjust_network.hpp"

namespace plumbline::survey {

/// All that an adjustment says, a finding a line.
inline std::string all_words(const NetworkResult& r) {
  std::string text;
  for (const Finding& f : r.findings) text += f.text + "\n";
  return text;
}

}  // namespace plumbline::survey

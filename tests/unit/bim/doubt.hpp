// A finding against a measurement, for tests.
#pragma once

#include <string>

#include "artifacts/deviation.hpp"

namespace plumbline::test {

/// A doubt about the survey, or about the image block.
inline MeasurementDoubtT doubt(const std::string& reason, MeasurementPart part = MeasurementPart::survey) {
  MeasurementDoubtT found;
  found.reason = reason, found.part = part;
  return found;
}

}  // namespace plumbline::test

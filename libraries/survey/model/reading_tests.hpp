// Tests of the readings of a survey among themselves, before any network: what the two faces say of the instrument, and
// which reading of a target contradicts the others from the same set-up. A blunder found here is one reading of one
// line; averaged away it would be a smaller one, of many readings, that the network blames on the first of them.
#pragma once

#include <string>
#include <vector>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// What both faces tell of the instrument in one set-up. Face 1 reads direction + collimation / sin(zenith angle), and
/// zenith angle + index; face 2 the same with opposite signs (Deumlich and Staiger, Instrumentenkunde, 9th ed., 7.1).
struct InstrumentErrors {
  int set_up = -1;
  double collimation = 0, index = 0;              ///< [rad], medians over the pairs
  double collimation_sigma = 0, index_sigma = 0;  ///< [rad], robust, of these medians
  int direction_pairs = 0, zenith_pairs = 0;
  /// From three pairs on, an error is the set-up's own; below, it is the median over the survey.
  bool has_collimation() const { return direction_pairs >= 3; }
  bool has_index() const { return zenith_pairs >= 3; }
};

/// One reading in a group. `value` is in face 1, on the first set's circle, relative to the group's origin [rad or m].
struct Reading {
  int observation = -1;
  int face = 0;
  double value = 0;
};

/// All readings of one kind to one target (and target height) from one set-up, or one that stands alone.
struct ReadingGroup {
  ObservationKind kind = ObservationKind::direction;
  int set_up = -1;
  bool alone = false;     ///< with a sigma of its own, or in a covariance: not tested, not averaged
  double sin_zenith = 1;  ///< of the sight
  double length = 0;      ///< slope length of the sight [m]; 0: unknown
  double origin = 0;      ///< value that `Reading::value` counts from
  std::vector<Reading> readings;
};

/// One entry per set-up.
std::vector<InstrumentErrors> estimate_instrument_errors(const std::vector<ReadingGroup>& groups, int set_ups);

/// `value` without what the instrument's error does to it in its face.
double without_instrument_error(const ReadingGroup& group, const Reading& reading, const InstrumentErrors& errors);

struct GroupVerdict {
  std::vector<char> removed;        ///< one per reading: contradicts the majority
  std::vector<double> differences;  ///< of each reading from the median of the group, instrument error taken out
  bool separate = false;            ///< the readings contradict each other and no majority says which is wrong
};

/// Tests every group against 5 standard deviations of one reading, which are estimated from all groups of a kind
/// (median difference of two readings) and are at least 1.5e-5 rad or 0.4 mm, with 0.5 mm across the sight.
std::vector<GroupVerdict> test_readings(const std::vector<ReadingGroup>& groups,
                                        const std::vector<InstrumentErrors>& errors);

}  // namespace plumbline::survey

// Several files of one campaign as one network. The danger is a name: two crews call their free stations S1, a reader
// calls two nameless ones free-station-1, a job of last year has other coordinates for P7.
#pragma once

#include <string>
#include <vector>

#include "survey/model/adjust_options.hpp"

namespace plumbline::survey {

struct MergeOptions {
  /// Points known beforehand (control): a set-up on one of them stands on that mark, in whatever file.
  std::vector<std::string> known;
  /// Stations of which the user says that they are the same mark in all files; "*": all of them. One that fewer than
  /// two files occupy is a warning.
  std::vector<std::string> same_stations;
};

struct MergedSurvey {
  SurveyObservations survey;
  std::vector<Finding>
      findings;  ///< what was united and why, what was kept apart, coordinates that contradict, known points unread
  std::vector<std::string> known_by_other_names;  ///< measured points that a known point means, were its name the same
};

/// Readings that stand in two files, or in one twice, are taken once (take_out_repeated_readings), with a warning.
/// Set-ups of one station in one file whose shared targets put them elsewhere get a station of their own.
/// Set-ups and pointings renumbered, set-ups with unique ids. A point that only one file occupies is united by its name
/// with the target or listed coordinates of that name elsewhere. A station occupied in several files is one point only
/// if its mark is shown to be the same: it is in `options`, both files hold it as datum, both sight it as a target,
/// what it sees is in both the same figure (>= 2 shared targets within 15 mm after turning alone, and the stations not
/// more than 5 mm apart beyond doubt), or both give it the same coordinates, not round to the metre. Otherwise each
/// file's has a name of its own ("monday:S1"). Coordinates of free points in a file whose coordinates contradict those
/// before it are not used. What the files say differently of themselves (instrument, refraction, scaling of
/// covariances, dates) is reset and told with both values; readings keep the instrument and the reduction that their
/// file states. Throws NetworkError where fixed coordinates contradict each other by more than 1 mm.
MergedSurvey merge_surveys(const std::vector<SurveyObservations>& surveys, const MergeOptions& options = {});

}  // namespace plumbline::survey

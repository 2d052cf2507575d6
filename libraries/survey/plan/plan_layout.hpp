// Inside of plan_survey: who can see whom, who is planned to, and what the adjustment of these sights will be worth.
#pragma once

#include <map>
#include <utility>

#include "survey/plan/plan_survey.hpp"

namespace plumbline::survey {

class PlanLayout {
 public:
  PlanLayout(const std::vector<PlannedMarker>& markers, const std::vector<PlannedSetUp>& set_ups,
             const PlanOptions& options);

  const std::vector<PlannedMarker>& markers() const { return markers_; }
  const std::vector<PlannedSetUp>& set_ups() const { return set_ups_; }
  const std::vector<int>& floors() const { return floors_; }
  std::vector<int> columns() const;
  std::vector<size_t> on_floor(int floor) const;

  bool possible(size_t set_up, size_t marker) const { return possible_[set_up][marker]; }
  bool planned(size_t set_up, size_t marker) const { return planned_[set_up][marker]; }
  PlannedSight sight(size_t set_up, size_t marker) const;
  int set_ups_seeing(size_t marker) const;
  int sightings() const;
  /// Sights that the plan names but that are out of range, too shallow or too steep.
  const std::vector<PlannedSight>& refused() const { return refused_; }

  void add_sight(size_t set_up, size_t marker) { planned_[set_up][marker] = 1; }
  /// A set-up that sights every marker it can.
  void add_set_up(const PlannedSetUp& set_up);

  /// Markers of one floor that set-ups see that see markers of both floors; the smaller number of the two floors.
  int shared_markers(int lower, int upper) const;
  bool sees_floor(size_t set_up, int floor) const;
  std::vector<size_t> seen_on_floor(int floor) const;

  SurveyObservations readings(int sets) const;
  AdjustOptions adjustment() const;

 private:
  bool allowed(const PlannedMarker& marker, const Eigen::Vector3d& from) const;
  void add_sighting(SurveyObservations& s, int set_up, const PlannedMarker& marker, int sets) const;

  std::vector<PlannedMarker> markers_;
  std::vector<PlannedSetUp> set_ups_;
  PlanOptions options_;
  std::vector<int> floors_;
  std::vector<std::vector<char>> possible_, planned_;  // [set-up][marker]
  std::vector<PlannedSight> refused_;
};

/// Weight of the height of a marker in a linear function of heights.
using HeightWeights = std::vector<std::pair<size_t, double>>;
/// Mean height of some markers of the upper floor minus that of some of the lower one.
HeightWeights transfer_weights(const std::vector<size_t>& lower, const std::vector<size_t>& upper);

struct PlanPrediction {
  bool adjustable = false;
  std::string problem;  ///< why not
  NetworkResult network;
  double height_sigma(const PlanLayout& layout, const HeightWeights& weights) const;  ///< [m]
};
PlanPrediction predict(const PlanLayout& layout, int sets);

/// Predictions of one layout for several numbers of sets, each computed once.
class PlanPredictions {
 public:
  explicit PlanPredictions(const PlanLayout& layout) : layout_(layout) {}
  const PlanPrediction& of(int sets) {
    const auto at = found_.find(sets);
    return at != found_.end() ? at->second : found_.emplace(sets, predict(layout_, sets)).first->second;
  }

 private:
  const PlanLayout& layout_;
  std::map<int, PlanPrediction> found_;
};

/// Standard deviation of the step from one floor to the next; infinite if there is none.
double transfer_sigma(const PlanLayout& layout, const PlanPrediction& prediction, int lower, int upper);

/// What mends a rule that fails, cheapest first; empty if nothing was found.
std::vector<PlanRemedy> remedies_for_set_ups(const PlanLayout& layout, const PlanOptions& options);
std::vector<PlanRemedy> remedies_for_sharing(const PlanLayout& layout, const PlanOptions& options, int lower,
                                             int upper);
std::vector<PlanRemedy> remedies_for_rank(const PlanLayout& layout, const PlanOptions& options);
std::vector<PlanRemedy> remedies_for_transfer(const PlanLayout& layout, const PlanOptions& options, int lower,
                                              int upper, PlanPredictions& predictions);

}  // namespace plumbline::survey

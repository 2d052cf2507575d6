// Parts of adjust_network.cpp: one run from a model to a result. Blunder search and variance components are in
// network_snooping.cpp, errors that set-ups have in common in network_systematics.cpp, the result's tables in
// network_report.cpp.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "survey/network/network_model.hpp"

namespace plumbline::survey {

class KeptNetwork;

/// One adjustment of the rows that are in.
struct Pass {
  NetworkProblem problem;
  least_squares::Solution solution;
  least_squares::Cofactors cofactors;
  least_squares::Reliability reliability;
};

/// An error that many observations have in common, as the hypothesis that explains most of the misfit.
struct CommonError {
  enum class Kind {
    constant,
    scale,
    index,
    height,
    target,
    face_index,
    collimation,
    reflector,
    tilt,
    sink,
    twist,
    edge,
    circle
  } kind = Kind::constant;
  int set_up = -1;           ///< -1: all set-ups
  int first = -1;            ///< circle: row of the first direction after it was turned
  double target_height = 0;  ///< target: of the sights with this height noted [m]
  std::vector<int> sights;   ///< reflector, edge: rows of the model, ascending
  std::string set;           ///< reflector: which these are, in words; edge: the target
  double penalty = 0;        ///< on w^2: it is the best of many of its family, one of which explains that by chance
  std::string rival;         ///< another kind of error that explains as much, in words; empty: none
  std::string equal;         ///< an error that does, and mended would put points elsewhere: neither is mended
  int equal_set_up = -1;     ///< its set-up
  std::vector<int> equal_sights;  ///< and its sights
  /// Rows of the problem that share it, with their coefficients.
  std::shared_ptr<const std::vector<std::pair<int, double>>> rows;
  int observations = 0;  ///< that share it; 0: no such error
  double w = 0;          ///< of the test, standard normal
  double size = 0;       ///< by which the observations are too large: [m], [1] or [rad]
  double sigma = 0;      ///< of the size

  std::tuple<Kind, int, int, double, std::vector<int>> key() const {
    return {kind, set_up, first, target_height, sights};
  }
};

class Adjuster {
 public:
  Adjuster(NetworkModel& model, const AdjustOptions& options) : m_(model), options_(options) {
    state_.removed.assign(m_.rows.size(), 0);
    find_set_ups_of_rows();
  }
  NetworkResult run(std::unique_ptr<KeptNetwork>* kept = nullptr);

 private:
  /// Solves; with `statistics` also cofactors and reliability. From `before`, if its network has the same unknowns.
  /// RankDefect becomes words.
  Pass adjust(bool statistics = true, const Pass* before = nullptr);
  /// What the readings of a pass say of the known points without what holds these: from the same equations, with the
  /// same factor. Empty where that is not what a free network would say: something else than a datum is left open.
  MeasuredControl measured_control(Pass& pass) const;
  [[noreturn]] static void fail_with(const std::vector<Finding>& defects, const std::string& advice);

  /// Inner constraints choose among positions of the whole network; they must not stand in for missing observations.
  void refuse_local_defects(const NetworkProblem& problem, const least_squares::Solution& solution) const;
  void add_statistics(Pass& pass) const;
  /// Initial values that were not related to each other may lead to a solution that is not the right one.
  void doubt(const least_squares::Solution& solution) const;
  [[noreturn]] void fail_to_converge(const NetworkProblem& problem, const least_squares::Solution& solution) const;
  double critical_w() const;
  /// Of removals and diagnoses: over all tests of the network together they err with probability removal_alpha.
  double critical_removal() const;

  /// Baarda's iterated data snooping: the worst goes, the rest is adjusted again, what was removed is tested again.
  void snoop(Pass& pass);
  int worst_row(const Pass& pass, const std::set<int>& kept) const;
  /// Readings of known points that explain more by themselves: such a point is wrong, and its readings are not.
  std::set<int> rows_of_wrong_points(const Pass& pass) const;
  std::pair<double, double> row_test(const Pass& pass, int row) const;

  /// Takes out what the check of the set-ups holds for wrong, and lets back in what proves innocent.
  void set_aside(Pass& pass);
  /// Iterates until no test fails: the hypothesis that explains most, one reading or an error in common, is mended.
  void mend(Pass& pass);
  std::vector<int> worst_rows(const Pass& pass, const std::set<int>& kept, int most) const;
  bool remove_together(Pass& pass, const std::vector<int>& rows, std::set<int>& restored);
  bool remove_worst(Pass& pass, int worst, std::set<int>& kept, std::set<int>& restored);
  /// Makes an unknown of the error, or a set-up of its own of the sights after the circle was turned.
  bool estimate(Pass& pass, const CommonError& error);
  void apply(const CommonError& error);
  void split_set_up(const CommonError& error);
  bool clean(const Pass& pass) const;
  int removed() const;
  void find_set_ups_of_rows();

  /// The plausible common error that explains more of the misfit than any single observation does; none: 0
  /// observations.
  CommonError largest_common_error(const Pass& pass) { return largest_common_error(pass, common_errors(pass)); }
  CommonError largest_common_error(const Pass& pass, std::vector<CommonError> errors,
                                   const std::set<int>& left_alone = {});
  CommonError as_good_as_a_reading(int suspect, double least, const std::vector<CommonError>& errors) const;
  /// Of those that explain as much as `worst`, one that puts points elsewhere when mended; none: no observations.
  CommonError rival_of(const Pass& pass, const CommonError& worst, std::vector<CommonError> errors);
  /// Rows of the model whose readings take part in the error.
  std::set<int> rows_of(int set_up, const std::vector<int>& sights) const;
  /// Rows that touch a point of an error that nobody can mend, and those of its set-ups that may be its shadow.
  std::set<int> rows_beside(const Pass& pass, const CommonError& error) const;
  struct MendedPlaces {
    double sum_of_squares = 0;
    std::vector<Eigen::Vector3d> places;
  };
  /// The network with this error mended; none: it cannot be adjusted so. Of a large network by the last equations.
  std::optional<MendedPlaces> mended_places(const Pass& pass, const CommonError& error);
  MendedPlaces places_by_equations(const Pass& pass, const CommonError& error) const;
  struct Elsewhere {
    int point = -1;  ///< of the model
    double by = 0;   ///< [m]
  };
  /// Of points that differ by so much, the one that does most clearly; none: no coordinate by its standard deviation.
  std::optional<Elsewhere> lies_elsewhere(const Pass& pass, const std::vector<Eigen::Vector3d>& differences) const;
  /// What a step of the unknowns moves each point by; zero where it has no unknown.
  std::vector<Eigen::Vector3d> of_points(const Pass& pass, const Eigen::VectorXd& step) const;
  static bool can_be_mended(CommonError::Kind kind) {
    return kind < CommonError::Kind::tilt || kind == CommonError::Kind::circle;
  }
  /// Hypotheses to be tested together, each with its rows of the problem and their coefficients.
  struct Hypothesis {
    CommonError error;  ///< kind and set-up; the test fills the rest
    std::vector<std::pair<int, double>> rows;
  };
  std::vector<CommonError> common_errors(const Pass& pass) const;
  std::vector<Hypothesis> target_heights(const Pass& pass) const;
  std::vector<Hypothesis> circles(const Pass& pass) const;
  /// A tilt, a sinking or twisting tripod of each set-up, a target whose distances come back from beside it.
  std::vector<CommonError> set_up_motions(const Pass& pass) const;
  void erase_chance(const Pass& pass, std::vector<CommonError>& motions) const;
  void add_tilts(const Pass& pass, const std::map<int, std::vector<int>>& of_set_up,
                 std::vector<CommonError>& found) const;
  Eigen::Vector2d effect_of_tilt(const Pass& pass, int row) const;
  Eigen::Vector3d sight_of(const Pass& pass, int row) const;  ///< from point to point [m]; NaN: no height
  /// One constant of some of the distances: another reflector stood there.
  std::vector<CommonError> reflectors(const Pass& pass) const;
  /// Index and collimation where a set-up was read in both faces and (almost) no target in both.
  std::vector<Hypothesis> face_errors(const Pass& pass) const;
  /// By how much a reading in face 1 is larger than without such an error of 1; 0 where it has none.
  double effect_of_face(const Pass& pass, int row, CommonError::Kind kind) const;
  /// Set-ups that were read in both faces and no target in both; empty: none.
  std::string tell_faces_apart(NetworkResult& result) const;
  std::vector<CommonError> test(const Pass& pass, const std::vector<Hypothesis>& hypotheses) const;
  std::string describe(const CommonError& error) const;
  /// Coefficient of an instrument height noted too large: minus the derivative of the observation by that height.
  double effect_of_instrument_height(const Pass& pass, int row) const;
  void report_common_error(const Pass& pass, const std::vector<CommonError>& common, NetworkResult& result);

  /// True if a point that had controlled observations has none any more.
  bool makes_uncontrolled(const Pass& before, const Pass& after) const;
  std::set<std::string> controlled_points(const Pass& pass) const;
  bool is_unknown(const std::string& id) const;
  void note_kept(int row, double w);
  void log_action(int row, bool restored, double w, double blunder, const Pass& pass);

  /// A removed observation that agrees with the network without it was masked by another blunder.
  void restore_innocent(Pass& pass, std::set<int>& restored);

  /// Test of an observation that took no part: its misfit against its own and the network's uncertainty. This is the w
  /// the observation had before it was removed, with all other removed ones out.
  least_squares::RowStatistics removed_statistics(const Pass& pass, int row) const;
  struct TakenOut {
    Eigen::VectorXd gradient;  ///< by the unknowns, in the unit of the reading
    double residual = 0, sigma = 0;
  };
  /// A reading that takes no part, at the places of a pass; none: it is not defined there.
  std::optional<TakenOut> taken_out(const Pass& pass, int row) const;

  /// A reading that is in and explains as much as one that was taken out, when that comes back in its place.
  struct RivalReading {
    int row = -1;      ///< of the model
    double alike = 0;  ///< by how much less it explains, of v'Pv
    int point = -1;    ///< of the model, that lies elsewhere most clearly
    double moved = 0;  ///< by so much [m]
  };
  std::vector<RivalReading> rivals_of(const Pass& pass, int row) const;
  /// Says which readings were taken out although others explain the misfit as well and would put points elsewhere; of
  /// points `told` more has been said.
  void tell_rival_readings(const Pass& pass, const std::set<std::string>& told);

  struct SightsOfPoint {
    std::map<int, std::vector<int>> of_set_up;  ///< rows of the model
    std::set<int> touched;                      ///< set-ups of which a reading was taken out
    int removed = 0;                            ///< readings
    bool angles = false;                        ///< not distances alone
  };
  /// Counts what was taken out of the sight (rows) of a set-up to the point.
  void count_removed(const std::vector<int>& sight, int set_up, SightsOfPoint& point) const;
  /// Points of which half of the set-ups that sighted them, or more, lost readings: one of them two or all of them one,
  /// and not distances alone.
  std::map<std::string, SightsOfPoint> sights_with_removed() const;
  /// Where a sight has its target, minus where the network has it [m]; none: not of three readings.
  std::optional<Eigen::Vector3d> seen_beside(const Pass& pass, const std::vector<int>& sight) const;
  /// Says of these points that they were at two places; their names.
  std::set<std::string> tell_contradicting_sights(const Pass& pass);

  /// Huber weights by iteration; observations they push out start as removed and must earn their way back.
  void remove_by_robust_weights();

  /// Förstner's iterated estimate; a group changes only if it has enough redundancy to say something.
  void estimate_variance_components(Pass& pass);
  NetworkResult report(Pass& pass);
  void report_common_estimates(const Pass& pass, const std::vector<CommonError>& common, NetworkResult& result) const;
  void report_points(const Pass& pass, NetworkResult& result) const;
  void report_set_ups(const Pass& pass, NetworkResult& result) const;
  void report_rows(const Pass& pass, NetworkResult& result) const;
  void report_pointings(const Pass& pass, NetworkResult& result) const;

  NetworkModel& m_;
  const AdjustOptions& options_;
  StochasticState state_;
  std::vector<SnoopingAction> actions_;
  std::vector<int> set_up_of_row_;  ///< number; -1: none
  /// Common errors that could not be estimated after all.
  std::set<std::tuple<CommonError::Kind, int, int, double, std::vector<int>>> refused_;
  bool stopped_ = false;   ///< an error was found that nobody can mend: what touches its points is as it was read
  std::string undecided_;  ///< of an error that was taken off, what explains the readings as well; empty: none
  std::string either_;     ///< readings of which one was taken out and another may be the wrong one; empty: none
};

}  // namespace plumbline::survey

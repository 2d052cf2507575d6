// Between the survey and the least-squares core: which point is what, which scalar is which row.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "least_squares/problem/solver.hpp"
#include "survey/model/map_frame.hpp"
#include "survey/model/network_result.hpp"
#include "survey/model/observation_equations.hpp"
#include "survey/model/observation_words.hpp"
#include "survey/start/approximate.hpp"

namespace plumbline::survey {

/// Everything decided before the first iteration.
struct NetworkModel {
  SurveyObservations survey;
  std::vector<MeanObservation> observations;  ///< those that take part first; see `dropped`
  std::vector<Eigen::Vector2d> lengths;       ///< horizontal and slope length of each observation's sight [m]
  std::vector<char> dropped;                  ///< one per observation: cannot be used (noted in findings)
  std::vector<std::string> ids;               ///< points of the network
  std::map<std::string, int> index;           ///< their numbers
  std::vector<Eigen::Vector3d> initial;       ///< [m]; 0 for unused components
  std::vector<std::array<CoordinateRole, 3>> roles;
  std::vector<double> orientations;          ///< initial, one per set-up
  std::vector<CommonEstimate> collimations;  ///< by readings in two faces [rad], one per set-up of the file
  bool starts_from_known_points = false;     ///< false: the frame of `initial` is arbitrary
  bool searched = false;                     ///< part of `initial` was computed
  bool unrelated = false;                    ///< `initial` is good enough to find rank defects only
  DatumMode datum = DatumMode::automatic;
  std::vector<std::string> datum_points;
  std::set<std::string> keyed_in;       ///< points that hold because their file says they are known
  std::shared_ptr<const MapFrame> map;  ///< null: a plane
  /// At which lengths are reduced to the map where neither end has a height [m]; NaN before it is needed.
  double mean_height = kNotGiven;
  std::vector<MapCorrection> corrections;  ///< of the map, one per observation; empty without
  bool curvature = false;
  double refraction_coefficient = 0.13;
  std::vector<Finding> findings;
  std::vector<int> set_aside;  ///< observations that the check of the set-ups takes for wrong, in the adjustment's hand
  std::vector<int> misnamed;   ///< of these, those that agree once they have another name
  std::vector<std::string> outlying_known;  ///< known points of which all readings were left out by drop_outlying()
  std::string contradiction;            ///< first of the mistakes of set-ups that are not mended, in words; empty: none
  std::vector<std::string> knocked;     ///< set-ups whose rounds do not repeat, a sentence each
  std::string known_beside_control;     ///< points that only the survey files have as known, in words; empty: none
  std::vector<ResultRow> rows;          ///< all scalars, statistics empty
  std::vector<int> first_row_of_group;  ///< first row of coordinate groups, vectors, local coordinates in that order
};

/// Set-ups, axes and observations that are referred to exist, values are finite: indices are as good as the file or
/// artifact they come from. Throws NetworkError; before anything else looks at what they refer to.
void check_indices(const SurveyObservations& survey);

/// Throws NetworkError.
/// `simple_start`: from the chain of set-ups where it gives every coordinate; false searches every place that the
/// observations leave.
NetworkModel make_model(const SurveyObservations& survey, const AdjustOptions& options, const ControlPoints& control,
                        bool simple_start = true);

/// A least-squares problem of the rows that are not removed, and the way back from its numbers to the model's.
struct NetworkProblem {
  least_squares::Problem problem;
  std::vector<int> point_blocks;                           ///< one per point
  std::vector<int> orientation_blocks;                     ///< one per set-up; -1
  std::vector<int> height_correction_blocks, tilt_blocks;  ///< one per set-up; -1
  std::vector<int> centring_blocks;                        ///< one per set-up; -1: none, or the point is the axis
  std::vector<std::pair<std::string, int>> common_blocks;  ///< name and block of scale etc.
  std::vector<int> extra_blocks;                           ///< one per StochasticState::extra
  std::vector<int> rows;                                   ///< row of the model of each row of the problem; -1: prior
  std::vector<std::string> block_names;  ///< of each residual block, for the tests of pointings: set-up
};

/// An error that readings of a set-up (-1: of all) have in common, estimated with the network. `scale` [1] and
/// `constant` [m] of distances, `index` [rad] of zenith angles, `height` [m] of the instrument, `target` [m] of the
/// targets of a set-up that were noted with one height; `face_index` of zenith angles and `collimation` of directions
/// [rad] have the other sign in face 2, and the second grows with the steepness of the sight; `reflector` [m] is that
/// of some distances.
struct ExtraUnknown {
  enum class Kind { constant, scale, index, height, target, face_index, collimation, reflector } kind = Kind::constant;
  int set_up = -1;
  double target_height = 0;  ///< as noted, of `target` [m]
  std::vector<int> sights;   ///< observations of the model, ascending, of `reflector`
};

struct StochasticState {
  std::vector<ExtraUnknown> extra;
  std::vector<char> removed;           ///< one per row of the model
  std::vector<double> weight_factors;  ///< one per row of the model; empty: 1
  std::array<double, kGroups> sigma_factors = {1, 1, 1, 1, 1, 1};
};

NetworkProblem make_problem(const NetworkModel& model, const AdjustOptions& options, const StochasticState& state);

/// Unknowns that carry the inner-constraint datum.
std::vector<int> datum_unknowns(const NetworkModel& model, const NetworkProblem& problem);

/// Residual block of one mean observation alone, with its a-priori sigma; used to test removed observations.
std::unique_ptr<ObservationBlock> single_block(const NetworkModel& model, const AdjustOptions& options,
                                               const StochasticState& state, const NetworkProblem& problem,
                                               int observation);

/// Names in words what the directions of a RankDefect are, with the points concerned.
std::vector<Finding> name_defects(const NetworkModel& model, const NetworkProblem& problem,
                                  const Eigen::MatrixXd& directions);

/// Of a free network's null space, what is not a movement of the network as a whole: points or parts that the inner
/// constraints would hold where no observation does. Empty: nothing.
std::vector<Finding> name_local_defects(const NetworkModel& model, const NetworkProblem& problem,
                                        const Eigen::MatrixXd& null_space);

/// Points that somebody knew: by the files, by control, in any coordinate.
std::set<std::string> known_ids(const NetworkModel& model);

/// What the readings say of the points that were known, weighted or held: those that do not stand first, worst first,
/// the others by their difference; `cofactors` a priori. A network in which nothing is wrong has one that does not
/// stand with a probability of 1 % at most, however many there are. `estimated`: the variance of unit weight is that of
/// the readings. Costs are linear in the points.
std::vector<KnownPoint> compare_with_known(const NetworkModel& model, const NetworkProblem& problem,
                                           const least_squares::Solution& solution,
                                           const least_squares::Cofactors& cofactors, bool estimated);

/// They as one finding: a warning where one of them does not stand.
Finding in_words(const std::vector<KnownPoint>& known);

}  // namespace plumbline::survey

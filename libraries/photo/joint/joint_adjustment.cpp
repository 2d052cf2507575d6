#include "photo/joint/joint_adjustment.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <stdexcept>

#include "photo/block/tag_block_model.hpp"

namespace plumbline::joint {
namespace {

using block::TagBlock;
using block::TagBlockResult;
using survey::KeptNetwork;

constexpr double still = 1e-5;            ///< standard deviations; no step that is larger may be left
constexpr double same_variance = 0.01;    ///< factors closer to 1 change nothing
constexpr double enough_redundancy = 10;  ///< for a variance component of the survey
constexpr double critical_w = 4.0;        ///< 0.006 % two-sided: a campaign has a thousand readings

/// What the network says of the marks, in the frame of the block.
struct Control {
  Eigen::VectorXd position;    ///< ŷ
  Eigen::MatrixXd covariance;  ///< Q_yy
  Eigen::MatrixXd cross;       ///< Q_xy: of all network unknowns with the marks
};

FramePoints in_network(const std::vector<Mark>& marks, const KeptNetwork& network, const KeptNetwork::Estimate& said,
                       double variance, Eigen::MatrixXd& cross) {
  FramePoints points;
  const auto n = static_cast<Eigen::Index>(3 * marks.size());
  points.covariance = Eigen::MatrixXd::Zero(n, n);
  cross = Eigen::MatrixXd::Zero(network.unknown_count(), n);
  std::vector<int> unknown, row;
  for (const Mark& mark : marks) {
    Eigen::Vector3d position = network.position(mark.id);
    const auto numbers = network.unknowns(mark.id);
    for (int c = 0; c < 3; ++c) {
      if (numbers[c] < 0) continue;
      position(c) += said.step(numbers[c]);
      unknown.push_back(numbers[c]);
      row.push_back(static_cast<int>(3 * points.positions.size()) + c);
    }
    points.positions.push_back(position);
  }
  points.covariance(row, row) = variance * said.cofactors(unknown, unknown);
  cross(Eigen::all, row) = variance * said.cofactors(Eigen::all, unknown);
  return points;
}

Control control_of(const std::vector<Mark>& marks, const KeptNetwork& network, const KeptNetwork::Estimate& said,
                   double variance, const FrameLink& link) {
  Control control;
  FrameGraph graph;
  graph.add(link);
  const FramePoints moved =
      graph.express(in_network(marks, network, said, variance, control.cross), link.to, link.from);
  const auto n = static_cast<Eigen::Index>(marks.size());
  control.position.resize(3 * n);
  for (Eigen::Index k = 0; k < n; ++k) {
    control.position.segment<3>(3 * k) = moved.positions[k];
    control.cross.middleCols<3>(3 * k) = (control.cross.middleCols<3>(3 * k) * link.linear().transpose()).eval();
  }
  control.covariance = block::regular_covariance(moved.covariance);
  return control;
}

/// The marks in the adjusted block: rows of Control, positions and covariance.
struct Adjusted {
  std::vector<int> rows;
  Eigen::VectorXd position;
  Eigen::MatrixXd covariance;
};

Adjusted marks_of(const std::vector<Mark>& marks, const TagBlockResult& result) {
  Adjusted adjusted;
  std::vector<int> anchors;
  for (size_t k = 0; k < marks.size(); ++k) {
    const auto at = std::find(result.plates.begin(), result.plates.end(), marks[k].plate);
    if (at == result.plates.end()) continue;  // surveyed, but in no photograph
    for (int c = 0; c < 3; ++c) {
      adjusted.rows.push_back(static_cast<int>(3 * k) + c);
      anchors.push_back(3 * static_cast<int>(at - result.plates.begin()) + c);
    }
  }
  adjusted.position = result.anchors(anchors);
  adjusted.covariance = result.anchor_covariance(anchors, anchors);
  return adjusted;
}

/// Gains of the network's unknowns by those of the marks: K = Q_xy Q_yy⁻¹.
Eigen::MatrixXd gain_of(const Control& control, const std::vector<int>& rows) {
  const Eigen::MatrixXd cross = control.cross(Eigen::all, rows);
  return control.covariance(rows, rows).llt().solve(cross.transpose()).transpose();
}

/// Without what was a blunder: later passes only go on from the first.
struct Sound {
  TagBlock block;
  std::vector<int> number;  ///< of its observations in the whole block
};

Sound without(const TagBlock& block, const std::vector<int>& rejected) {
  Sound sound{block, {}};
  sound.block.observations.clear();
  const std::set<int> out(rejected.begin(), rejected.end());
  for (int o = 0; o < static_cast<int>(block.observations.size()); ++o) {
    if (out.count(o)) continue;
    sound.number.push_back(o);
    sound.block.observations.push_back(block.observations[o]);
  }
  return sound;
}

const least_squares::VarianceComponent& control_group(const TagBlockResult& result) {
  for (const auto& group : result.groups)
    if (group.name == "control") return group;
  throw std::runtime_error("no mark of the network is in two photographs or more");
}

class Joint {
 public:
  Joint(const TagBlock& block, const std::vector<Mark>& marks, KeptNetwork& network, const FrameLink& link,
        const JointOptions& options)
      : marks_(marks),
        marks_at_first_(marks.size()),
        network_(network),
        link_(link),
        options_(options),
        sound_(without(block, {})) {
    sound_.block.control = {};
    for (const Mark& mark : marks) sound_.block.control.plates.push_back(mark.plate);
    result_.survey_variance = network.variance_factor();
  }

  JointResult run() {
    come_to_rest();
    while (leave_wrong_marks_out()) come_to_rest();
    result_.block.rejected = rejected_;
    result_.block.rejected_control = std::move(judged_.rejected_control);
    result_.block.control_doubts = std::move(judged_.control_doubts);
    result_.block.warnings = warnings_;  // later passes only repeat them
    result_.block.left_out.insert(result_.block.left_out.end(), without_.begin(), without_.end());
    for (auto& tag : result_.block.tags) tag.observation = sound_.number[tag.observation];
    fill_statistics();
    fill_survey();
    return std::move(result_);
  }

 private:
  void come_to_rest() {
    for (int passes = 1;; ++passes) {  // each time anew: marks that were left out took some before
      pass();
      const double moved = move_network();
      const bool weighted = settle_variance();
      ++result_.iterations;
      if (moved < still && weighted) break;
      if (passes >= options_.max_iterations)
        throw std::runtime_error("survey and photographs did not come to rest together in " + std::to_string(passes) +
                                 " relinearisations: they contradict each other far beyond their accuracy");
    }
  }

  /// Marks whose plates the photographs show elsewhere, tested as control where nothing moves any more: there the
  /// weights are what the readings ask for. What has been left out stays out.
  bool leave_wrong_marks_out() {
    block::TagBlockOptions how = options_.block;
    how.loss = block::RobustLoss::none;
    TagBlockResult tested = block::adjust_tag_block(sound_.block, how);
    const std::vector<block::RejectedControl> found = tested.rejected_control;
    judged_.control_doubts = std::move(tested.control_doubts);
    for (const std::string& warning : tested.warnings)
      if (std::find(warnings_.begin(), warnings_.end(), warning) == warnings_.end()) warnings_.push_back(warning);
    if (found.empty() || too_many_with(found)) return false;
    if (judged_.rejected_control.empty())  // readings of marks that are out are not held against the photographs
      result_.conspicuous = network_.conspicuous(covariance_, used_variance_, critical_w);
    without_.insert(without_.end(), tested.left_out.end() - static_cast<std::ptrdiff_t>(found.size()),
                    tested.left_out.end());
    for (const block::RejectedControl& point : found) {
      judged_.rejected_control.push_back(point);
      std::erase_if(marks_, [&](const Mark& mark) { return mark.plate == point.plate; });
      std::erase(sound_.block.control.plates, point.plate);
    }
    return true;
  }

  /// Each search leaves out a third of the marks that are left at the most; together they may be no more than a third
  /// of all, or it is no matter of single marks. What is out stays out, and that the block is wrong is said.
  bool too_many_with(const std::vector<block::RejectedControl>& found) {
    const std::size_t out = judged_.rejected_control.size() + found.size();
    if (3 * out <= marks_at_first_) return false;
    judged_.control_doubts.push_back({found.front().test, found.front().limit, found.front().freedom,
                                      "more than a third of the " + std::to_string(marks_at_first_) +
                                          " marks contradict the photographs: survey and photographs do not show the "
                                          "same state, or what is stated of "
                                          "survey, tags or camera is wrong"});
    return true;
  }

  void pass() {
    said_ = network_.estimate();
    control_ = control_of(marks_, network_, said_, result_.survey_variance, link_);
    sound_.block.control.position = control_.position;
    sound_.block.control.covariance = control_.covariance;
    block::TagBlockOptions how = options_.block;
    how.test_control = false;  // where it is at rest
    if (result_.iterations > 0) how.loss = block::RobustLoss::none;
    result_.block = block::adjust_tag_block(sound_.block, how);
    if (result_.iterations > 0) return;
    rejected_ = result_.block.rejected;
    warnings_ = result_.block.warnings;
    sound_ = without(sound_.block, rejected_);
    renumber_first_pass();
    for (size_t i = 0; i < sound_.block.images.size(); ++i)
      if (result_.block.cam_from_world[i]) sound_.block.images[i].cam_from_world = *result_.block.cam_from_world[i];
  }

  /// Tags of the first pass are numbered in the whole block, later ones in the sound one.
  void renumber_first_pass() {
    for (auto& tag : result_.block.tags)
      tag.observation = static_cast<int>(std::find(sound_.number.begin(), sound_.number.end(), tag.observation) -
                                         sound_.number.begin());
  }

  /// Largest step of a network unknown in its standard deviations.
  double move_network() {
    const Adjusted marks = marks_of(marks_, result_.block);
    const Eigen::MatrixXd gain = gain_of(control_, marks.rows);
    const Eigen::VectorXd step = said_.step + gain * (marks.position - control_.position(marks.rows));
    const Eigen::MatrixXd cofactors = result_.survey_variance * said_.cofactors;
    covariance_ = cofactors - gain * control_.cross(Eigen::all, marks.rows).transpose() +
                  gain * marks.covariance * gain.transpose();
    covariance_ = 0.5 * (covariance_ + covariance_.transpose()).eval();
    network_.move(step);
    const Eigen::VectorXd sigma = cofactors.diagonal().cwiseMax(1e-30).cwiseSqrt();
    return step.cwiseAbs().cwiseQuotient(sigma).maxCoeff();
  }

  /// The survey as one group: the readings' own sum of squares and redundancy, and those of the marks held against the
  /// photographs.
  least_squares::VarianceComponent survey_group() const {
    const auto& control = control_group(result_.block);
    least_squares::VarianceComponent group;
    group.name = "survey";
    group.rows = network_.observations();
    group.sum_of_squares = said_.sum_of_squares / used_variance_ + control.sum_of_squares;
    group.redundancy = network_.degrees_of_freedom() + control.redundancy;
    if (group.redundancy > 1e-6) group.factor = group.sum_of_squares / group.redundancy;
    return group;
  }

  /// True if the survey's variance stays as it is.
  bool settle_variance() {
    used_variance_ = result_.survey_variance;
    const auto group = survey_group();
    if (!options_.estimate_survey_variance || group.redundancy < enough_redundancy ||
        std::abs(group.factor - 1) < same_variance)
      return true;
    // No instrument is 20 times better or 1000 times worse than it says.
    const double next = std::clamp(result_.survey_variance * group.factor, 0.0025, 1e6);
    const bool stays = std::abs(next / result_.survey_variance - 1) < same_variance;
    if (!stays) result_.survey_variance = next;
    return stays;
  }

  void fill_survey() {
    const auto n = static_cast<Eigen::Index>(network_.ids().size());
    result_.survey_ids = network_.ids();
    result_.survey_positions.resize(3 * n);
    result_.survey_covariance = Eigen::MatrixXd::Zero(3 * n, 3 * n);
    std::vector<int> rows, unknowns;
    for (Eigen::Index k = 0; k < n; ++k) {
      const std::string& id = result_.survey_ids[k];
      result_.survey_positions.segment<3>(3 * k) = network_.position(id);
      const auto numbers = network_.unknowns(id);
      for (int c = 0; c < 3; ++c)
        if (numbers[c] >= 0) rows.push_back(static_cast<int>(3 * k) + c), unknowns.push_back(numbers[c]);
    }
    result_.survey_covariance(rows, rows) = covariance_(unknowns, unknowns);
    std::vector<Mark> whole;
    for (const std::string& id : network_.ids())
      if (network_.position(id).allFinite()) whole.push_back({id}), result_.surveyed_ids.push_back(id);
    FrameGraph graph;
    graph.add(link_);
    Eigen::MatrixXd unused;
    said_ = network_.estimate();
    result_.surveyed = graph.express(in_network(whole, network_, said_, used_variance_, unused), link_.to, link_.from);
    if (without_.empty()) result_.conspicuous = network_.conspicuous(covariance_, used_variance_, critical_w);
  }

  void fill_statistics() {
    TagBlockResult& block = result_.block;
    const auto survey = survey_group();
    const auto control = control_group(block);
    for (auto& group : block.groups)
      if (group.name == "control") group = survey;
    // Marks are unknowns of both sides, and were counted with rows of their own.
    block.observations += survey.rows - control.rows;
    block.degrees_of_freedom += network_.degrees_of_freedom();
    block.unknowns = block.observations - block.degrees_of_freedom + block.datum_defect;
    block.weighted_sum_of_squares += survey.sum_of_squares - control.sum_of_squares;
    block.sigma0 = std::sqrt(block.weighted_sum_of_squares / block.degrees_of_freedom);
    block.iterations += result_.iterations;
    block.tests.clear();
    block::test_groups(sound_.block, block);
  }

  std::vector<Mark> marks_;
  const std::size_t marks_at_first_;
  KeptNetwork& network_;
  const FrameLink& link_;
  const JointOptions& options_;
  Sound sound_;
  KeptNetwork::Estimate said_;
  Control control_;
  double used_variance_ = 1;
  Eigen::MatrixXd covariance_;  ///< of the network's unknowns
  std::vector<int> rejected_;
  std::vector<std::string> warnings_;
  TagBlockResult judged_;             ///< its control: what was left out, and what stays in doubt
  std::vector<std::string> without_;  ///< that, in words
  JointResult result_;
};

}  // namespace

JointResult adjust_jointly(const TagBlock& block, const std::vector<Mark>& marks, KeptNetwork& network,
                           const FrameLink& block_from_survey, const JointOptions& options) {
  if (options.block.weighting == block::TagBlockOptions::Weighting::lambda || options.block.free_network)
    throw std::runtime_error(
        "a joint adjustment needs weights by covariance and marks of the survey in the photographs");
  if (marks.size() < 3)
    throw std::runtime_error("a joint adjustment needs at least 3 marks of the network that carry a plate, found " +
                             std::to_string(marks.size()) + ": are the anchors of the plates called as in the survey?");
  return Joint(block, marks, network, block_from_survey, options).run();
}

}  // namespace plumbline::joint

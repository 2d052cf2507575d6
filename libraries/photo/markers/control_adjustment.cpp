#include "photo/markers/control_adjustment.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>

#include "geometry/median.hpp"
#include "geometry/statistics.hpp"
#include "photo/bundle/adjust.hpp"

namespace plumbline::markers {
namespace {

using bundle::Kind;

enum Group { group_ties, group_measured, group_control, group_interior };

Eigen::Vector3d sigma_of(const ControlPoint& p, const ControlOptions& options) {
  Eigen::Vector3d s = p.sigma;
  for (int k = 0; k < 3; ++k)
    if (!(s(k) > 0)) s(k) = std::isnan(s(k)) ? options.control_sigma : 1e-6;
  return s;
}

/// fy = fx unless the model has two, and a principal point and distortion that stay near where COLMAP had them.
bundle::Known interior_prior(int camera, const bundle::Camera& given, const BrownCamera& start) {
  const double extent = std::max(start.width, start.height);
  const auto values = start.parameters();
  bundle::Known term;
  term.refs = {{Kind::camera, camera}};
  const int all = bundle::value_count(given.lens), interior_count = static_cast<int>(start.names().size());
  term.target = Eigen::VectorXd::Zero(all);
  term.target.head(interior_count) = Eigen::Map<const Eigen::VectorXd>(values.data(), interior_count);
  term.group = group_interior;
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(interior_count - 1, all);
  rows(0, 0) = 1 / (1e-3 * extent), rows(0, 1) = -rows(0, 0);
  rows(1, 2) = rows(2, 3) = 1 / (0.01 * extent);
  for (int k = 4; k < interior_count; ++k)
    if (given.free[k]) rows(k - 1, k) = 1 / (k < 7 || start.lens == LensModel::fisheye ? 0.2 : 0.01);
  std::vector<Eigen::Index> used;
  for (Eigen::Index r = 0; r < rows.rows(); ++r)
    if (!rows.row(r).isZero(0)) used.push_back(r);
  term.whitening = rows(used, Eigen::all);
  return term;
}

class Adjustment {
 public:
  Adjustment(cameras::ColmapModel& model, std::vector<Target> targets, const ControlOptions& options,
             ControlResult& result)
      : model_(model), options_(options), result_(result), targets_(std::move(targets)) {}

  void run() {
    keep_what_can_be_computed();
    for (int pass = 0; pass < 2; ++pass) {
      build();
      bundle::MinimiseOptions how;
      how.max_iterations = options_.max_iterations;
      how.loss = {bundle::Loss::Kind::huber, 3};
      how.function_tolerance = 1e-9;
      bundle::minimise_schur(problem_, state_, how);
      store();
      reject();
    }
    solve();
    if (options_.robust_control) set_contradictions_aside();
    fill(*layout_);
    judge_what_took_no_part();
  }

 private:
  void solve() {
    build();
    layout_ = std::make_unique<bundle::Layout>(problem_);
    bundle::AdjustOptions how;
    how.minimise.max_iterations = options_.max_iterations;
    for (int step = 0; step < 4; ++step) {
      adjusted_ = bundle::adjust(problem_, *layout_, state_, how);
      reliability_ = bundle::reliability_of(problem_, adjusted_);
      state_ = adjusted_.state;
      if (step == 3 || !rescale()) break;
    }
    store();
  }

  /// The control point whose normalised residual is largest, and that.
  std::pair<size_t, double> worst_control() const {
    std::pair<size_t, double> worst{0, 0};
    for (size_t k = 0; k < problem_.known.size(); ++k) {
      if (problem_.known[k].group != group_control) continue;
      for (const auto& row : reliability_.known[k])
        if (std::abs(row.w) > worst.second)
          worst = {static_cast<size_t>(problem_.known[k].refs[0].index), std::abs(row.w)};
    }
    return worst;
  }

  size_t holding() const { return static_cast<size_t>(std::count_if(targets_.begin(), targets_.end(), holds)); }

  /// One after the other, the worst first, because a wrong point makes sound ones look wrong (Baarda 1968). False where
  /// more than a third would have to go.
  bool search_contradictions(std::vector<size_t>& aside) {
    const size_t all = holding();
    for (;;) {
      const auto [j, w] = worst_control();
      if (!(w > critical_w(holding()))) return true;
      if (3 * (aside.size() + 1) > all || holding() <= 3) return false;
      targets_[j].aside = true;
      aside.push_back(j);
      solve();
    }
  }

  void take_back(std::vector<size_t>& aside) {
    for (const size_t a : aside) targets_[a].aside = false;
    aside.clear();
  }

  /// How many times as much as their standard deviations say all of the control scatters; 1 where it may be chance. By
  /// the median, which a few wrong points hardly move (Hampel 1974), of what is no blunder even then. Control of which
  /// the worst was set aside fits by that: without it, noise would be sold as wrong points and small standard
  /// deviations.
  double scatter_of_control(const std::vector<size_t>& aside) const {
    std::vector<Eigen::Vector3d> points;
    for (size_t k = 0; k < problem_.known.size(); ++k) {
      if (problem_.known[k].group != group_control) continue;
      const auto& rows = reliability_.known[k];
      points.emplace_back(std::abs(rows[0].w), std::abs(rows[1].w), std::abs(rows[2].w));
    }
    for (const size_t a : aside)
      points.push_back(difference(a).cwiseQuotient(covariance_of_differences({a}).diagonal().cwiseSqrt()).cwiseAbs());
    const double redundancy = reliability_.groups[group_control].redundancy + 3 * static_cast<double>(aside.size());
    constexpr double of_sound = 0.6745, efficiency = 0.37, one_in_a_thousand = 3.09, few = 6;
    if (redundancy < few) return 1;
    double scatter = std::numeric_limits<double>::infinity();
    for (int step = 0; step < 10; ++step) {
      std::vector<double> w;
      for (const Eigen::Vector3d& point : points)
        if (!(point.maxCoeff() > critical_w(points.size()) * scatter)) w.insert(w.end(), point.begin(), point.end());
      if (w.empty()) break;
      scatter = median(w) / of_sound;
    }
    return scatter > 1 + one_in_a_thousand / std::sqrt(2 * efficiency * redundancy) ? scatter : 1;
  }

  /// Where more than a third would go, it is no matter of single points: all stay, and each that contradicts is named.
  void set_contradictions_aside() {
    const size_t all = holding();
    std::vector<size_t> aside;
    bool few = search_contradictions(aside);
    if (const double scatter = scatter_of_control(aside); scatter > 1) {
      take_back(aside);
      result_.control_scatter = scatter;
      solve();
      few = few && search_contradictions(aside);
    }
    if (!few) {
      const bool changed = !aside.empty();
      take_back(aside);
      if (changed) solve();
      return;
    }
    // What agrees with the result after all, once the worse ones are gone, takes part again.
    bool changed = false;
    for (const size_t a : aside) {
      const Eigen::MatrixXd covariance = covariance_of_differences({a});
      const Eigen::Vector3d d = difference(a);
      if (d.dot(covariance.ldlt().solve(d)) > block::check_limit(all)) continue;
      targets_[a].aside = false, changed = true;
    }
    if (changed) solve();
  }

  Eigen::Vector3d difference(size_t j) const {
    return state_.points[j] - (targets_[j].control->position - result_.origin);
  }

  /// Of points that took no part: the block's and the survey's, which have nothing in common.
  Eigen::MatrixXd covariance_of_differences(const std::vector<size_t>& points) const {
    std::vector<int> blocks;
    for (const size_t j : points) blocks.push_back(layout_->block({Kind::point, static_cast<int>(j)}));
    Eigen::MatrixXd covariance = adjusted_.cofactors->joint(blocks);
    for (size_t k = 0; k < points.size(); ++k)
      covariance.diagonal().segment<3>(3 * static_cast<Eigen::Index>(k)) += taken_sigma(points[k]).cwiseAbs2();
    return covariance;
  }

  void judge_what_took_no_part() {
    std::vector<size_t> checks, aside;
    for (size_t j = 0; j < targets_.size(); ++j)
      if (targets_[j].control && targets_[j].control->check)
        checks.push_back(j);
      else if (targets_[j].aside)
        aside.push_back(j);
    if (!checks.empty()) result_.checks = judged(checks);
    if (!aside.empty()) judged(aside);
  }

  block::CheckJudgement judged(const std::vector<size_t>& points) {
    std::vector<std::string> names;
    Eigen::VectorXd differences(3 * static_cast<Eigen::Index>(points.size()));
    for (const size_t j : points) {
      differences.segment<3>(3 * static_cast<Eigen::Index>(names.size())) = difference(j);
      names.push_back(targets_[j].name);
    }
    block::CheckJudgement found = block::judge_check_points(names, differences, covariance_of_differences(points));
    for (const auto& point : found.points)
      for (AdjustedControlPoint& p : result_.points)
        if (p.name == point.name) p.w = point.w, p.nees = point.nees, p.contradicts = point.contradicts;
    return found;
  }

  /// Drops rays to points behind their camera, points with too few rays, and photographs with too few points.
  void keep_what_can_be_computed() {
    std::erase_if(targets_, [&](Target& t) {
      std::erase_if(t.rays, [&](const Measured& m) {
        return (model_.images.at(m.image).cam_from_world * t.position).z() < 1e-6;
      });
      return t.rays.size() < 2 && !(holds(t) && !t.rays.empty());
    });
    std::map<std::uint32_t, int> rays;
    for (const Target& t : targets_)
      for (const Measured& m : t.rays) ++rays[m.image];
    for (const auto& [id, image] : model_.images) {
      if (rays[id] >= 4) {
        image_index_[id] = static_cast<int>(images_.size());
        images_.push_back(id);
      } else {
        result_.left_out.push_back(image.name + ": only " + std::to_string(rays[id]) +
                                   " of its points take part; it keeps its place in the model");
      }
    }
    for (Target& t : targets_) std::erase_if(t.rays, [&](const Measured& m) { return !image_index_.count(m.image); });
    for (const auto& [id, camera] : model_.cameras)
      if (std::any_of(images_.begin(), images_.end(), [&](auto i) { return model_.images.at(i).camera == id; })) {
        camera_index_[id] = static_cast<int>(cameras_.size());
        cameras_.push_back(id);
        starts_.push_back(camera.camera);
      }
  }

  /// Check points are held against what their file states: they are the evidence, not what is to be explained.
  Eigen::Vector3d taken_sigma(size_t j) const {
    const ControlPoint& point = *targets_[j].control;
    return sigma_of(point, options_) * (point.check ? 1 : result_.control_scatter);
  }

  static bool holds(const Target& t) { return t.control && !t.control->check && !t.aside; }

  /// Problem and state from the model and the targets as they are now.
  void build() {
    const double factors[] = {sigma_factor(group_ties), sigma_factor(group_measured)};
    problem_ = {}, state_ = {};
    problem_.groups = {
        {"tie points", factors[0]}, {"measured control points", factors[1]}, {"control"}, {"interior orientation"}};
    for (size_t c = 0; c < cameras_.size(); ++c) add_camera(c);
    for (const std::uint32_t id : images_) {
      const cameras::ColmapImage& image = model_.images.at(id);
      problem_.images.push_back({image.name, camera_index_.at(image.camera)});
      state_.images.emplace_back();
      state_.images.back().set(image.cam_from_world.rotation, image.cam_from_world.inverse().translation);
    }
    for (size_t j = 0; j < targets_.size(); ++j) add_target(static_cast<int>(j));
  }

  double sigma_factor(size_t group) const { return problem_.groups.empty() ? 1 : problem_.groups[group].sigma_factor; }

  void add_camera(size_t c) {
    const BrownCamera& camera = model_.cameras.at(cameras_[c]).camera;
    bundle::Camera entry{"camera " + std::to_string(cameras_[c]), bundle::lens_of(camera.lens), 0,
                         std::vector<bool>(camera.names().size(), options_.self_calibration)};
    entry.free.resize(static_cast<size_t>(bundle::value_count(entry.lens)), false);
    if (camera.lens == LensModel::brown && starts_[c].k3 == 0) entry.free[6] = false;
    state_.interiors.push_back({});
    const auto values = camera.parameters();
    std::copy(values.begin(), values.end(), state_.interiors.back().begin());
    if (options_.self_calibration) problem_.known.push_back(interior_prior(static_cast<int>(c), entry, starts_[c]));
    problem_.cameras.push_back(std::move(entry));
  }

  void add_target(int j) {
    const Target& t = targets_[j];
    problem_.points.push_back({t.name});
    state_.points.push_back(t.position);
    if (holds(t)) {
      bundle::Known term;
      term.refs = {{Kind::point, j}};
      term.target = t.control->position - result_.origin;
      term.whitening = Eigen::MatrixXd(taken_sigma(static_cast<size_t>(j)).cwiseInverse().asDiagonal());
      term.group = group_control;
      problem_.known.push_back(std::move(term));
    }
    for (const Measured& m : t.rays)
      problem_.image_points.push_back({image_index_.at(m.image), j, m.pixel, Eigen::Matrix2d::Identity() / m.sigma,
                                       t.control ? group_measured : group_ties, !t.control});
  }

  /// The state into the model and the targets.
  void store() {
    for (size_t i = 0; i < images_.size(); ++i) {
      RigidTransform& pose = model_.images.at(images_[i]).cam_from_world;
      pose.rotation = state_.images[i].rotation;
      pose.translation = -(pose.rotation * state_.images[i].position);
    }
    for (size_t c = 0; c < cameras_.size(); ++c) {
      std::array<double, InteriorOrientation::parameter_count> values;
      std::copy_n(state_.interiors[c].begin(), values.size(), values.begin());
      model_.cameras.at(cameras_[c]).camera.set_parameters(values);
    }
    for (size_t j = 0; j < targets_.size(); ++j) targets_[j].position = state_.points[j];
  }

  /// Takes out tie observations far off, and ties with a single ray left; control stays, its tests are in the result.
  void reject() {
    if (!(options_.reject_above > 0)) return;
    const bundle::Layout layout(problem_);
    std::vector<double> misfits, of_ties;
    bundle::Rows rows;
    for (const auto& term : problem_.image_points) {
      const bool seen = bundle::evaluate(problem_, layout, state_, term, false, rows);
      misfits.push_back(seen ? rows.values().norm() : std::numeric_limits<double>::infinity());
      if (term.group == group_ties) of_ties.push_back(misfits.back());
    }
    if (of_ties.empty()) return;
    const double limit = options_.reject_above * std::max(0.05, upper_median(std::move(of_ties)));
    size_t k = 0;  // observations stand in the order of the targets and their rays
    for (Target& t : targets_) {
      const size_t before = t.rays.size();
      const bool tie = !t.control;
      std::erase_if(t.rays, [&](const Measured&) { return misfits[k++] > limit && tie; });
      result_.rejected += static_cast<int>(before - t.rays.size());
    }
    std::erase_if(targets_, [](const Target& t) { return !t.control && t.rays.size() < 2; });
  }

  /// Weights of ties and measured control by their variance components; false, and nothing changed, when they stay.
  bool rescale() {
    std::array<double, 2> next{sigma_factor(group_ties), sigma_factor(group_measured)};
    double change = 0;
    for (const size_t g : {size_t{group_ties}, size_t{group_measured}}) {
      const auto& component = reliability_.groups[g];
      if (component.redundancy < 4 || !(component.factor > 0)) continue;
      next[g] = std::clamp(next[g] * std::sqrt(component.factor), 0.02, 1000.0);
      change = std::max(change, std::abs(next[g] / sigma_factor(g) - 1));
    }
    if (change < 0.01) return false;
    for (size_t g = 0; g < next.size(); ++g) problem_.groups[g].sigma_factor = next[g];
    return true;
  }

  void fill(const bundle::Layout& layout) {
    result_.n_observations = adjusted_.rows, result_.unknowns = adjusted_.unknowns;
    result_.degrees_of_freedom = adjusted_.redundancy();
    result_.weighted_sum_of_squares = adjusted_.sum_of_squares;
    result_.sigma0 = std::sqrt(adjusted_.sum_of_squares / std::max(1, result_.degrees_of_freedom));
    result_.groups = reliability_.groups;
    for (const size_t g : {size_t{group_ties}, size_t{group_measured}})
      result_.groups[g].factor *= sigma_factor(g) * sigma_factor(g);
    result_.groups[group_control].factor *= std::pow(result_.control_scatter, 2);
    std::erase_if(result_.groups, [](const auto& g) { return g.rows == 0; });
    const auto own = adjusted_.cofactors->all_own();
    const auto cofactor = [&](Kind kind, size_t index) -> const Eigen::MatrixXd& {
      return own[layout.block({kind, static_cast<int>(index)})];
    };
    for (size_t i = 0; i < images_.size(); ++i) result_.pose_covariance[images_[i]] = cofactor(Kind::image, i);
    for (size_t c = 0; c < cameras_.size(); ++c) {
      Eigen::MatrixXd& covariance = result_.camera_covariance[cameras_[c]];
      covariance = Eigen::MatrixXd::Zero(InteriorOrientation::parameter_count, InteriorOrientation::parameter_count);
      const auto& free = layout.free_values(static_cast<int>(c));
      if (!free.empty()) covariance(free, free) = cofactor(Kind::camera, c);
    }
    fill_residuals();
    for (size_t j = 0; j < targets_.size(); ++j) {
      if (targets_[j].control) {
        add_control_point(j, cofactor(Kind::point, j));
      } else {
        model_.points.at(targets_[j].tie).position = state_.points[j];
        ++result_.tie_points;
      }
    }
  }

  void fill_residuals() {
    for (size_t k = 0; k < problem_.known.size(); ++k)
      if (problem_.known[k].group == group_control)
        for (int c = 0; c < 3; ++c) w_[problem_.known[k].refs[0].index](c) = reliability_.known[k][c].w;
    double squares = 0;
    for (size_t k = 0; k < problem_.image_points.size(); ++k) {
      const bundle::ImagePoint& term = problem_.image_points[k];
      const auto& quality = reliability_.points[k];
      const std::uint32_t image = images_[term.image];
      ControlObservation seen{problem_.images[term.image].name,
                              problem_.points[term.point].name,
                              term.observed,
                              {-quality[0].residual, -quality[1].residual},
                              std::max(std::abs(quality[0].w), std::abs(quality[1].w)),
                              term.group == group_measured};
      const double square = seen.residual.squaredNorm();
      squares += square;
      result_.image_rms[image] += square, ++result_.image_points[image];
      squares_of_point_[term.point] += square;
      result_.observations.push_back(std::move(seen));
    }
    for (auto& [id, rms] : result_.image_rms) rms = std::sqrt(rms / (2 * result_.image_points[id]));
    const double count = 2 * static_cast<double>(problem_.image_points.size());
    result_.rms = count > 0 ? std::sqrt(squares / count) : 0;
  }

  void add_control_point(size_t j, const Eigen::MatrixXd& covariance) {
    const Target& t = targets_[j];
    AdjustedControlPoint p;
    p.name = t.name, p.check = t.control->check, p.used = true, p.aside = t.aside;
    if (t.aside) p.reason = "set aside: it contradicts the photographs and the other control points";
    p.surveyed = t.control->position, p.surveyed_sigma = taken_sigma(j);
    p.position = state_.points[j] + result_.origin;
    p.covariance = covariance;
    p.rays = static_cast<int>(t.rays.size());
    p.rms = std::sqrt(squares_of_point_[static_cast<int>(j)] /
                      (2.0 * static_cast<double>(std::max<size_t>(1, t.rays.size()))));
    p.largest_angle = largest_angle(model_, state_.points[j], t.rays);
    if (const auto w = w_.find(static_cast<int>(j)); w != w_.end()) p.w = w->second;
    result_.points.push_back(p);
  }

  cameras::ColmapModel& model_;
  const ControlOptions& options_;
  ControlResult& result_;
  std::vector<Target> targets_;
  std::vector<std::uint32_t> images_, cameras_;  ///< those that take part
  std::map<std::uint32_t, int> image_index_, camera_index_;
  std::vector<BrownCamera> starts_;  ///< the cameras as COLMAP had them
  bundle::Problem problem_;
  std::unique_ptr<bundle::Layout> layout_;
  bundle::State state_;
  bundle::Adjusted adjusted_;
  bundle::Reliability reliability_;
  std::map<int, Eigen::Vector3d> w_;
  std::map<int, double> squares_of_point_;
};

}  // namespace

double critical_w(size_t control_points) {
  const auto tests = static_cast<double>(3 * std::max<size_t>(1, control_points));
  return normal_quantile(1 + 0.5 * std::expm1(std::log1p(-1e-3) / tests));
}

void adjust_targets(cameras::ColmapModel& model, std::vector<Target> targets, const ControlOptions& options,
                    ControlResult& result) {
  Adjustment(model, std::move(targets), options, result).run();
}

}  // namespace plumbline::markers

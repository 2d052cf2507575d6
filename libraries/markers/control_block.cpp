#include "markers/control_block.hpp"

#include <ceres/autodiff_cost_function.h>
#include <ceres/rotation.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <deque>
#include <set>
#include <stdexcept>

#include "block/block_model.hpp"
#include "block/defects.hpp"
#include "block/row_quality.hpp"
#include "markers/robust_similarity.hpp"

namespace plumbline::markers {
namespace {

constexpr int interior_count = BrownCamera::parameter_count;
enum Group { group_ties, group_measured, group_control, group_interior };

/// A point in an image. Parameters: pose (projection centre, rotation vector), point, interior orientation.
struct RayCost {
  Eigen::Vector2d pixel;
  double sigma;
  const double* factor;
  const Eigen::Matrix3d* camera_matrix;

  template <typename T>
  bool operator()(const T* pose, const T* point, const T* interior, T* residual) const {
    const Eigen::Matrix<T, 3, 1> ray(point[0] - pose[0], point[1] - pose[1], point[2] - pose[2]);
    const Eigen::Matrix<T, 3, 1> approximate = camera_matrix->cast<T>() * ray;
    T p[3], computed[2];
    ceres::AngleAxisRotatePoint(pose + 3, approximate.data(), p);
    if (!(p[2] > T(1e-9))) return false;
    project_normalised(interior, T(p[0] / p[2]), T(p[1] / p[2]), computed);
    residual[0] = (computed[0] - T(pixel.x())) / T(sigma * *factor);
    residual[1] = (computed[1] - T(pixel.y())) / T(sigma * *factor);
    return true;
  }
};

struct SurveyCost {
  Eigen::Vector3d position, sigma;
  template <typename T>
  bool operator()(const T* point, T* residual) const {
    for (int k = 0; k < 3; ++k) residual[k] = (point[k] - T(position[k])) / T(sigma[k]);
    return true;
  }
};

/// fy = fx unless the model has two, and a principal point and distortion that stay near where COLMAP had them.
struct InteriorCost {
  std::array<double, interior_count> start;
  double extent;
  template <typename T>
  bool operator()(const T* x, T* residual) const {
    residual[0] = (x[0] - x[1] - T(start[0] - start[1])) / T(1e-3 * extent);
    residual[1] = (x[2] - T(start[2])) / T(0.01 * extent);
    residual[2] = (x[3] - T(start[3])) / T(0.01 * extent);
    for (int k = 4; k < interior_count; ++k)
      residual[k - 1] = (x[k] - T(start[static_cast<size_t>(k)])) / T(k < 7 ? 0.2 : 0.01);
    return true;
  }
};

struct Measured {
  std::uint32_t image;
  Eigen::Vector2d pixel;
  double sigma;
};

/// A point with its rays.
struct Target {
  std::string name;
  Eigen::Vector3d position;
  std::vector<Measured> rays;
  const ControlPoint* control = nullptr;
  std::int64_t tie = -1;
};

/// Linear intersection of the rays of a point; nothing if they are nearly parallel.
std::optional<Eigen::Vector3d> intersect(const ColmapModel& model, const std::vector<Measured>& rays) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Measured& m : rays) {
    const ColmapImage& image = model.images.at(m.image);
    const auto q = unproject(model.cameras.at(image.camera).camera, m.pixel);
    if (!q) continue;
    const RigidTransform world_from_cam = image.cam_from_world.inverse();
    const Eigen::Vector3d d = (world_from_cam.rotation * q->homogeneous().eval()).normalized();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - d * d.transpose();
    normal += across, right += across * world_from_cam.translation;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spectrum(normal);
  if (rays.size() < 2 || spectrum.eigenvalues()(0) < 1e-5) return std::nullopt;
  return normal.ldlt().solve(right);
}

double largest_angle(const ColmapModel& model, const Eigen::Vector3d& point, const std::vector<Measured>& rays) {
  double smallest = 1;
  for (size_t i = 0; i < rays.size(); ++i)
    for (size_t j = i + 1; j < rays.size(); ++j) {
      const auto direction = [&](const Measured& m) -> Eigen::Vector3d {
        return (model.images.at(m.image).cam_from_world.inverse().translation - point).normalized();
      };
      smallest = std::min(smallest, direction(rays[i]).dot(direction(rays[j])));
    }
  return std::acos(std::clamp(smallest, -1.0, 1.0));
}

/// Images by name, and by base name where that is unique.
std::map<std::string, std::uint32_t> names_of(const ColmapModel& model) {
  std::map<std::string, std::uint32_t> names;
  std::map<std::string, int> times;
  for (const auto& [id, image] : model.images) {
    const size_t slash = image.name.find_last_of('/');
    if (slash != std::string::npos)
      ++times[image.name.substr(slash + 1)], names.emplace(image.name.substr(slash + 1), id);
  }
  for (const auto& [name, count] : times)
    if (count > 1) names.erase(name);
  for (const auto& [id, image] : model.images) names[image.name] = id;
  return names;
}

std::vector<Target> targets_of(const ColmapModel& model, const std::vector<ControlPoint>& control,
                               const std::vector<ImagePoint>& measured, const ControlOptions& options,
                               ControlResult& result) {
  const auto names = names_of(model);
  std::vector<Target> targets;
  std::map<std::string, size_t> index;
  for (const ControlPoint& p : control)
    index[p.name] = targets.size(), targets.push_back({p.name, p.position, {}, &p, -1});
  std::set<std::string> unknown_images, unknown_points;
  std::set<std::pair<std::string, std::uint32_t>> seen;
  for (const ImagePoint& m : measured) {
    const size_t slash = m.image.find_last_of('/');
    auto image = names.find(m.image);
    if (image == names.end() && slash != std::string::npos) image = names.find(m.image.substr(slash + 1));
    const auto target = index.find(m.point);
    if (target == index.end()) {
      unknown_points.insert(m.point);
    } else if (image == names.end()) {
      unknown_images.insert(m.image);
    } else if (!seen.insert({m.point, image->second}).second) {
      result.warnings.push_back("point " + m.point + " is measured twice in " + m.image +
                                "; the first measurement is used");
    } else {
      targets[target->second].rays.push_back({image->second, m.pixel, m.sigma > 0 ? m.sigma : options.measured_sigma});
    }
  }
  const auto tell = [&](const std::set<std::string>& names_, const std::string& what) {
    if (names_.empty()) return;
    std::string list;
    size_t shown = 0;
    for (const auto& n : names_)
      if (++shown <= 8) list += (list.empty() ? "" : ", ") + n;
    result.left_out.push_back(what + ": " + list + (names_.size() > 8 ? ", ..." : ""));
  };
  tell(unknown_images, "measurements in photographs that the model does not hold");
  tell(unknown_points, "measured points that are not in the control file");
  if (measured.size() && std::all_of(targets.begin(), targets.end(), [](const Target& t) { return t.rays.empty(); }))
    throw std::runtime_error(
        "no measurement belongs to a photograph of the model and a point of the control file. The model's photographs "
        "are called like " +
        model.images.begin()->second.name + ", the measurements name " + measured.front().image);
  return targets;
}

/// The tie points with the longest tracks.
void add_ties(const ColmapModel& model, const ControlOptions& options, std::vector<Target>& targets) {
  std::vector<std::pair<size_t, std::int64_t>> order;
  for (const auto& [id, point] : model.points)
    if (point.track.size() >= 2) order.emplace_back(point.track.size(), id);
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  // Long tracks alone would leave photographs without ties: every photograph gets its share.
  std::map<std::uint32_t, int> held;
  const int share =
      std::max<int>(12, 3 * options.max_tie_points / std::max<int>(1, static_cast<int>(model.images.size())));
  std::set<std::int64_t> chosen;
  for (const auto& [length, id] : order) {
    if (static_cast<int>(chosen.size()) >= options.max_tie_points) break;
    const auto& track = model.points.at(id).track;
    if (std::none_of(track.begin(), track.end(), [&](const auto& t) { return held[t.first] < share; })) continue;
    chosen.insert(id);
    for (const auto& t : track) ++held[t.first];
  }
  for (const std::int64_t id : chosen) {
    const ColmapPoint& point = model.points.at(id);
    Target target{"tie " + std::to_string(id), point.position, {}, nullptr, id};
    std::set<std::uint32_t> images;
    for (const auto& [image, feature] : point.track)
      if (images.insert(image).second)
        target.rays.push_back({image, model.images.at(image).features[feature].pixel, options.tie_sigma});
    targets.push_back(target);
  }
}

void transform(ColmapModel& model, const SimilarityMotion& motion) {
  for (auto& [id, image] : model.images) {
    const Eigen::Vector3d centre = motion * image.cam_from_world.inverse().translation;
    image.cam_from_world.rotation = (image.cam_from_world.rotation * motion.rotation.conjugate()).normalized();
    image.cam_from_world.translation = -(image.cam_from_world.rotation * centre);
  }
  for (auto& [id, point] : model.points) point.position = motion * point.position;
}

/// The model into the survey's frame (minus `origin`) by its control points, without those that disagree grossly.
void align(ColmapModel& model, std::vector<Target>& targets, ControlResult& result) {
  std::vector<Eigen::Vector3d> from, to;
  std::vector<Target*> used;
  for (Target& t : targets) {
    if (!t.control) continue;
    const auto at = intersect(model, t.rays);
    if (!at) continue;
    t.position = *at;
    if (t.control->check) continue;
    from.push_back(*at), to.push_back(t.control->position - result.origin), used.push_back(&t);
  }
  if (from.size() < 3)
    throw std::runtime_error(std::to_string(from.size()) +
                             " control points are measured in two photographs or more; at least 3 are needed that "
                             "are not on one line, better 5 or more spread over the object");
  RobustSimilarity fit;
  try {
    fit = fit_similarity_robustly(from, to, 0.05);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error("the model cannot be brought to the control points: " + std::string(error.what()));
  }
  for (size_t m = 0; m < used.size(); ++m) {
    if (fit.agrees[m]) continue;
    result.warnings.push_back("control point " + used[m]->name + " lies " + std::to_string(fit.distances[m]) +
                              " m from where the model and the other control points have it: it is left out. Is "
                              "its name or a measurement wrong?");
    used[m]->rays.clear();
  }
  result.scale = fit.motion.scale;
  transform(model, fit.motion);
  for (Target& t : targets) t.position = fit.motion * t.position;
}

class Adjustment {
 public:
  Adjustment(ColmapModel& model, std::vector<Target> targets, const ControlOptions& options, ControlResult& result)
      : model_(model), options_(options), result_(result) {
    for (Target& t : targets) {
      // A point behind one of its cameras cannot be computed.
      std::erase_if(
          t.rays, [&](const Measured& m) { return (model.images.at(m.image).cam_from_world * t.position).z() < 1e-6; });
      if (t.rays.size() >= 2 || (t.control && !t.rays.empty() && !t.control->check)) targets_.push_back(std::move(t));
    }
    std::map<std::uint32_t, int> rays;
    for (const Target& t : targets_)
      for (const Measured& m : t.rays) ++rays[m.image];
    for (const auto& [id, image] : model.images) {
      if (rays[id] >= 4) {
        index_[id] = images_.size();
        images_.push_back(id);
        const Eigen::Vector3d c = image.cam_from_world.inverse().translation;
        poses_.push_back({c.x(), c.y(), c.z(), 0, 0, 0});
        rotations_.push_back(image.cam_from_world.rotation);
      } else {
        result.left_out.push_back(image.name + ": only " + std::to_string(rays[id]) +
                                  " of its points take part; it keeps its place in the model");
      }
    }
    matrices_.resize(images_.size());
    for (Target& t : targets_) {
      std::erase_if(t.rays, [&](const Measured& m) { return !index_.count(m.image); });
      points_.push_back({t.position.x(), t.position.y(), t.position.z()});
    }
    for (const auto& [id, camera] : model.cameras) interiors_[id] = camera.camera.parameters();
    fold();
  }

  void run() {
    for (int pass = 0; pass < 2; ++pass) {
      adjust::BlockModel model;
      build(model);
      model.minimise(options_.max_iterations, adjust::RobustLoss::huber, 3);
      fold();
      reject(model);
    }
    std::vector<std::string> names;
    for (const auto id : images_) names.push_back(model_.images.at(id).name);
    for (int step = 0; step < 4; ++step) {
      model_now_ = std::make_unique<adjust::BlockModel>();
      build(*model_now_);
      block_ = adjust::adjust_to_convergence(
          *model_now_, options_.max_iterations, [&] { fold(); }, [](adjust::PartitionedSystem&) {},
          [&](const adjust::PartitionedSystem& linear, const adjust::ReducedSystem& reduced) {
            adjust::require_full_rank(linear, reduced, names, model_now_->kept_labels());
          });
      cofactors_ = residual_cofactors(block_.linear, block_.reduced, block_.solution);
      groups_ = variance_components(block_.linear, cofactors_);
      double change = 0;
      for (const size_t g : {size_t{group_ties}, size_t{group_measured}}) {
        if (groups_[g].redundancy < 4 || !(groups_[g].factor > 0)) continue;
        const double next = std::clamp(factors_[g] * std::sqrt(groups_[g].factor), 0.02, 1000.0);
        change = std::max(change, std::abs(next / factors_[g] - 1));
        if (step < 3) factors_[g] = next;
      }
      if (change < 0.01) break;
    }
    finish();
  }

 private:
  void fold() {
    for (size_t i = 0; i < poses_.size(); ++i) {
      rotations_[i] =
          (quaternion_from_rotation_vector({poses_[i][3], poses_[i][4], poses_[i][5]}) * rotations_[i]).normalized();
      matrices_[i] = rotations_[i].toRotationMatrix();
      poses_[i][3] = poses_[i][4] = poses_[i][5] = 0;
    }
  }

  bool holds(const Target& t) const { return t.control && !t.control->check; }

  Eigen::Vector3d sigma_of(const ControlPoint& p) const {
    Eigen::Vector3d s = p.sigma;
    for (int k = 0; k < 3; ++k)
      if (!(s(k) > 0)) s(k) = std::isnan(s(k)) ? options_.control_sigma : 1e-6;
    return s;
  }

  void build(adjust::BlockModel& model) {
    labels_.clear(), point_columns_.clear();
    for (const char* name : {"tie points", "measured control points", "control", "interior orientation"})
      model.add_group(name);
    for (auto& pose : poses_) model.add_pose(pose.data());
    for (auto& [id, interior] : interiors_) {
      std::vector<bool> free(interior_count, options_.self_calibration);
      if (model_.cameras.at(id).camera.k3 == 0) free[6] = false;
      const bool used =
          std::any_of(images_.begin(), images_.end(), [&](auto i) { return model_.images.at(i).camera == id; });
      if (!used) free.assign(interior_count, false);
      std::vector<std::string> labels;
      for (const char* name : BrownCamera::parameter_names)
        labels.push_back(std::string(name) + " of camera " + std::to_string(id));
      interior_columns_[id] = model.add_kept(interior.data(), free, labels);
      const BrownCamera& camera = model_.cameras.at(id).camera;
      if (options_.self_calibration && used)
        model.add_term(std::make_unique<ceres::AutoDiffCostFunction<InteriorCost, 8, interior_count>>(new InteriorCost{
                           camera.parameters(), static_cast<double>(std::max(camera.width, camera.height))}),
                       {interior.data()}, group_interior, 0);
    }
    for (size_t j = 0; j < targets_.size(); ++j) {
      const Target& t = targets_[j];
      point_columns_.push_back(
          model.add_kept(points_[j].data(), {true, true, true}, {"x of " + t.name, "y of " + t.name, "z of " + t.name})
              .front());
      if (holds(t))
        model.add_term(std::make_unique<ceres::AutoDiffCostFunction<SurveyCost, 3, 3>>(
                           new SurveyCost{t.control->position - result_.origin, sigma_of(*t.control)}),
                       {points_[j].data()}, group_control, static_cast<int>(j));
      for (size_t r = 0; r < t.rays.size(); ++r) {
        const Measured& m = t.rays[r];
        const size_t i = index_.at(m.image);
        const size_t group = t.control ? group_measured : group_ties;
        model.add_term(std::make_unique<ceres::AutoDiffCostFunction<RayCost, 2, 6, 3, interior_count>>(
                           new RayCost{m.pixel, m.sigma, &factors_[group], &matrices_[i]}),
                       {poses_[i].data(), points_[j].data(), interiors_.at(model_.images.at(m.image).camera).data()},
                       static_cast<int>(group), static_cast<int>(labels_.size()), !t.control);
        labels_.emplace_back(j, r);
      }
    }
  }

  /// Tie observations far off; control stays, its tests are in the result.
  void reject(const adjust::BlockModel& model) {
    std::vector<double> fits;
    const auto linear = model.linearise();
    for (const auto& rows : linear.observations)
      if (rows.group == group_ties) fits.push_back(rows.misclosure.norm());
    if (fits.empty() || !(options_.reject_above > 0)) return;
    std::nth_element(fits.begin(), fits.begin() + static_cast<std::ptrdiff_t>(fits.size() / 2), fits.end());
    const double limit = options_.reject_above * std::max(0.05, fits[fits.size() / 2]);
    std::vector<std::set<size_t>> drop(targets_.size());
    for (const auto& rows : linear.observations)
      if (rows.group == group_ties && rows.misclosure.norm() > limit) {
        const auto [j, r] = labels_[static_cast<size_t>(rows.label)];
        drop[j].insert(r);
      }
    std::vector<Target> targets;
    std::deque<std::array<double, 3>> points;
    for (size_t j = 0; j < targets_.size(); ++j) {
      Target t = targets_[j];
      result_.rejected += static_cast<int>(drop[j].size());
      for (auto r = drop[j].rbegin(); r != drop[j].rend(); ++r)
        t.rays.erase(t.rays.begin() + static_cast<std::ptrdiff_t>(*r));
      if (!t.control && t.rays.size() < 2) continue;
      targets.push_back(t), points.push_back(points_[j]);
    }
    targets_ = targets, points_ = points;
  }

  void finish() {
    const Eigen::MatrixXd& cofactor = block_.solution.kept_cofactor;
    result_.n_observations = block_.linear.row_count(), result_.unknowns = block_.linear.unknown_count();
    result_.degrees_of_freedom = block_.linear.redundancy();
    for (auto& g : groups_) result_.weighted_sum_of_squares += g.sum_of_squares;
    result_.sigma0 = std::sqrt(result_.weighted_sum_of_squares / std::max(1, result_.degrees_of_freedom));
    groups_[group_ties].factor *= factors_[group_ties] * factors_[group_ties];
    groups_[group_measured].factor *= factors_[group_measured] * factors_[group_measured];
    std::erase_if(groups_, [](const auto& g) { return g.rows == 0; });
    result_.groups = groups_;
    for (size_t i = 0; i < images_.size(); ++i) {
      ColmapImage& image = model_.images.at(images_[i]);
      image.cam_from_world.rotation = rotations_[i];
      image.cam_from_world.translation = -(rotations_[i] * Eigen::Vector3d(poses_[i][0], poses_[i][1], poses_[i][2]));
      result_.pose_covariance[images_[i]] = block_.solution.eliminated_cofactor[i];
    }
    for (auto& [id, interior] : interiors_) {
      model_.cameras.at(id).camera.set_parameters(interior);
      Eigen::MatrixXd c = Eigen::MatrixXd::Zero(interior_count, interior_count);
      for (int r = 0; r < interior_count; ++r)
        for (int k = 0; k < interior_count; ++k)
          if (interior_columns_[id][static_cast<size_t>(r)] >= 0 && interior_columns_[id][static_cast<size_t>(k)] >= 0)
            c(r, k) =
                cofactor(interior_columns_[id][static_cast<size_t>(r)], interior_columns_[id][static_cast<size_t>(k)]);
      result_.camera_covariance[id] = c;
    }
    fill_residuals();
    fill_points(cofactor);
  }

  void fill_residuals() {
    double squares = 0;
    size_t count = 0;
    for (size_t k = 0; k < block_.linear.observations.size(); ++k) {
      const auto& rows = block_.linear.observations[k];
      if (rows.group == group_control) {
        const Target& t = targets_[static_cast<size_t>(rows.label)];
        const auto quality =
            adjust::row_quality(Eigen::MatrixXd(sigma_of(*t.control).asDiagonal()), rows, cofactors_[k]);
        for (int c = 0; c < 3; ++c) w_[static_cast<size_t>(rows.label)](c) = quality[static_cast<size_t>(c)].w;
      }
      if (rows.group != group_ties && rows.group != group_measured) continue;
      const auto [j, r] = labels_[static_cast<size_t>(rows.label)];
      const Measured& m = targets_[j].rays[r];
      const double sigma = m.sigma * factors_[static_cast<size_t>(rows.group)];
      const auto quality =
          adjust::row_quality(Eigen::MatrixXd(sigma * Eigen::Matrix2d::Identity()), rows, cofactors_[k]);
      ControlObservation seen{model_.images.at(m.image).name,
                              targets_[j].name,
                              m.pixel,
                              {-quality[0].residual, -quality[1].residual},
                              std::max(std::abs(quality[0].w), std::abs(quality[1].w)),
                              targets_[j].control != nullptr};
      const double square = seen.residual.squaredNorm();
      squares += square, ++count;
      result_.image_rms[m.image] += square, ++result_.image_points[m.image];
      rms_[j] += square;
      result_.observations.push_back(seen);
    }
    for (auto& [id, rms] : result_.image_rms) rms = std::sqrt(rms / (2 * result_.image_points[id]));
    result_.rms = count ? std::sqrt(squares / (2 * static_cast<double>(count))) : 0;
  }

  void fill_points(const Eigen::MatrixXd& cofactor) {
    for (size_t j = 0; j < targets_.size(); ++j) {
      const Target& t = targets_[j];
      const Eigen::Vector3d at(points_[j][0], points_[j][1], points_[j][2]);
      if (!t.control) {
        model_.points.at(t.tie).position = at;
        ++result_.tie_points;
        continue;
      }
      AdjustedControlPoint p;
      p.name = t.name, p.check = t.control->check, p.used = true;
      p.surveyed = t.control->position, p.surveyed_sigma = sigma_of(*t.control);
      p.position = at + result_.origin;
      p.covariance = cofactor.block<3, 3>(point_columns_[j], point_columns_[j]);
      p.rays = static_cast<int>(t.rays.size());
      p.rms = std::sqrt(rms_[j] / (2.0 * static_cast<double>(std::max<size_t>(1, t.rays.size()))));
      p.largest_angle = largest_angle(model_, at, t.rays);
      if (const auto w = w_.find(j); w != w_.end()) p.w = w->second;
      result_.points.push_back(p);
    }
  }

  ColmapModel& model_;
  const ControlOptions& options_;
  ControlResult& result_;
  std::vector<Target> targets_;
  std::vector<std::uint32_t> images_;
  std::map<std::uint32_t, size_t> index_;
  std::vector<std::array<double, 6>> poses_;
  std::vector<Eigen::Quaterniond> rotations_;
  std::vector<Eigen::Matrix3d> matrices_;
  std::deque<std::array<double, 3>> points_;
  std::map<std::uint32_t, std::array<double, interior_count>> interiors_;
  std::map<std::uint32_t, std::vector<int>> interior_columns_;
  std::vector<int> point_columns_;
  std::vector<std::pair<size_t, size_t>> labels_;
  std::array<double, 2> factors_{1, 1};
  std::unique_ptr<adjust::BlockModel> model_now_;
  adjust::AdjustedBlock block_;
  std::vector<Eigen::MatrixXd> cofactors_;
  std::vector<adjustment::VarianceComponent> groups_;
  std::map<size_t, Eigen::Vector3d> w_;
  std::map<size_t, double> rms_;
};

/// All control points together: standard deviations that nobody stated, or stated too small.
void warn_about_control(const std::vector<ControlPoint>& control, const ControlOptions& options,
                        ControlResult& result) {
  constexpr double limit = 9;  // three times the stated standard deviations
  const bool assumed =
      std::any_of(control.begin(), control.end(), [](const ControlPoint& p) { return std::isnan(p.sigma.sum()); });
  for (const auto& group : result.groups)
    if (group.name == "control" && group.redundancy > 2 && group.factor > limit)
      result.warnings.push_back("the control points fit " + std::to_string(std::sqrt(group.factor)) +
                                " times worse than their standard deviations" +
                                (assumed ? ", which their file does not state (" +
                                               std::to_string(options.control_sigma) + " m is assumed): say them"
                                         : ": they are too small, or points are confused") +
                                ". All standard deviations of the result are too small by that");
}

}  // namespace

ControlResult adjust_with_control(const ColmapModel& model, const std::vector<ControlPoint>& control,
                                  const std::vector<ImagePoint>& measured, const ControlOptions& options) {
  ControlResult result;
  result.model = model;
  // Coordinates of a site may have seven digits: computed near the origin of the control.
  for (const auto& p : control) result.origin += p.position / static_cast<double>(control.size());
  result.origin = result.origin.array().round();
  std::vector<Target> targets = targets_of(model, control, measured, options, result);
  align(result.model, targets, result);
  const size_t controls = targets.size();
  add_ties(result.model, options, targets);
  std::set<std::int64_t> chosen;
  for (size_t j = controls; j < targets.size(); ++j) chosen.insert(targets[j].tie);
  Adjustment(result.model, std::move(targets), options, result).run();
  for (auto& [id, point] : result.model.points) {  // the others follow the cameras
    if (chosen.count(id)) continue;
    std::vector<Measured> rays;
    for (const auto& [image, feature] : point.track)
      rays.push_back({image, result.model.images.at(image).features[feature].pixel, 1});
    if (const auto at = intersect(result.model, rays)) point.position = *at;
  }
  for (auto& [id, image] : result.model.images)
    image.cam_from_world.translation -= image.cam_from_world.rotation * result.origin;
  for (auto& [id, point] : result.model.points) point.position += result.origin;
  for (const auto& p : control) {
    const bool there =
        std::any_of(result.points.begin(), result.points.end(), [&](const auto& q) { return q.name == p.name; });
    if (there) continue;
    AdjustedControlPoint unused;
    unused.name = p.name, unused.check = p.check, unused.surveyed = p.position, unused.surveyed_sigma = p.sigma;
    unused.position.setConstant(std::nan(""));
    unused.reason = "it is not measured in two photographs of the model, or disagrees with the others";
    result.points.push_back(unused);
    result.left_out.push_back("control point " + p.name + ": " + unused.reason);
  }
  warn_about_control(control, options, result);
  for (const auto& p : result.points)
    if (p.used && !p.check && p.w.cwiseAbs().maxCoeff() > 3.29)
      result.warnings.push_back("control point " + p.name +
                                " contradicts the photographs: |w| = " + std::to_string(p.w.cwiseAbs().maxCoeff()) +
                                ". Check its coordinates, its name and its measurements");
  return result;
}

}  // namespace plumbline::markers

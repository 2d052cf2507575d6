#include "photo/markers/rig_model.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>

#include "geometry/median.hpp"

namespace plumbline::markers {
namespace {

bundle::Placement placed(const RigidTransform& t) {
  bundle::Placement placement;
  placement.set(t.rotation, t.inverse().translation);
  return placement;
}

}  // namespace

Eigen::Vector2d RigModel::residual_of(const bundle::Layout& layout, size_t label) const {
  const bundle::ImagePoint& point = problem.image_points[label];
  bundle::Rows rows;
  if (!bundle::evaluate(problem, layout, state, point, false, rows))
    throw std::runtime_error("the board lies behind the camera of " + problem.images[point.image].name);
  return rows.values() / point.whitening(0, 0);
}

RigModels::RigModels(const std::vector<RigCamera>& cameras, const std::vector<std::vector<std::string>>& moments,
                     const CalibrationOptions& options)
    : cameras_(cameras), moments_(moments), options_(options) {
  Eigen::AlignedBox2d box;
  for (const auto& camera : cameras)
    for (const auto& view : *camera.views)
      for (const auto& p : view.points) box.extend(p.board.head<2>());
  middle_ = box.center(), half_ = 0.5 * box.sizes().cwiseMax(1e-9);
}

const CalibratedView& RigModels::calibrated(const Rig& p, const RigShot& s) const {
  const size_t camera = static_cast<size_t>(p.members[s.camera]);
  return cameras_[camera].calibration->views[s.view];
}

const CalibrationView& RigModels::given(const Rig& p, const RigShot& s) const {
  const size_t camera = static_cast<size_t>(p.members[s.camera]);
  return (*cameras_[camera].views)[calibrated(p, s).view];
}

Rig RigModels::rig_of(const std::vector<int>& members, const std::vector<RigidTransform>& start, int part) const {
  Rig p;
  p.members = members;
  std::set<std::string> names;
  for (const int c : members) names.insert(moments_[c].begin(), moments_[c].end());
  std::map<std::string, int> exposure;
  int number = 0;
  for (const auto& name : names) {
    ++number;
    if (part > 0 && number % 2 != part - 1) continue;
    exposure[name] = static_cast<int>(p.exposure_names.size());
    p.exposure_names.push_back(name);
  }
  p.exposures.resize(p.exposure_names.size());
  std::vector<size_t> most(p.exposures.size(), 0);
  for (size_t m = 0; m < members.size(); ++m) {
    const size_t c = static_cast<size_t>(members[m]);
    p.cameras.push_back(placed(start[m]));
    const auto interior = cameras_[c].calibration->camera.parameters();
    std::copy(interior.begin(), interior.end(), p.interiors.emplace_back().begin());
    const auto& views = cameras_[c].calibration->views;
    for (size_t v = 0; v < views.size(); ++v) {
      const auto at = exposure.find(moments_[c][views[v].view]);
      if (at == exposure.end() || views[v].points.size() < 4) continue;
      const size_t e = static_cast<size_t>(at->second);
      p.shots.push_back({static_cast<int>(m), static_cast<int>(v), at->second});
      if (views[v].points.size() <= most[e]) continue;
      most[e] = views[v].points.size();
      p.exposures[e] = placed(start[m].inverse() * views[v].cam_from_board);
    }
  }
  p.bend = {cameras_[members[0]].calibration->bend_x, cameras_[members[0]].calibration->bend_y};
  if (!(options_.bend_sigma > 0)) p.bend.setZero();
  drop_empty_exposures(p);
  return p;
}

void drop_empty_exposures(Rig& p) {
  std::vector<int> photographs(p.exposures.size(), 0), now(p.exposures.size(), -1);
  for (const RigShot& s : p.shots) ++photographs[s.exposure];
  Rig kept;
  for (size_t e = 0; e < photographs.size(); ++e) {
    if (photographs[e] == 0) continue;
    now[e] = static_cast<int>(kept.exposures.size());
    kept.exposures.push_back(p.exposures[e]), kept.exposure_names.push_back(p.exposure_names[e]);
  }
  for (RigShot& s : p.shots) s.exposure = now[s.exposure];
  p.exposures = std::move(kept.exposures), p.exposure_names = std::move(kept.exposure_names);
}

void RigModels::add_cameras(const Rig& p, RigFreedom freedom, bundle::Problem& problem) const {
  for (size_t m = 0; m < p.members.size(); ++m) {
    const std::string& id = cameras_[p.members[m]].id;
    const Calibration& own = *cameras_[p.members[m]].calibration;
    problem.mounts.push_back({"camera " + id, m == 0});
    bundle::Camera camera{id, bundle::lens_of(own.camera.lens), 0, {}};
    for (Eigen::Index k = 0; k < bundle::value_count(camera.lens); ++k) {
      const bool estimated =
          k < BrownCamera::parameter_count && (own.covariance.size() == 0 || own.covariance(k, k) > 0);
      camera.free.push_back(estimated && freedom != RigFreedom::none && (freedom == RigFreedom::all || k < 6));
    }
    problem.cameras.push_back(std::move(camera));
  }
}

RigModel RigModels::build(const Rig& p, RigFreedom freedom) const {
  RigModel model;
  bundle::Problem& problem = model.problem;
  problem.groups = {{"points"}, {"bend"}};
  for (const std::string& name : p.exposure_names) problem.images.push_back({name});
  model.state.images = p.exposures, model.state.mounts = p.cameras, model.state.interiors = p.interiors;
  model.state.bends = {p.bend};
  add_cameras(p, freedom, problem);
  const bool bent = options_.bend_sigma > 0 && freedom == RigFreedom::all;
  problem.sheets = {{"the board", bent}};
  if (bent)
    problem.known.push_back(
        {{{bundle::Kind::bend, 0}}, Eigen::Vector2d::Zero(), Eigen::Matrix2d::Identity() / options_.bend_sigma, 1});
  for (size_t s = 0; s < p.shots.size(); ++s) {
    const RigShot& shot = p.shots[s];
    const int image = static_cast<int>(problem.images.size());
    problem.images.push_back({given(p, shot).path, shot.camera, false, false, shot.camera, shot.exposure});
    model.state.images.emplace_back();  // not looked at
    for (const int k : calibrated(p, shot).points) {
      const CalibrationPoint& point = given(p, shot).points[k];
      const Eigen::Vector2d unit = (point.board.head<2>() - middle_).cwiseQuotient(half_);
      problem.points.push_back({std::to_string(k), true, 0, Eigen::Vector2d::Ones() - unit.cwiseAbs2()});
      model.state.points.push_back(point.board);
      problem.image_points.push_back({image, static_cast<int>(model.labels.size()), point.pixel,
                                      Eigen::Matrix2d::Identity() / point.sigma, 0, true});
      model.labels.emplace_back(static_cast<int>(s), k);
    }
  }
  return model;
}

std::vector<double> RigModels::fit(Rig& p) const {
  RigModel model = build(p, RigFreedom::none);
  const bundle::Layout layout(model.problem);
  bundle::MinimiseOptions options;
  options.max_iterations = options_.max_iterations;
  options.side = bundle::Side::images;
  double unit = 10;
  for (int pass = 0; pass < 3; ++pass) {
    options.loss = {bundle::Loss::Kind::cauchy, 3 * unit};
    bundle::minimise_schur(model.problem, model.state, options);
    std::vector<double> lengths;
    for (size_t k = 0; k < model.labels.size(); ++k)
      lengths.push_back(model.residual_of(layout, k).norm() * model.problem.image_points[k].whitening(0, 0));
    unit = std::clamp(upper_median(lengths), 1e-3, unit);
  }
  std::copy_n(model.state.images.begin(), p.exposures.size(), p.exposures.begin());
  p.cameras = model.state.mounts;
  std::vector<double> squares(p.shots.size(), 0), points(p.shots.size(), 0);
  for (size_t k = 0; k < model.labels.size(); ++k) {
    const size_t s = static_cast<size_t>(model.labels[k].first);
    squares[s] += model.residual_of(layout, k).squaredNorm(), points[s] += 1;
  }
  for (size_t s = 0; s < squares.size(); ++s) squares[s] = std::sqrt(squares[s] / points[s]);
  return squares;
}

}  // namespace plumbline::markers

#include "photo/bundle/datum.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/linear_algebra/decompositions.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::bundle {
namespace {

Eigen::Vector3d tag_centre(const Problem& problem, const State& state, size_t plate) {
  const Placement& p = state.plates[plate];
  return p.position + p.matrix * problem.plates[plate].shape.tag_centre_in_plate;
}

/// Change of the held unknowns from `start` to `state`.
Eigen::VectorXd change_of(const Problem& problem, const Layout& layout, const std::vector<int>& held,
                          const State& start, const State& state) {
  Eigen::VectorXd all = Eigen::VectorXd::Zero(layout.unknown_count());
  for (size_t i = 0; i < problem.images.size(); ++i) {
    const int block = layout.block({Kind::image, static_cast<int>(i)}), at = layout.offset(block);
    if (layout.size(block) == 0) continue;
    all.segment<3>(at) = state.images[i].position - start.images[i].position;
    all.segment<3>(at + 3) = turn_between(start.images[i].rotation, state.images[i].rotation);
  }
  for (size_t i = 0; i < problem.points.size(); ++i)
    if (!problem.points[i].fixed)
      all.segment<3>(layout.offset(layout.block({Kind::point, static_cast<int>(i)}))) =
          state.points[i] - start.points[i];
  for (size_t i = 0; i < problem.plates.size(); ++i) {
    const int at = layout.offset(layout.block({Kind::plate, static_cast<int>(i)}));
    all.segment<3>(at) = state.plates[i].position - start.plates[i].position;
    all.segment<3>(at + 3) = turn_between(start.plates[i].rotation, state.plates[i].rotation);
  }
  return all(held);
}

/// p → scale · rotation (p − centre) + centre + shift for everything in the block.
void move(const Problem& problem, const Eigen::Vector3d& centre, const Eigen::Matrix<double, 7, 1>& motion,
          State& state) {
  const Eigen::Quaterniond rotation = quaternion_from_rotation_vector(motion.segment<3>(3));
  const double scale = std::exp(motion(6));
  const auto moved = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    return scale * (rotation * (p - centre)) + centre + motion.head<3>();
  };
  std::vector<Eigen::Vector3d> tags;
  for (size_t j = 0; j < state.plates.size(); ++j) tags.push_back(tag_centre(problem, state, j));
  for (auto& image : state.images) image.set(image.rotation * rotation.conjugate(), moved(image.position));
  for (auto& point : state.points) point = moved(point);
  for (size_t j = 0; j < state.plates.size(); ++j) {
    Placement& plate = state.plates[j];
    plate.set(rotation * plate.rotation, plate.position);
    // What the images see, the tag, is scaled; its offset to the anchor is a known length and stays.
    plate.position = moved(tags[j]) - plate.matrix * problem.plates[j].shape.tag_centre_in_plate;
  }
  for (double& s : state.scales) s *= scale;
  for (size_t c = 0; c < problem.cameras.size(); ++c) {
    const Camera& camera = problem.cameras[c];
    if (camera.lens == Lens::fisheye) continue;
    const int first = camera.lens == Lens::brown ? 4 : 3, distance = value_count(camera.lens) - 2;
    for (int k = 0; k < 2; ++k) {
      double& term = state.interiors[c][distance + k];
      state.interiors[c][first + k] += camera.inverse_reference * (scale - 1) * term;
      term *= scale;
    }
  }
}

/// Derivative by the scale of the object of a value of the lens that leaves every image as it is.
double change_with_scale(const Camera& camera, const Interior& values, int value) {
  if (camera.lens == Lens::fisheye) return 0;  // has none
  const int count = value_count(camera.lens), first_coefficient = camera.lens == Lens::brown ? 4 : 3;
  if (value >= count - 2) return values[value];
  const int order = value - first_coefficient;
  return order == 0 || order == 1 ? camera.inverse_reference * values[count - 2 + order] : 0.0;
}

Eigen::Vector3d centre_of_bodies(const Problem& problem, const State& state) {
  return least_squares::centre_of(bodies_of(problem, state));
}

}  // namespace

std::vector<least_squares::NamedPoint> bodies_of(const Problem& problem, const State& state) {
  std::vector<least_squares::NamedPoint> bodies;
  for (size_t i = 0; i < problem.points.size(); ++i)
    bodies.push_back({"point " + problem.points[i].name, state.points[i]});
  for (size_t j = 0; j < problem.plates.size(); ++j)
    bodies.push_back({problem.plates[j].name, state.plates[j].position});
  return bodies;
}

Eigen::MatrixXd motions_of(const Problem& problem, const Layout& layout, const State& state,
                           const Eigen::Vector3d& centre) {
  Eigen::MatrixXd g = Eigen::MatrixXd::Zero(layout.unknown_count(), least_squares::motion_count);
  const auto translate = [&](int row, const Eigen::Vector3d& position, const Eigen::Vector3d& scaled) {
    g.block<3, 3>(row, 0).setIdentity();
    g.block<3, 3>(row, 3) = -skew(position - centre);
    g.block<3, 1>(row, 6) = scaled - centre;
  };
  for (int b = 0; b < layout.block_count(); ++b) {
    if (layout.size(b) == 0) continue;
    const Ref ref = layout.ref(b);
    const size_t i = static_cast<size_t>(ref.index);
    const int row = layout.offset(b);
    if (ref.kind == Kind::image) {
      translate(row, state.images[i].position, state.images[i].position);
      g.block<3, 3>(row + 3, 3) = -state.images[i].matrix;
    } else if (ref.kind == Kind::point) {
      translate(row, state.points[i], state.points[i]);
    } else if (ref.kind == Kind::plate) {
      translate(row, state.plates[i].position, tag_centre(problem, state, i));
      g.block<3, 3>(row + 3, 3).setIdentity();
    } else if (ref.kind == Kind::scale) {
      g(row, 6) = state.scales[i];
    } else if (ref.kind == Kind::camera) {
      // k + d (1/Z − 1/Z0): where all depths are s times as large, d is, too, and k takes up what 1/Z0 does not follow.
      const auto& free = layout.free_values(ref.index);
      const Camera& camera = problem.cameras[i];
      for (int k = 0; k < static_cast<int>(free.size()); ++k)
        g(row + k, 6) = change_with_scale(camera, state.interiors[i], free[k]);
    }
  }
  return g;
}

Datum inner_datum(const Problem& problem, const Layout& layout, int count) {
  Datum datum{count, {}};
  const auto hold = [&](Ref ref) {
    const int block = layout.block(ref);
    for (int c = 0; c < 3 && layout.size(block) > 0; ++c) datum.held.push_back(layout.offset(block) + c);
  };
  for (size_t i = 0; i < problem.points.size(); ++i) hold({Kind::point, static_cast<int>(i)});
  for (size_t i = 0; i < problem.plates.size(); ++i) hold({Kind::plate, static_cast<int>(i)});
  return datum;
}

Datum first_image_datum(const Problem& problem, const Layout& layout, const State& state, int count) {
  Datum datum{count, {}};
  if (problem.images.empty()) return datum;
  const int first = layout.offset(layout.block({Kind::image, 0}));
  for (int c = 0; c < 6; ++c) datum.held.push_back(first + c);
  size_t furthest = 0;
  double base = 0;
  for (size_t i = 1; i < problem.images.size(); ++i) {
    const double length = (state.images[i].position - state.images[0].position).norm();
    if (length > base) base = length, furthest = i;
  }
  if (count == least_squares::motion_count && furthest > 0) {
    Eigen::Index axis = 0;
    (state.images[furthest].position - state.images[0].position).cwiseAbs().maxCoeff(&axis);
    datum.held.push_back(layout.offset(layout.block({Kind::image, static_cast<int>(furthest)})) +
                         static_cast<int>(axis));
  }
  return datum;
}

int free_motions(const Problem& problem) {
  for (const auto& image : problem.images)
    if (image.fixed) return 0;
  for (const auto& point : problem.points)
    if (point.fixed) return 0;
  bool has_scale = !problem.distances.empty();
  for (const auto& known : problem.known)
    for (Ref ref : known.refs) {
      if (ref.kind == Kind::point || ref.kind == Kind::plate || ref.kind == Kind::image) return 0;
      if (ref.kind == Kind::scale) has_scale = true;
    }
  for (const auto& plate : problem.plates)
    if (!problem.batches[plate.batch].scale_free) has_scale = true;
  return has_scale ? least_squares::motion_count - 1 : least_squares::motion_count;
}

void restore_datum(const Problem& problem, const Layout& layout, const Datum& datum, const State& start, State& state) {
  if (datum.count == 0 || datum.held.empty()) return;
  for (int iteration = 0; iteration < 10; ++iteration) {
    const Eigen::Vector3d centre = centre_of_bodies(problem, state);
    const Eigen::MatrixXd g = motions_of(problem, layout, state, centre)(datum.held, Eigen::all).leftCols(datum.count);
    const Eigen::VectorXd change = change_of(problem, layout, datum.held, start, state);
    Eigen::Matrix<double, 7, 1> motion = Eigen::Matrix<double, 7, 1>::Zero();
    const Eigen::VectorXd length = g.colwise().norm().cwiseMax(1e-300);
    const Eigen::MatrixXd scaled = g * length.cwiseInverse().asDiagonal();
    const Eigen::VectorXd fitted =
        linear_algebra::minimum_norm_solution(scaled.transpose() * scaled, scaled.transpose() * change);
    motion.head(datum.count) = -fitted.cwiseQuotient(length);
    if (!motion.allFinite()) return;
    move(problem, centre, motion, state);
    if ((g * motion.head(datum.count)).norm() < 1e-14 * (1 + centre.norm()) * std::sqrt(double(g.rows()))) return;
  }
}

}  // namespace plumbline::bundle

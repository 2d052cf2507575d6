#include "photo/bundle/terms.hpp"

#include <cmath>

#include "plumbline/rigid_transform.hpp"

namespace plumbline::bundle {
namespace {

using Matrix23 = Eigen::Matrix<double, 2, 3>;

/// M [v]×, row by row: m × v negated, without building the matrix.
inline Matrix23 times_skew(const Matrix23& m, const Eigen::Vector3d& v) {
  Matrix23 r;
  for (int i = 0; i < 2; ++i) {
    r(i, 0) = m(i, 1) * v.z() - m(i, 2) * v.y();
    r(i, 1) = m(i, 2) * v.x() - m(i, 0) * v.z();
    r(i, 2) = m(i, 0) * v.y() - m(i, 1) * v.x();
  }
  return r;
}

/// The next `size` columns of the matrix of derivatives, for a block of unknowns.
template <int R, int C>
auto add_part(Rows& rows, int block, int size = C) {
  using RowMajor = Eigen::Matrix<double, R, C, Eigen::RowMajor>;
  rows.part[rows.parts++] = {block, size, rows.columns};
  double* at = rows.storage.data() + rows.columns;
  rows.columns += size;
  return Eigen::Map<RowMajor, 0, Eigen::OuterStride<Rows::stride>>(at, R, size);
}

Eigen::Vector3d position_of(const State& state, Ref ref) {
  const size_t i = static_cast<size_t>(ref.index);
  if (ref.kind == Kind::point) return state.points[i];
  return ref.kind == Kind::plate ? state.plates[i].position : state.images[i].position;
}

}  // namespace

bool evaluate(const Problem& problem, const Layout& layout, const State& state, const ImagePoint& term, bool jacobians,
              Rows& rows) {
  const Image& image = problem.images[term.image];
  const Camera& camera = problem.cameras[image.camera];
  const Point& point = problem.points[term.point];
  const int pose_of = problem.pose_of(term.image);
  const Placement& pose = state.images[pose_of];
  const Placement* mount = image.mount >= 0 ? &state.mounts[image.mount] : nullptr;
  Eigen::Vector3d from_pose = state.points[term.point] - pose.position;
  if (point.sheet >= 0) from_pose.z() += point.bent_by.dot(state.bends[point.sheet]);
  const Eigen::Vector3d in_pose = pose.matrix * from_pose;
  const Eigen::Vector3d v = mount ? Eigen::Vector3d(mount->matrix * (in_pose - mount->position)) : in_pose;
  LensRows lens;
  if (!evaluate_lens(camera.lens, state.interiors[image.camera].data(), camera.balance_radius, camera.inverse_reference,
                     v, term.observed - state.shift(term.image), jacobians, lens))
    return false;
  const Eigen::Matrix2d w = term.whitening / problem.groups[term.group].sigma_factor;
  rows.rows = 2;
  rows.parts = rows.columns = 0;
  Eigen::Map<Eigen::Vector2d>(rows.residual.data()) = w * lens.misclosure;
  if (!jacobians) return true;
  const Matrix23 by_direction = w * lens.by_direction;
  const Matrix23 by_pose = mount ? Matrix23(by_direction * mount->matrix) : by_direction;
  const Matrix23 by_point = by_pose * pose.matrix;
  if (const int block = layout.block({Kind::image, pose_of}); layout.size(block) > 0) {
    auto part = add_part<2, 6>(rows, block);
    part.leftCols<3>() = -by_point;
    part.rightCols<3>() = -times_skew(by_pose, in_pose);
  }
  const auto& free = layout.free_values(image.camera);
  if (!free.empty()) {
    auto part =
        add_part<2, Eigen::Dynamic>(rows, layout.block({Kind::camera, image.camera}), static_cast<int>(free.size()));
    for (size_t c = 0; c < free.size(); ++c) part.col(static_cast<Eigen::Index>(c)) = w * lens.by_interior.col(free[c]);
  }
  if (image.shift_free)
    add_part<2, 2>(rows, layout.block({Kind::shift, term.image})) =
        w * lens.by_interior.middleCols<2>(principal_point(camera.lens));
  if (mount && !problem.mounts[image.mount].fixed) {
    auto part = add_part<2, 6>(rows, layout.block({Kind::mount, image.mount}));
    part.leftCols<3>() = -by_pose;
    part.rightCols<3>() = -times_skew(by_direction, v);
  }
  if (point.sheet >= 0 && problem.sheets[point.sheet].bend_free)
    add_part<2, 2>(rows, layout.block({Kind::bend, point.sheet})) = by_point.col(2) * point.bent_by.transpose();
  if (!point.fixed) add_part<2, 3>(rows, layout.block({Kind::point, term.point})) = by_point;
  return true;
}

bool evaluate(const Problem& problem, const Layout& layout, const State& state, const Distance& term, bool jacobians,
              Rows& rows) {
  const Eigen::Vector3d d = position_of(state, term.to) - position_of(state, term.from);
  const double length = d.norm(), sigma = term.sigma * problem.groups[term.group].sigma_factor;
  if (!(length > 0)) return false;
  rows.rows = 1;
  rows.parts = rows.columns = 0;
  rows.residual[0] = (length - term.length) / sigma;
  if (!jacobians) return true;
  for (int end = 0; end < 2; ++end) {
    const int block = layout.block(end == 0 ? term.from : term.to), size = layout.size(block);
    if (size == 0) continue;
    auto part = add_part<1, Eigen::Dynamic>(rows, block, size);
    part.setZero();
    part.leftCols<3>() = (end == 0 ? -1 : 1) * d.transpose() / (length * sigma);
  }
  return true;
}

Eigen::VectorXd residual_of(const Problem& problem, const State& state, const Known& term,
                            const Eigen::MatrixXd& whitening) {
  Eigen::VectorXd value(term.target.size());
  Eigen::Index at = 0;
  for (Ref ref : term.refs) {
    const size_t i = static_cast<size_t>(ref.index);
    if (ref.kind == Kind::camera) {
      const Eigen::Index count = value_count(problem.cameras[i].lens);
      for (Eigen::Index k = 0; k < count; ++k) value(at + k) = state.interiors[i][k];
      at += count;
    } else if (ref.kind == Kind::shift) {
      value.segment<2>(at) = state.shift(ref.index);
      at += 2;
    } else if (ref.kind == Kind::bend) {
      value.segment<2>(at) = state.bends[i];
      at += 2;
    } else if (ref.kind == Kind::form) {
      for (double part : state.forms[i]) value(at++) = part;
    } else if (ref.kind == Kind::scale || ref.kind == Kind::inset) {
      value(at++) = ref.kind == Kind::scale ? state.scales[i] : state.insets[i];
    } else {
      value.segment<3>(at) = position_of(state, ref);
      at += 3;
    }
    if (term.world_from_plate) {
      value.segment<3>(at) = turn_between(*term.world_from_plate, state.plates[i].rotation);
      at += 3;
    }
  }
  return whitening * (value - term.target);
}

void linear_columns(const Problem& problem, const Layout& layout, const Known& term, std::vector<int>& chosen,
                    std::vector<int>& unknowns) {
  int at = 0;
  const auto add = [&](int column, int unknown) {
    chosen.push_back(column);
    unknowns.push_back(unknown);
  };
  for (Ref ref : term.refs) {
    const int block = layout.block(ref), offset = layout.offset(block);
    if (ref.kind == Kind::camera) {
      int next = offset;
      for (int k : layout.free_values(ref.index)) add(at + k, next++);
      at += value_count(problem.cameras[ref.index].lens);
    } else if (ref.kind == Kind::form) {
      for (int k = 0; k < layout.size(block); ++k) add(at + problem.plates[ref.index].form_begin + k, offset + k);
      at += form_count;
    } else {
      const int count = term.world_from_plate                                ? 6
                        : ref.kind == Kind::shift || ref.kind == Kind::bend  ? 2
                        : ref.kind == Kind::scale || ref.kind == Kind::inset ? 1
                                                                             : 3;
      for (int k = 0; k < count && layout.size(block) > 0; ++k) add(at + k, offset + k);
      at += count;
    }
  }
}

KnownRows evaluate(const Problem& problem, const Layout& layout, const State& state, const Known& term) {
  KnownRows result;
  std::vector<int> chosen;
  linear_columns(problem, layout, term, chosen, result.columns);
  for (Ref ref : term.refs)
    if (layout.size(layout.block(ref)) > 0) result.blocks.push_back(layout.block(ref));
  const Eigen::MatrixXd w = term.whitening / problem.groups[term.group].sigma_factor;
  result.residual = residual_of(problem, state, term, w);
  result.jacobian = w(Eigen::all, chosen);
  return result;
}

Eigen::Vector2d computed_image_point(const Camera& camera, const Interior& interior, const Eigen::Vector3d& v) {
  LensRows rows;
  rows.misclosure.setConstant(std::nan(""));
  evaluate_lens(camera.lens, interior.data(), camera.balance_radius, camera.inverse_reference, v,
                Eigen::Vector2d::Zero(), false, rows);
  return rows.misclosure;
}

}  // namespace plumbline::bundle

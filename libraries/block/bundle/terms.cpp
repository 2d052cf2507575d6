#include "block/bundle/terms.hpp"

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
  rows.part[static_cast<size_t>(rows.parts++)] = {block, size, rows.columns};
  double* at = rows.storage.data() + rows.columns;
  rows.columns += size;
  return Eigen::Map<RowMajor, 0, Eigen::OuterStride<Rows::stride>>(at, R, size);
}

/// Which value of the lens is the first coordinate of its principal point; the second follows it.
int principal_point(Lens lens) { return lens == Lens::brown ? 2 : 1; }

Eigen::Vector3d position_of(const State& state, Ref ref) {
  const size_t i = static_cast<size_t>(ref.index);
  if (ref.kind == Kind::point) return state.points[i];
  return ref.kind == Kind::plate ? state.plates[i].position : state.images[i].position;
}

/// Derivatives of one corner's drawn position by all four projected corners. Both edges at the corner move inwards by
/// the inset: along each edge by inset / sin(angle between them).
struct DrawnCorners {
  Eigen::Matrix<double, 8, 1> shift;  ///< for an inset of 1
  Eigen::Matrix<double, 8, 8> by_pixels;
};

void draw_corners(const std::array<Eigen::Vector2d, 4>& pixels, double inset, bool jacobians, DrawnCorners& drawn) {
  drawn.by_pixels.setIdentity();
  for (int k = 0; k < 4; ++k) {
    const int neighbours[2] = {(k + 1) % 4, (k + 3) % 4};
    Eigen::Vector2d unit[2];
    Eigen::Matrix2d slope[2];  // of the unit vector by its end
    for (int n = 0; n < 2; ++n) {
      const Eigen::Vector2d edge = pixels[static_cast<size_t>(neighbours[n])] - pixels[static_cast<size_t>(k)];
      const double length = edge.norm();
      unit[n] = edge / length;
      slope[n] = (Eigen::Matrix2d::Identity() - unit[n] * unit[n].transpose()) / length;
    }
    const double cross = unit[0].x() * unit[1].y() - unit[0].y() * unit[1].x(), sign = cross < 0 ? -1 : 1;
    const double sine = sign * cross;
    const Eigen::Vector2d sum = unit[0] + unit[1];
    drawn.shift.segment<2>(2 * k) = sum / sine;
    if (!jacobians || inset == 0) continue;
    const Eigen::RowVector2d by_unit[2] = {sign * Eigen::RowVector2d(unit[1].y(), -unit[1].x()),
                                           sign * Eigen::RowVector2d(-unit[0].y(), unit[0].x())};
    for (int n = 0; n < 2; ++n) {
      const Eigen::Matrix2d by_end = inset * (slope[n] / sine - sum / (sine * sine) * (by_unit[n] * slope[n]).eval());
      drawn.by_pixels.block<2, 2>(2 * k, 2 * neighbours[n]) += by_end;
      drawn.by_pixels.block<2, 2>(2 * k, 2 * k) -= by_end;
    }
  }
}

}  // namespace

bool evaluate(const Problem& problem, const Layout& layout, const State& state, const ImagePoint& term, bool jacobians,
              Rows& rows) {
  const Image& image = problem.images[static_cast<size_t>(term.image)];
  const Camera& camera = problem.cameras[static_cast<size_t>(image.camera)];
  const Placement& pose = state.images[static_cast<size_t>(term.image)];
  const Eigen::Vector3d v = pose.matrix * (state.points[static_cast<size_t>(term.point)] - pose.position);
  LensRows lens;
  if (!evaluate_lens(camera.lens, state.interiors[static_cast<size_t>(image.camera)].data(), camera.balance_radius,
                     camera.inverse_reference, v, term.observed - state.shift(term.image), jacobians, lens))
    return false;
  const Eigen::Matrix2d w = term.whitening / problem.groups[static_cast<size_t>(term.group)].sigma_factor;
  rows.rows = 2;
  rows.parts = rows.columns = 0;
  Eigen::Map<Eigen::Vector2d>(rows.residual.data()) = w * lens.misclosure;
  if (!jacobians) return true;
  const Matrix23 by_direction = w * lens.by_direction;
  const Matrix23 by_point = by_direction * pose.matrix;
  if (!image.fixed) {
    auto part = add_part<2, 6>(rows, layout.block({Kind::image, term.image}));
    part.leftCols<3>() = -by_point;
    part.rightCols<3>() = -times_skew(by_direction, v);
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
  if (!problem.points[static_cast<size_t>(term.point)].fixed)
    add_part<2, 3>(rows, layout.block({Kind::point, term.point})) = by_point;
  return true;
}

namespace {

/// A tag's corners as projected, and their derivatives by everything that may move them.
struct ProjectedTag {
  std::array<Eigen::Vector2d, 4> pixels;
  Eigen::Matrix<double, 8, 6> by_pose, by_plate;
  Eigen::Matrix<double, 8, Eigen::Dynamic, 0, 8, max_interior> by_interior;
  Eigen::Matrix<double, 8, 1> by_scale;
  Eigen::Matrix<double, 8, 2> by_shift;
};

bool project(const Problem& problem, const Layout& layout, const State& state, const ImageTag& term, bool jacobians,
             ProjectedTag& tag) {
  const Image& image = problem.images[static_cast<size_t>(term.image)];
  const Camera& camera = problem.cameras[static_cast<size_t>(image.camera)];
  const Plate& plate = problem.plates[static_cast<size_t>(term.plate)];
  const Placement& pose = state.images[static_cast<size_t>(term.image)];
  const Placement& body = state.plates[static_cast<size_t>(term.plate)];
  const size_t batch = static_cast<size_t>(plate.batch);
  const double scale = state.scales[batch], half = 0.5 * plate.shape.tag_size;
  const auto& free = layout.free_values(image.camera);
  const Eigen::Index f = static_cast<Eigen::Index>(free.size());
  tag.by_interior.resize(8, f);
  LensRows lens;
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector3d edge((k == 1 || k == 2) ? half : -half, k >= 2 ? half : -half, 0);
    const Eigen::Vector3d arm = body.matrix * (plate.shape.tag_centre_in_plate + scale * edge);
    const Eigen::Vector3d v = pose.matrix * (body.position + arm - pose.position);
    if (!evaluate_lens(camera.lens, state.interiors[static_cast<size_t>(image.camera)].data(), camera.balance_radius,
                       camera.inverse_reference, v, Eigen::Vector2d::Zero(), jacobians, lens))
      return false;
    tag.pixels[static_cast<size_t>(k)] = lens.misclosure + state.shift(term.image);
    if (!jacobians) continue;
    const Matrix23 by_point = lens.by_direction * pose.matrix;
    tag.by_pose.block<2, 3>(2 * k, 0) = -by_point;
    tag.by_pose.block<2, 3>(2 * k, 3) = -times_skew(lens.by_direction, v);
    tag.by_plate.block<2, 3>(2 * k, 0) = by_point;
    tag.by_plate.block<2, 3>(2 * k, 3) = -times_skew(by_point, arm);
    if (image.shift_free)
      tag.by_shift.middleRows<2>(2 * k) = lens.by_interior.middleCols<2>(principal_point(camera.lens));
    if (problem.batches[batch].scale_free) tag.by_scale.segment<2>(2 * k) = by_point * (body.matrix * edge);
    for (Eigen::Index c = 0; c < f; ++c)
      tag.by_interior.block<2, 1>(2 * k, c) = lens.by_interior.col(free[static_cast<size_t>(c)]);
  }
  return true;
}

/// What derivatives of a tag's pixels are multiplied by: the whitening of its corners, which are drawn inwards perhaps.
struct TagWeight {
  std::array<Eigen::Matrix2d, 4> corner;
  Eigen::Matrix<double, 8, 8> all;  ///< only if the edges at a corner move it
  bool mixes_corners = false;

  template <typename Derivatives, typename Part>
  void times(const Derivatives& derivatives, Part part) const {
    if (mixes_corners)
      part = all * derivatives;
    else
      for (int k = 0; k < 4; ++k)
        part.template middleRows<2>(2 * k).noalias() =
            corner[static_cast<size_t>(k)] * derivatives.template middleRows<2>(2 * k);
  }
};

}  // namespace

bool evaluate(const Problem& problem, const Layout& layout, const State& state, const ImageTag& term, bool jacobians,
              Rows& rows) {
  const Image& image = problem.images[static_cast<size_t>(term.image)];
  const Plate& plate = problem.plates[static_cast<size_t>(term.plate)];
  const size_t batch = static_cast<size_t>(plate.batch);
  const int drawn_by = term.inset < 0 ? plate.batch : term.inset;
  const size_t drawn_batch = static_cast<size_t>(drawn_by);
  const bool scale_free = problem.batches[batch].scale_free, inset_free = problem.batches[drawn_batch].inset_free;
  const double inset = state.insets[drawn_batch], factor = problem.groups[static_cast<size_t>(term.group)].sigma_factor;
  ProjectedTag tag;
  if (!project(problem, layout, state, term, jacobians, tag)) return false;
  DrawnCorners drawn;
  if (inset != 0 || inset_free)
    draw_corners(tag.pixels, inset, jacobians, drawn);
  else
    drawn.shift.setZero();
  TagWeight weight;
  rows.rows = 8;
  rows.parts = rows.columns = 0;
  for (int k = 0; k < 4; ++k) {
    const size_t at = static_cast<size_t>(k);
    weight.corner[at] = term.whitening[at] / factor;
    Eigen::Map<Eigen::Vector2d>(rows.residual.data() + 2 * k) =
        weight.corner[at] * (tag.pixels[at] + inset * drawn.shift.segment<2>(2 * k) - term.corners[at]);
  }
  if (!jacobians) return true;
  if (inset != 0) {
    weight.mixes_corners = true;
    for (int k = 0; k < 4; ++k)
      weight.all.middleRows<2>(2 * k) = weight.corner[static_cast<size_t>(k)] * drawn.by_pixels.middleRows<2>(2 * k);
  }
  if (!image.fixed) weight.times(tag.by_pose, add_part<8, 6>(rows, layout.block({Kind::image, term.image})));
  if (const int f = static_cast<int>(tag.by_interior.cols()); f > 0)
    weight.times(tag.by_interior, add_part<8, Eigen::Dynamic>(rows, layout.block({Kind::camera, image.camera}), f));
  if (image.shift_free) weight.times(tag.by_shift, add_part<8, 2>(rows, layout.block({Kind::shift, term.image})));
  if (scale_free)
    weight.times(tag.by_scale, add_part<8, Eigen::Dynamic>(rows, layout.block({Kind::scale, plate.batch}), 1));
  if (inset_free) {
    auto part = add_part<8, Eigen::Dynamic>(rows, layout.block({Kind::inset, drawn_by}), 1);
    for (int k = 0; k < 4; ++k)
      part.middleRows<2>(2 * k).noalias() = weight.corner[static_cast<size_t>(k)] * drawn.shift.segment<2>(2 * k);
  }
  weight.times(tag.by_plate, add_part<8, 6>(rows, layout.block({Kind::plate, term.plate})));
  return true;
}

bool is_drawn_inwards(const Problem& problem, const State& state, const ImageTag& term) {
  const int by = term.inset < 0 ? problem.plates[static_cast<size_t>(term.plate)].batch : term.inset;
  return problem.batches[static_cast<size_t>(by)].inset_free || state.insets[static_cast<size_t>(by)] != 0;
}

bool gradient_of(const Problem& problem, const State& state, const ImageTag& term, TagGradient& gradient) {
  const Image& image = problem.images[static_cast<size_t>(term.image)];
  const Camera& camera = problem.cameras[static_cast<size_t>(image.camera)];
  const Plate& plate = problem.plates[static_cast<size_t>(term.plate)];
  const Placement& pose = state.images[static_cast<size_t>(term.image)];
  const Placement& body = state.plates[static_cast<size_t>(term.plate)];
  const double scale = state.scales[static_cast<size_t>(plate.batch)], half = 0.5 * plate.shape.tag_size;
  const double factor = problem.groups[static_cast<size_t>(term.group)].sigma_factor;
  const Eigen::Vector2d shift = state.shift(term.image);
  gradient.squares = gradient.by_scale = 0;
  gradient.by_image.setZero();
  gradient.by_plate.setZero();
  gradient.by_interior.setZero();
  LensRows lens;
  for (size_t k = 0; k < 4; ++k) {
    const Eigen::Vector3d edge((k == 1 || k == 2) ? half : -half, k >= 2 ? half : -half, 0);
    const Eigen::Vector3d arm = body.matrix * (plate.shape.tag_centre_in_plate + scale * edge);
    const Eigen::Vector3d v = pose.matrix * (body.position + arm - pose.position);
    if (!evaluate_lens(camera.lens, state.interiors[static_cast<size_t>(image.camera)].data(), camera.balance_radius,
                       camera.inverse_reference, v, Eigen::Vector2d::Zero(), true, lens))
      return false;
    const Eigen::Matrix2d whitening = term.whitening[k] / factor;
    const Eigen::Vector2d residual = whitening * (lens.misclosure + shift - term.corners[k]);
    gradient.squares += residual.squaredNorm();
    const Eigen::Vector2d by_pixel = whitening.transpose() * residual;
    const Eigen::Vector3d by_direction = lens.by_direction.transpose() * by_pixel;
    const Eigen::Vector3d by_point = pose.matrix.transpose() * by_direction;
    gradient.by_image.head<3>() -= by_point;
    gradient.by_image.tail<3>() += v.cross(by_direction);
    gradient.by_plate.head<3>() += by_point;
    gradient.by_plate.tail<3>() += arm.cross(by_point);
    gradient.by_scale += by_point.dot(body.matrix * edge);
    const int count = value_count(camera.lens);
    for (int c = 0; c < count; ++c)
      gradient.by_interior(c) += lens.by_interior(0, c) * by_pixel.x() + lens.by_interior(1, c) * by_pixel.y();
  }
  gradient.by_shift = gradient.by_interior.segment<2>(principal_point(camera.lens));
  return true;
}

bool evaluate(const Problem& problem, const Layout& layout, const State& state, const Distance& term, bool jacobians,
              Rows& rows) {
  const Eigen::Vector3d d = position_of(state, term.to) - position_of(state, term.from);
  const double length = d.norm(), sigma = term.sigma * problem.groups[static_cast<size_t>(term.group)].sigma_factor;
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
      for (Eigen::Index k = 0; k < count; ++k) value(at + k) = state.interiors[i][static_cast<size_t>(k)];
      at += count;
    } else if (ref.kind == Kind::shift) {
      value.segment<2>(at) = state.shift(ref.index);
      at += 2;
    } else if (ref.kind == Kind::scale || ref.kind == Kind::inset) {
      value(at++) = ref.kind == Kind::scale ? state.scales[i] : state.insets[i];
    } else {
      value.segment<3>(at) = position_of(state, ref);
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
      at += value_count(problem.cameras[static_cast<size_t>(ref.index)].lens);
    } else {
      const int count = ref.kind == Kind::shift ? 2 : ref.kind == Kind::scale || ref.kind == Kind::inset ? 1 : 3;
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
  const Eigen::MatrixXd w = term.whitening / problem.groups[static_cast<size_t>(term.group)].sigma_factor;
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

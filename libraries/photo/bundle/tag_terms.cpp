// A tag in an image: its four corners side by side in the lanes of a vector, from the body to whitened residuals and
// their derivatives. Every sum over corners has one order, so all processors give the same bits.
#include <array>
#include <cmath>

#include "photo/bundle/lens_models.hpp"
#include "photo/bundle/terms.hpp"

namespace plumbline::bundle {
namespace {

/// In libapriltag's order of corners: half a side along the x and the y axis of the tag.
constexpr V4 along_x = {-1, 1, 1, -1}, along_y = {-1, -1, 1, 1}, along_both = {1, -1, 1, -1};

/// What each value of a form adds to a corner, in half sides along the tag's x and y and its normal.
constexpr V4 against_y = {1, 1, -1, -1}, no_move = {0, 0, 0, 0};
constexpr V4 form_moves[form_count][3] = {{along_x, against_y, no_move},
                                          {along_y, along_x, no_move},
                                          {along_both, no_move, no_move},
                                          {no_move, along_both, no_move},
                                          {no_move, no_move, along_both}};

PLUMBLINE_INLINE V4 of_next(const V4& v) { return __builtin_shufflevector(v, v, 1, 2, 3, 0); }
PLUMBLINE_INLINE V4 of_previous(const V4& v) { return __builtin_shufflevector(v, v, 3, 0, 1, 2); }
PLUMBLINE_INLINE double sum_of(const V4& v) { return (v[0] + v[1]) + (v[2] + v[3]); }

/// A 2 × 2 matrix of each corner, row by row.
struct Matrices {
  V4 m[4];
};
struct Pairs {
  V4 x, y;
};
PLUMBLINE_INLINE Pairs operator*(const Matrices& a, const Pairs& b) {
  return {a.m[0] * b.x + a.m[1] * b.y, a.m[2] * b.x + a.m[3] * b.y};
}
PLUMBLINE_INLINE Pairs transposed_times(const Matrices& a, const Pairs& b) {
  return {a.m[0] * b.x + a.m[2] * b.y, a.m[1] * b.x + a.m[3] * b.y};
}
PLUMBLINE_INLINE Pairs operator+(const Pairs& a, const Pairs& b) { return {a.x + b.x, a.y + b.y}; }

/// What is computed of a tag, as plain numbers: what the lanes read.
struct TagInput {
  Lens lens = Lens::brown;
  const double* interior = nullptr;
  double balance_radius = 0, inverse_reference = 0;
  std::array<double, 9> camera;          ///< cam_from_world, column by column
  std::array<double, 3> anchor;          ///< minus the projection centre [m]
  std::array<double, 3> centre;          ///< of the tag minus the anchor, world axes [m]
  std::array<double, 3> side_x, side_y;  ///< half a side without its scale, world axes [m]
  std::array<double, 3> normal;          ///< as long
  bool is_formed = false;                ///< no square, or perhaps
  Form form{};
  double scale = 1, inset = 0;
  bool is_drawn = false;  ///< inwards, or perhaps
  double shift[2] = {0, 0};
  double corners[2][4];    ///< observed
  double whitening[4][4];  ///< entry by entry
};

/// Where the corners are drawn: both edges at a corner move inwards by the inset, the corner along each edge by inset /
/// sin(angle between them).
struct Drawn {
  Pairs shift;                   ///< for an inset of 1
  Matrices own, next, previous;  ///< derivatives of a drawn corner by projected ones
};

struct Projected {
  V4 edge[3], arm[3], v[3];  ///< from the tag's centre (unscaled) and from the anchor, world axes; in the camera frame
  V4 by_direction[6], by_interior[2 * max_interior];  ///< see LensOutput
  Matrices whitening;
  Pairs residual;
  Drawn drawn;
};

PLUMBLINE_INLINE void draw(const Pairs& pixel, double inset, bool jacobians, Drawn& drawn) {
  Pairs unit[2];
  Matrices slope[2];  // of the unit vector by its end
  for (int n = 0; n < 2; ++n) {
    const Pairs end =
        n == 0 ? Pairs{of_next(pixel.x), of_next(pixel.y)} : Pairs{of_previous(pixel.x), of_previous(pixel.y)};
    const Pairs edge = {end.x - pixel.x, end.y - pixel.y};
    const V4 length = root(edge.x * edge.x + edge.y * edge.y);
    unit[n] = {edge.x / length, edge.y / length};
    const V4 mixed = -(unit[n].x * unit[n].y) / length;
    slope[n] = {{(1 - unit[n].x * unit[n].x) / length, mixed, mixed, (1 - unit[n].y * unit[n].y) / length}};
  }
  const V4 cross = unit[0].x * unit[1].y - unit[0].y * unit[1].x, zero = 0 * cross;
  const V4 sign = cross < zero ? zero - 1 : zero + 1, sine = sign * cross;
  const Pairs sum = unit[0] + unit[1];
  drawn.shift = {sum.x / sine, sum.y / sine};
  if (!jacobians) return;
  const Pairs by_unit[2] = {{sign * unit[1].y, -sign * unit[1].x}, {-sign * unit[0].y, sign * unit[0].x}};  // of sine
  Matrices* const to[2] = {&drawn.next, &drawn.previous};
  for (int n = 0; n < 2; ++n) {
    const Pairs by_end = transposed_times(slope[n], by_unit[n]);
    const V4 x = sum.x / (sine * sine), y = sum.y / (sine * sine);
    *to[n] = {{inset * (slope[n].m[0] / sine - x * by_end.x), inset * (slope[n].m[1] / sine - x * by_end.y),
               inset * (slope[n].m[2] / sine - y * by_end.x), inset * (slope[n].m[3] / sine - y * by_end.y)}};
  }
  for (int k = 0; k < 4; ++k) drawn.own.m[k] = (k % 3 == 0 ? 1.0 : 0.0) - drawn.next.m[k] - drawn.previous.m[k];
}

/// By one value of the form, coordinate c in world axes, without the tag's scale [m].
PLUMBLINE_INLINE V4 form_move(const TagInput& tag, int value, size_t c) {
  const V4* move = form_moves[value];
  return move[0] * tag.side_x[c] + move[1] * tag.side_y[c] + move[2] * tag.normal[c];
}

PLUMBLINE_INLINE bool project(const TagInput& tag, bool jacobians, Projected& to) {
  V4 from_camera[3];
  for (size_t c = 0; c < 3; ++c) {
    to.edge[c] = along_x * tag.side_x[c] + along_y * tag.side_y[c];
    for (size_t k = 0; k < form_count && tag.is_formed; ++k)
      to.edge[c] += tag.form[k] * form_move(tag, static_cast<int>(k), c);
    to.arm[c] = tag.centre[c] + tag.scale * to.edge[c];
    from_camera[c] = tag.anchor[c] + to.arm[c];
  }
  const double* r = tag.camera.data();
  for (int c = 0; c < 3; ++c) to.v[c] = r[c] * from_camera[0] + r[3 + c] * from_camera[1] + r[6 + c] * from_camera[2];
  for (int k = 0; k < 4; ++k)
    if (!(front(tag.lens) * to.v[2][k] > nearest * (std::abs(to.v[0][k]) + std::abs(to.v[1][k]) + 1e-3))) return false;
  const V4 zero = {0, 0, 0, 0};
  const LensInput<V4> at{
      tag.interior, tag.balance_radius, tag.inverse_reference, {to.v[0], to.v[1], to.v[2]}, {zero, zero}};
  V4 image[2];
  compute_lens(tag.lens, at, jacobians, LensOutput<V4>{image, to.by_direction, to.by_interior});
  const Pairs pixel = {image[0] + tag.shift[0], image[1] + tag.shift[1]};
  Pairs misclosure = {pixel.x - load<V4>(tag.corners[0]), pixel.y - load<V4>(tag.corners[1])};
  if (tag.is_drawn) {
    draw(pixel, tag.inset, jacobians, to.drawn);
    misclosure.x += tag.inset * to.drawn.shift.x;
    misclosure.y += tag.inset * to.drawn.shift.y;
  }
  for (int k = 0; k < 4; ++k) to.whitening.m[k] = load<V4>(tag.whitening[k]);
  to.residual = to.whitening * misclosure;
  return true;
}

/// Where in the rows the derivatives by each block begin; −1 for what is held.
struct Columns {
  int image = -1, shift = -1, scale = -1, inset = -1, plate = -1, interior = -1, form = -1;
  int form_begin = 0, form_end = 0;  ///< the values of the form that are unknowns
  const int* free = nullptr;         ///< the values of the camera that are unknowns
  int free_count = 0, principal_point = 0;
};

/// Rows 2k and 2k + 1 are those of corner k.
PLUMBLINE_INLINE void store_column(double* rows, int column, const Pairs& values) {
  double* to = rows + column;
  for (int k = 0; k < 4; ++k, to += 2 * Rows::stride) {
    to[0] = values.x[k];
    to[Rows::stride] = values.y[k];
  }
}

PLUMBLINE_INLINE Matrices product(const Matrices& a, const Matrices& b) {
  return {{a.m[0] * b.m[0] + a.m[1] * b.m[2], a.m[0] * b.m[1] + a.m[1] * b.m[3], a.m[2] * b.m[0] + a.m[3] * b.m[2],
           a.m[2] * b.m[1] + a.m[3] * b.m[3]}};
}

/// Derivatives of the projected corners to whitened rows.
struct Whitener {
  double* rows;
  bool mixed;  ///< the corners move each other's drawn ones
  Matrices own, next, previous;

  PLUMBLINE_INLINE Whitener(const Projected& tag, bool corners_mix, double* to)
      : rows(to), mixed(corners_mix), own(tag.whitening), next(), previous() {
    if (!mixed) return;
    own = product(tag.whitening, tag.drawn.own);
    next = product(tag.whitening, tag.drawn.next);
    previous = product(tag.whitening, tag.drawn.previous);
  }
  PLUMBLINE_INLINE void add(int column, const Pairs& by) const {
    Pairs row = own * by;
    if (mixed)
      row = row + next * Pairs{of_next(by.x), of_next(by.y)} + previous * Pairs{of_previous(by.x), of_previous(by.y)};
    store_column(rows, column, row);
  }
  PLUMBLINE_INLINE void add(int column, const V4* x_and_y) const { add(column, Pairs{x_and_y[0], x_and_y[1]}); }
  /// By a rotation vector of what lies at `arm`: −m [arm]×.
  PLUMBLINE_INLINE void add_rotation(int column, const Pairs (&m)[3], const V4 (&arm)[3]) const {
    for (int c = 0; c < 3; ++c) {
      const int d = (c + 1) % 3, e = (c + 2) % 3;
      add(column + c, Pairs{m[e].x * arm[d] - m[d].x * arm[e], m[e].y * arm[d] - m[d].y * arm[e]});
    }
  }
};

/// Without columns only the residuals.
PLUMBLINE_CLONES
bool rows_of(const TagInput& tag, const Columns* columns, double* residual, double* rows) {
  Projected p;
  if (!project(tag, columns != nullptr, p)) return false;
  for (int k = 0; k < 4; ++k) residual[2 * k] = p.residual.x[k], residual[2 * k + 1] = p.residual.y[k];
  if (columns == nullptr) return true;
  const Whitener whitened(p, tag.is_drawn && tag.inset != 0, rows);
  Pairs by_direction[3], by_point[3];
  for (int c = 0; c < 3; ++c) by_direction[c] = {p.by_direction[2 * c], p.by_direction[2 * c + 1]};
  for (size_t c = 0; c < 3; ++c) {
    const double* r = tag.camera.data() + 3 * c;
    by_point[c] = {r[0] * by_direction[0].x + r[1] * by_direction[1].x + r[2] * by_direction[2].x,
                   r[0] * by_direction[0].y + r[1] * by_direction[1].y + r[2] * by_direction[2].y};
  }
  if (columns->image >= 0) {
    for (int c = 0; c < 3; ++c) whitened.add(columns->image + c, Pairs{-by_point[c].x, -by_point[c].y});
    whitened.add_rotation(columns->image + 3, by_direction, p.v);
  }
  for (int k = 0; k < columns->free_count; ++k)
    whitened.add(columns->interior + k, p.by_interior + 2 * columns->free[k]);
  for (int k = 0; k < 2 && columns->shift >= 0; ++k)
    whitened.add(columns->shift + k, p.by_interior + 2 * (columns->principal_point + k));
  if (columns->scale >= 0)
    whitened.add(columns->scale,
                 Pairs{by_point[0].x * p.edge[0] + by_point[1].x * p.edge[1] + by_point[2].x * p.edge[2],
                       by_point[0].y * p.edge[0] + by_point[1].y * p.edge[1] + by_point[2].y * p.edge[2]});
  if (columns->inset >= 0)  // moves the drawn corners, not the projected ones
    store_column(rows, columns->inset, p.whitening * p.drawn.shift);
  for (int k = columns->form_begin; k < columns->form_end; ++k) {
    const V4 move[3] = {form_move(tag, k, 0), form_move(tag, k, 1), form_move(tag, k, 2)};
    whitened.add(columns->form + k - columns->form_begin,
                 Pairs{tag.scale * (by_point[0].x * move[0] + by_point[1].x * move[1] + by_point[2].x * move[2]),
                       tag.scale * (by_point[0].y * move[0] + by_point[1].y * move[1] + by_point[2].y * move[2])});
  }
  for (int c = 0; c < 3; ++c) whitened.add(columns->plate + c, by_point[c]);
  whitened.add_rotation(columns->plate + 3, by_point, p.arm);
  return true;
}

PLUMBLINE_INLINE void sum_cross(const V4 (&a)[3], const V4 (&b)[3], double* to) {
  for (int c = 0; c < 3; ++c) {
    const int d = (c + 1) % 3, e = (c + 2) % 3;
    to[c] = sum_of(a[d] * b[e] - a[e] * b[d]);
  }
}

PLUMBLINE_CLONES
bool sum_gradient(const TagInput& tag, int interior_count, TagGradient& to) {
  Projected p;
  if (!project(tag, true, p)) return false;
  to.squares = sum_of(p.residual.x * p.residual.x + p.residual.y * p.residual.y);
  const Pairs by_drawn = transposed_times(p.whitening, p.residual);
  Pairs by_pixel = by_drawn;
  to.by_inset = 0;
  if (tag.is_drawn) {
    to.by_inset = sum_of(p.drawn.shift.x * by_drawn.x + p.drawn.shift.y * by_drawn.y);
    // What a corner moves of its neighbours: it is the next one of the one before.
    const Pairs before = transposed_times(p.drawn.next, by_drawn), after = transposed_times(p.drawn.previous, by_drawn);
    by_pixel = transposed_times(p.drawn.own, by_drawn) + Pairs{of_previous(before.x), of_previous(before.y)} +
               Pairs{of_next(after.x), of_next(after.y)};
  }
  V4 by_direction[3], by_point[3];
  for (int c = 0; c < 3; ++c)
    by_direction[c] = p.by_direction[2 * c] * by_pixel.x + p.by_direction[2 * c + 1] * by_pixel.y;
  for (size_t c = 0; c < 3; ++c) {
    const double* r = tag.camera.data() + 3 * c;
    by_point[c] = r[0] * by_direction[0] + r[1] * by_direction[1] + r[2] * by_direction[2];
    to.by_plate[static_cast<Eigen::Index>(c)] = sum_of(by_point[c]);
    to.by_image[static_cast<Eigen::Index>(c)] = -to.by_plate[static_cast<Eigen::Index>(c)];
  }
  sum_cross(p.v, by_direction, to.by_image.data() + 3);
  sum_cross(p.arm, by_point, to.by_plate.data() + 3);
  to.by_scale = sum_of(by_point[0] * p.edge[0] + by_point[1] * p.edge[1] + by_point[2] * p.edge[2]);
  to.by_form.setZero();
  for (int k = 0; k < form_count && tag.is_formed; ++k)
    to.by_form(k) = tag.scale * sum_of(by_point[0] * form_move(tag, k, 0) + by_point[1] * form_move(tag, k, 1) +
                                       by_point[2] * form_move(tag, k, 2));
  for (int k = 0; k < interior_count; ++k)
    to.by_interior[k] = sum_of(p.by_interior[2 * k] * by_pixel.x + p.by_interior[2 * k + 1] * by_pixel.y);
  return true;
}

int batch_of_inset(const Problem& problem, const ImageTag& term) {
  return term.inset < 0 ? problem.plates[term.plate].batch : term.inset;
}

TagInput input_of(const Problem& problem, const State& state, const ImageTag& term) {
  const int of_camera = problem.images[term.image].camera;
  const Camera& camera = problem.cameras[of_camera];
  const Plate& plate = problem.plates[term.plate];
  const Placement& pose = state.images[term.image];
  const Placement& body = state.plates[term.plate];
  const size_t drawn_by = static_cast<size_t>(batch_of_inset(problem, term));
  TagInput tag;
  tag.lens = camera.lens;
  tag.interior = state.interiors[of_camera].data();
  tag.balance_radius = camera.balance_radius;
  tag.inverse_reference = camera.inverse_reference;
  const auto set = [](std::array<double, 3>& to, const Eigen::Vector3d& from) { to = {from.x(), from.y(), from.z()}; };
  Eigen::Map<Eigen::Matrix3d>(tag.camera.data()) = pose.matrix;
  set(tag.anchor, body.position - pose.position);
  set(tag.centre, body.matrix * plate.shape.tag_centre_in_plate);
  set(tag.side_x, 0.5 * plate.shape.tag_size * body.matrix.col(0));
  set(tag.side_y, 0.5 * plate.shape.tag_size * body.matrix.col(1));
  tag.scale = state.scales[plate.batch];
  if (!state.forms.empty()) tag.form = state.forms[term.plate];
  tag.is_formed = plate.form_begin < plate.form_end || tag.form != Form{};
  if (tag.is_formed) set(tag.normal, 0.5 * plate.shape.tag_size * body.matrix.col(2));
  tag.inset = state.insets[drawn_by];
  tag.is_drawn = tag.inset != 0 || problem.batches[drawn_by].inset_free;
  Eigen::Map<Eigen::Vector2d>(tag.shift) = state.shift(term.image);
  const double factor = problem.groups[term.group].sigma_factor;
  for (size_t k = 0; k < 4; ++k) {
    for (size_t c = 0; c < 2; ++c) tag.corners[c][k] = term.corners[k](static_cast<Eigen::Index>(c));
    for (size_t e = 0; e < 4; ++e)
      tag.whitening[e][k] =
          term.whitening[k](static_cast<Eigen::Index>(e / 2), static_cast<Eigen::Index>(e % 2)) / factor;
  }
  return tag;
}

}  // namespace

bool evaluate(const Problem& problem, const Layout& layout, const State& state, const ImageTag& term, bool jacobians,
              Rows& rows) {
  const TagInput tag = input_of(problem, state, term);
  rows.rows = 8;
  rows.parts = rows.columns = 0;
  if (!jacobians) return rows_of(tag, nullptr, rows.residual.data(), nullptr);
  const auto next = [&](Ref ref) {
    const int block = layout.block(ref), size = layout.size(block), at = rows.columns;
    if (size == 0) return -1;
    rows.part[rows.parts++] = {block, size, at};
    rows.columns += size;
    return at;
  };
  const int camera = problem.images[term.image].camera;
  const auto& free = layout.free_values(camera);
  Columns columns;
  columns.image = next({Kind::image, term.image});
  columns.interior = next({Kind::camera, camera});
  columns.free = free.data();
  columns.free_count = static_cast<int>(free.size());
  columns.principal_point = principal_point(tag.lens);
  columns.shift = next({Kind::shift, term.image});
  columns.scale = next({Kind::scale, problem.plates[term.plate].batch});
  columns.inset = next({Kind::inset, batch_of_inset(problem, term)});
  const Plate& plate = problem.plates[term.plate];
  columns.form = next({Kind::form, term.plate});
  columns.form_begin = plate.form_begin, columns.form_end = plate.form_end;
  columns.plate = next({Kind::plate, term.plate});
  return rows_of(tag, &columns, rows.residual.data(), rows.storage.data());
}

bool gradient_of(const Problem& problem, const State& state, const ImageTag& term, TagGradient& gradient) {
  const TagInput tag = input_of(problem, state, term);
  const int count = value_count(tag.lens);
  if (!sum_gradient(tag, count, gradient)) return false;
  gradient.by_interior.tail(max_interior - count).setZero();
  gradient.by_shift = gradient.by_interior.segment<2>(principal_point(tag.lens));
  return true;
}

}  // namespace plumbline::bundle

#include "file_axes.hpp"

#include <array>
#include <stdexcept>

namespace plumbline::survey {

namespace {

/// Turns a vector; NaN stays with its own axis (a product with the matrix would spread it).
Eigen::Vector3d turned(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& v) {
  Eigen::Vector3d result;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      if (rotation(row, column) != 0) result[row] = rotation(row, column) * v[column];
  return result;
}

/// A component E, N or H of coordinates and vectors becomes x, y or z; what has a sign may change it.
void turn_component(const Eigen::Matrix3d& rotation, NetworkObservationT& o) {
  const size_t from = std::string("ENH").find(o.detail);
  if (from == std::string::npos) return;
  for (int row = 0; row < 3; ++row) {
    const double sign = rotation(row, static_cast<Eigen::Index>(from));
    if (sign == 0) continue;
    o.detail = std::string(1, "xyz"[row]);
    for (double* value : {&o.value, &o.residual, &o.w, &o.estimated_blunder}) *value *= sign;
    return;
  }
}

}  // namespace

Eigen::Matrix3d file_from_enh(const std::string& axes) {
  static const std::string names = "enws";
  static const std::array<Eigen::RowVector3d, 4> directions = {Eigen::RowVector3d(1, 0, 0), Eigen::RowVector3d(0, 1, 0),
                                                               Eigen::RowVector3d(-1, 0, 0),
                                                               Eigen::RowVector3d(0, -1, 0)};
  const size_t x = axes.size() == 2 ? names.find(axes[0]) : std::string::npos;
  const size_t y = axes.size() == 2 ? names.find(axes[1]) : std::string::npos;
  if (x == std::string::npos || y == std::string::npos || x % 2 == y % 2)
    throw std::runtime_error("axes '" + axes + "': expected one of en, nw, se, ws, ne, sw, es, wn");
  Eigen::Matrix3d rotation;
  rotation << directions[x], directions[y], Eigen::RowVector3d::UnitZ();
  return rotation;
}

void turn_to_file_axes(SurveyNetworkT& network, const std::string& axes) {
  const Eigen::Matrix3d rotation = file_from_enh(axes);
  network.axes = axes;
  if (axes == "en") return;
  for (auto& p : network.points) {
    p->position = turned(rotation, p->position);
    p->sigma = turned(rotation.cwiseAbs(), p->sigma);
  }
  for (auto& e : network.ellipsoids) {
    e->first_axis = turned(rotation, e->first_axis);
    e->second_axis = turned(rotation, e->second_axis);
  }
  for (auto& o : network.observations)
    if (o->kind == "coordinate" || o->kind == "vector") turn_component(rotation, *o);
}

}  // namespace plumbline::survey

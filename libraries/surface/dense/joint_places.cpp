#include "surface/dense/joint_places.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace plumbline::surface {
namespace {

/// Median of the slopes of pairs, and of the offsets (Theil 1950, Sen 1968): a line that a third of false places
/// leaves.
Eigen::Vector2d robust_line(const std::vector<double>& x, const std::vector<double>& y) {
  const auto median = [](std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values.empty() ? 0.0 : 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
  };
  std::vector<double> slopes, offsets;
  for (size_t i = 0; i < x.size(); ++i)
    for (size_t j = 0; j < i; ++j) slopes.push_back((y[i] - y[j]) / (x[i] - x[j]));
  const double slope = median(slopes);
  for (size_t i = 0; i < x.size(); ++i) offsets.push_back(y[i] - slope * x[i]);
  return {median(offsets), slope};
}

/// Of the edge that is nearest to a place of the panel.
double misfit_at(const PanelSurface& surface, double u, double v) {
  const double ways[] = {surface.half_width + u, surface.half_width - u, surface.half_height + v,
                         surface.half_height - v};
  return surface.edge_misfit(std::min_element(std::begin(ways), std::end(ways)) - std::begin(ways));
}

}  // namespace

EdgeHeight height_at(const EdgeLine& line, const FacadePlane& plane, double u, double v) {
  const Eigen::Vector3d on_face = line.face->plane.local(plane.world({u, v, 0}));
  EdgeHeight result;
  Eigen::Vector3d place(on_face.x(), on_face.y(), 0);
  result.design = plane.local(line.face->plane.world(place)).z();
  if (line.surface && line.surface->not_measured.empty()) {
    result.measured = true;
    result.base = line.surface->base(on_face.x(), on_face.y());
    place.z() = result.base.dot(line.surface->form);
    result.variance = result.base.dot(line.surface->form_random * result.base) +
                      std::pow(misfit_at(*line.surface, on_face.x(), on_face.y()), 2);
  }
  result.height = plane.local(line.face->plane.world(place)).z();
  return result;
}

std::array<EdgeLine, 2> edge_lines(const Joint& joint, const std::vector<PanelFace>& faces,
                                   const std::vector<PanelSurface>& surfaces) {
  const auto line = [&](size_t face, double nominal) {
    return EdgeLine{nominal, &faces[face], face < surfaces.size() ? &surfaces[face] : nullptr};
  };
  return {line(joint.face_a, -0.5 * joint.width), line(joint.face_b, 0.5 * joint.width)};
}

void add_step(JointStation& station, const EdgeLine& line_a, const EdgeLine& line_b, const FacadePlane& plane, double a,
              double b) {
  const EdgeHeight of_a = height_at(line_a, plane, a, station.along), of_b = height_at(line_b, plane, b, station.along);
  station.step = station.step_sigma = std::numeric_limits<double>::quiet_NaN();
  if (!of_a.measured || !of_b.measured) return;
  station.step = (of_b.height - of_b.design) - (of_a.height - of_a.design);
  const PanelSurface &sa = *line_a.surface, &sb = *line_b.surface;
  const Eigen::Index rank = std::max(sa.form_factor.cols(), sb.form_factor.cols());
  Eigen::RowVectorXd factor = Eigen::RowVectorXd::Zero(rank);
  factor.head(sb.form_factor.cols()) += of_b.base.transpose() * sb.form_factor;
  factor.head(sa.form_factor.cols()) -= of_a.base.transpose() * sa.form_factor;
  station.step_sigma = std::sqrt(of_a.variance + of_b.variance + factor.squaredNorm());
}

namespace {

/// Which places of an edge are believed, by how far they lie off its line: what is off by itself looked like an edge;
/// so many neighbours off to one side are where the edge is, a bulge or a dent of the panel.
void leave_out_single_places(const std::vector<double>& along, const std::vector<double>& off, double bow, size_t run,
                             std::vector<char>& believed) {
  double spacing = std::numeric_limits<double>::infinity();
  for (size_t s = 1; s < along.size(); ++s) spacing = std::min(spacing, along[s] - along[s - 1]);
  for (size_t from = 0, to = 0; from < off.size(); from = to) {
    const auto same = [&](size_t s) { return std::abs(off[s]) > bow && (off[s] > 0) == (off[from] > 0); };
    for (to = from + 1; same(from) && to < off.size() && same(to) && along[to] - along[to - 1] < 1.5 * spacing;) ++to;
    if (same(from) && to - from < run) std::fill(believed.begin() + from, believed.begin() + to, 0);
  }
}

}  // namespace

void keep_straight(MeasuredJoint& measured, const std::vector<EdgePair>& edges, double bow, size_t run) {
  std::vector<double> along;
  for (const JointStation& station : measured.stations) along.push_back(station.along);
  std::vector<char> straight(edges.size(), 1);
  double factor[2];
  for (int e : {0, 1}) {
    std::vector<double> places, off, sizes;
    for (const EdgePair& pair : edges) places.push_back(pair.u[e]);
    const Eigen::Vector2d line = robust_line(along, places);
    for (size_t s = 0; s < edges.size(); ++s) {
      off.push_back(places[s] - line(0) - line(1) * along[s]);
      if (std::abs(off[s]) <= bow) sizes.push_back(std::abs(off[s]) / std::sqrt(edges[s].variance[e]));
    }
    leave_out_single_places(along, off, bow, run, straight);
    std::sort(sizes.begin(), sizes.end());
    const double scatter = sizes.size() > 4 ? 1.4826 * sizes[sizes.size() / 2] : 1;
    factor[e] = std::max(1.0, scatter * scatter);
  }
  std::vector<JointStation> kept;
  for (size_t s = 0; s < edges.size(); ++s) {
    if (!straight[s]) continue;
    JointStation station = measured.stations[s];
    double more = 0;
    for (int e : {0, 1}) more += (factor[e] - 1) * edges[s].variance[e];
    station.width_sigma = std::hypot(station.width_sigma, std::sqrt(more));
    station.width_random = std::hypot(station.width_random, std::sqrt(more));
    station.shift_sigma = std::hypot(station.shift_sigma, 0.5 * std::sqrt(more));
    kept.push_back(station);
  }
  measured.stations = std::move(kept);
}

bool is_covered(const std::array<EdgeLine, 2>& lines, const FacadePlane& plane, double along, double reach) {
  for (const EdgeLine& line : lines) {
    if (!line.surface) continue;
    const double cell = line.surface->cell;
    for (const Eigen::Vector2d& middle : line.surface->before) {
      const Eigen::Vector3d at = plane.local(line.face->plane.world({middle.x(), middle.y(), 0}));
      if (std::abs(at.y() - along) <= cell + reach && std::abs(at.x() - line.nominal) <= 1.5 * cell) return true;
    }
  }
  return false;
}

int without_edges(const std::vector<LookedAt>& places, const std::vector<JointStation>& believed) {
  constexpr double least = 0.06 - 1e-9;  // a tube or a rope before a joint hides less [m]
  const double spacing = places.size() > 1 ? places[1].along - places[0].along : 0;
  const auto open = [&](const LookedAt& place) {
    return !place.looked || std::any_of(believed.begin(), believed.end(), [&](const JointStation& station) {
      return std::abs(station.along - place.along) < 1e-9;
    });
  };
  int count = 0;
  for (size_t from = 0, to = 0; from < places.size(); from = to) {
    int with_edge = 0;
    for (to = from; to < places.size() && !open(places[to]); ++to) with_edge += places[to].edge;
    const int length = static_cast<int>(to - from);
    if (length > 1 && length * spacing >= least && 2 * with_edge < length) count += length;
    if (to == from) ++to;
  }
  return count;
}

void sum_up(MeasuredJoint& measured, const std::string& what) {
  const auto& stations = measured.stations;
  if (2 * static_cast<int>(stations.size()) < measured.stations_looked_at) {
    measured.not_measured = what + " at " + std::to_string(stations.size()) + " of " +
                            std::to_string(measured.stations_looked_at) + " places along it";
    measured.stations.clear();
    return;
  }
  for (size_t s = 0; s < stations.size(); ++s) {
    if (stations[s].width < stations[measured.narrowest].width) measured.narrowest = s;
    if (stations[s].width > stations[measured.widest].width) measured.widest = s;
    if (!(std::abs(stations[s].step) <= std::abs(stations[measured.largest_step].step))) measured.largest_step = s;
    if (std::abs(stations[s].shift) > std::abs(stations[measured.largest_shift].shift)) measured.largest_shift = s;
  }
}

}  // namespace plumbline::surface

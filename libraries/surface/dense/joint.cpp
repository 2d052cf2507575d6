#include "surface/dense/joint.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "plumbline/stop.hpp"
#include "surface/dense/edge_profile.hpp"
#include "surface/dense/joint_places.hpp"

namespace plumbline::surface {
namespace {

constexpr double kSamples = 2;  // of a profile for one pixel on the ground
constexpr double kWindow = 6;   // half the window of an edge's fit [px]

/// Mean grey values across the joint in one photograph, from `from` on and `step` apart. What lies left of `split` is
/// taken at one height, what lies right of it at another, because each edge is its panel's.
std::vector<double> profile(const FacetView& view, const LocalMap& map, const Eigen::Vector3d& centre, double from,
                            double step, int count, double along, const double heights[2], double split) {
  const int rows = std::max(1, static_cast<int>(std::lround(along / map.ground_pixel())));
  const GreyImage& image = view.image->level[0];
  std::vector<double> values(static_cast<size_t>(count));
  for (int i = 0; i < count; ++i) {
    double sum = 0;
    const double u = from + i * step;
    for (int r = 0; r < rows; ++r) {
      const Eigen::Vector3d offset(u - centre.x(), ((r + 0.5) / rows - 0.5) * along,
                                   heights[u < split ? 0 : 1] - centre.z());
      const Eigen::Vector2d pixel = map.pixel + map.by_place * offset;
      const int x = static_cast<int>(std::floor(pixel.x())), y = static_cast<int>(std::floor(pixel.y()));
      if (x < 0 || y < 0 || x + 1 >= image.width || y + 1 >= image.height) return {};
      const double a = pixel.x() - x, b = pixel.y() - y;
      const auto at = [&](int column, int row) {
        return static_cast<double>(image.pixels[static_cast<size_t>(row) * image.width + column]);
      };
      sum += (at(x, y) * (1 - a) + at(x + 1, y) * a) * (1 - b) + (at(x, y + 1) * (1 - a) + at(x + 1, y + 1) * a) * b;
    }
    values[i] = sum / rows;
  }
  return values;
}

/// What one photograph says of an edge at one station.
struct EdgeSight {
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();  ///< of its ray: where it was taken from
  double place = 0, sigma = 0;                      ///< u at the height that was assumed [m]
  double parallax = 0;                              ///< change of that by height
  Eigen::RowVectorXd by_orientation;
};

/// An edge at one station from all photographs.
struct EdgePlace {
  bool found = false;
  double u = 0, variance = 0;  ///< random part [m], [m²]
  double by_height = 0;        ///< what it is off if its height is by one standard deviation: all stations alike [m]
  Eigen::RowVectorXd by_orientation;
  int views = 0;
};

class Station {
 public:
  Station(const Joint& joint, const EdgeLine& a, const EdgeLine& b, bool dark, const std::vector<FacetView>& views,
          const OrientationCovariance& orientations, const JointOptions& options)
      : joint_(joint), lines_{a, b}, dark_(dark), views_(views), orientations_(orientations), options_(options) {}

  /// Both edges; `found` says whether. `looking`: from how many places photographs look, whatever they show.
  std::array<EdgePlace, 2> edges(double along, int& looking) const {
    double heights[2], sigmas[2];
    int least[2];
    for (size_t e : {0, 1}) {
      const EdgeHeight at = height_at(lines_[e], joint_.plane, lines_[e].nominal, along);
      heights[e] = at.height;
      sigmas[e] = at.measured ? std::sqrt(options_.height_sigma * options_.height_sigma + at.variance)
                              : options_.unmeasured_height_sigma;
      // Where the height has to come from the same sights, two of them have nothing left to contradict each other by.
      least[e] = at.measured ? options_.min_views : std::max(options_.min_views, 3);
    }
    std::vector<EdgeSight> sights[2];
    std::vector<Eigen::Vector2d> witnesses;
    for (const FacetView& view : views_) look(view, along, heights, sights, witnesses);
    looking = static_cast<int>(witnesses.size());
    return {intersect(std::move(sights[0]), sigmas[0], least[0]), intersect(std::move(sights[1]), sigmas[1], least[1])};
  }

 private:
  /// What the photograph shows of the edges goes to `sights`. `witnesses`: slopes of the rays of those that have the
  /// place in them, whatever they show; a copy of one, or a burst, is no other witness.
  void look(const FacetView& view, double along, const double heights[2], std::vector<EdgeSight>* sights,
            std::vector<Eigen::Vector2d>& witnesses) const {
    const Eigen::Vector3d centre(0, along, 0.5 * (heights[0] + heights[1]));
    const auto map = map_at(*view.view, joint_.plane, centre, 12);
    if (!map) return;
    const auto same_as = [&](const Eigen::Vector2d& slope) { return (slope - map->parallax()).norm() < kOnePlace; };
    for (const EdgeSight& other : sights[0])
      if (same_as(other.slope)) return;
    const double step = map->ground_pixel() / kSamples, window = kWindow * kSamples;
    const double reach = 0.5 * joint_.width + options_.search + window * step;
    const int half = static_cast<int>(std::ceil(reach / step));
    // Panels may hang so far aside that an edge lies beyond the joint's middle in the design, at its neighbour's
    // height: the second time the profile is divided where the joint is.
    std::optional<GapEdges> gap;
    double split = 0;
    for (int pass = 0; pass < 2; ++pass) {
      const auto grey = profile(view, *map, centre, -half * step, step, 2 * half + 1, options_.station, heights, split);
      if (grey.empty()) return;
      if (pass == 0 && std::none_of(witnesses.begin(), witnesses.end(), same_as)) witnesses.push_back(map->parallax());
      const double first = steepest(grey, half + lines_[0].nominal / step, options_.search / step, !dark_);
      const double second = steepest(grey, half + lines_[1].nominal / step, options_.search / step, dark_);
      if (first < 0 || second <= first) return;
      gap = fit_gap(grey, first, second, window, dark_);
      if (!gap) return;
      if (gap->place[0] - half < split / step && gap->place[1] - half > split / step) break;
      if (pass == 1) return;
      split = (0.5 * (gap->place[0] + gap->place[1]) - half) * step;
    }
    for (int e : {0, 1}) {
      const double u = (gap->place[e] - half) * step;
      const auto at = map_at(*view.view, joint_.plane, {u, along, heights[e]}, 0);
      if (!at) return;
      const Eigen::Matrix2d plane_from_pixel = at->by_place.leftCols<2>().inverse();
      EdgeSight sight;
      sight.slope = map->parallax(), sight.place = u;
      // Neighbouring samples share pixels, so each counts for less than one: kSamples of them for a pixel.
      sight.sigma = std::max(gap->sigma[e] * step * std::sqrt(kSamples), 0.01 * map->ground_pixel());
      sight.parallax = at->parallax().x();
      sight.by_orientation = Eigen::RowVectorXd::Zero(orientations_.size());
      if (view.view->orientation >= 0)
        sight.by_orientation.segment<8>(orientations_.of_image(view.view->orientation)) =
            -(plane_from_pixel * at->by_image).row(0);
      if (view.view->camera_number < orientations_.cameras)
        sight.by_orientation.segment<9>(orientations_.of_camera(view.view->camera_number)) =
            -(plane_from_pixel * at->by_camera).row(0);
      sights[e].push_back(sight);
    }
  }

  /// Covariance of the sights' places: noise, the edge's height, and the orientations.
  Eigen::MatrixXd covariance_of(const std::vector<EdgeSight>& sights, double height_sigma) const {
    const Eigen::Index n = static_cast<Eigen::Index>(sights.size());
    Eigen::MatrixXd by(n, orientations_.size());
    Eigen::VectorXd parallax(n), noise(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const EdgeSight& s = sights[i];
      by.row(i) = s.by_orientation, parallax(i) = s.parallax, noise(i) = s.sigma * s.sigma;
    }
    Eigen::MatrixXd covariance = height_sigma * height_sigma * parallax * parallax.transpose();
    covariance.diagonal() += noise;
    if (by.cols() > 0) covariance += by * orientations_.matrix * by.transpose();
    return covariance;
  }

  /// The best mean of the sights; those that stand out go, the worst first. With a `height_sigma` that is large beside
  /// the noise over the difference of the rays' slopes, this is the intersection of the rays: the weights are such that
  /// the height leaves the place as it is.
  EdgePlace intersect(std::vector<EdgeSight> sights, double height_sigma, int least) const {
    EdgePlace place;
    while (static_cast<int>(sights.size()) >= least) {
      const Eigen::Index n = static_cast<Eigen::Index>(sights.size());
      const Eigen::MatrixXd inverse = covariance_of(sights, height_sigma).inverse();
      const Eigen::VectorXd ones = Eigen::VectorXd::Ones(n);
      const Eigen::RowVectorXd weight = ones.transpose() * inverse / ones.dot(inverse * ones);
      Eigen::VectorXd seen(n);
      for (Eigen::Index i = 0; i < n; ++i) seen(i) = sights[i].place;
      const double u = weight * seen;
      const Eigen::VectorXd off = inverse * (seen - u * ones);
      const double factor = std::max(1.0, (seen - u * ones).dot(off) / std::max<double>(static_cast<double>(n) - 1, 1));
      Eigen::Index worst = 0;  // by its own test: (C⁻¹ v)ᵢ over the root of (C⁻¹)ᵢᵢ
      const double largest = (off.array().abs() / inverse.diagonal().array().sqrt()).maxCoeff(&worst);
      if (largest > 4 && n > least) {
        sights.erase(sights.begin() + static_cast<std::ptrdiff_t>(worst));
        continue;
      }
      if (factor > 16) break;  // photographs that show different edges
      place.found = true, place.views = static_cast<int>(n), place.u = u;
      place.by_orientation = Eigen::RowVectorXd::Zero(orientations_.size());
      double noise = 0;
      for (Eigen::Index i = 0; i < n; ++i) {
        const EdgeSight& s = sights[i];
        place.by_orientation += weight(i) * s.by_orientation;
        noise += weight(i) * weight(i) * s.sigma * s.sigma;
        place.by_height += std::sqrt(factor) * weight(i) * s.parallax * height_sigma;
      }
      place.variance = factor * noise;
      break;
    }
    return place;
  }

  const Joint& joint_;
  EdgeLine lines_[2];
  bool dark_;
  const std::vector<FacetView>& views_;
  const OrientationCovariance& orientations_;
  const JointOptions& options_;
};

/// Whether grey values fall at edge a: the joint is darker than the panels. By the mean over the whole joint in all
/// photographs that see its middle: of all places as wide as the joint, within the search, the darkest and the lightest
/// are held against the panels beside, because a joint may lie beside where the design has it.
bool joint_is_dark(const Joint& joint, const std::vector<FacetView>& views, double search) {
  constexpr double side = 0.01;  // of a panel that is looked at [m]
  const double step = std::max(0.1 * joint.width, 2e-4), reach = 0.5 * joint.width + search + side;
  const int half = static_cast<int>(std::ceil(reach / step)), count = 2 * half + 1,
            of_side = std::max(1, static_cast<int>(side / step)),
            of_joint = std::max(1, static_cast<int>(0.7 * joint.width / step));
  std::vector<double> mean(static_cast<size_t>(count));
  int seen = 0;
  for (const FacetView& view : views)
    for (int part = -2; part <= 2; ++part) {
      const Eigen::Vector3d centre(0, part * 0.2 * joint.length, 0);
      const auto map = map_at(*view.view, joint.plane, centre, 12);
      if (!map) continue;
      const double on_the_plane[2] = {0, 0};
      const auto grey = profile(view, *map, centre, -half * step, step, count, 0.02, on_the_plane, 0);
      if (grey.empty()) continue;
      ++seen;
      for (size_t i = 0; i < grey.size(); ++i) mean[i] += grey[i];
    }
  const auto over = [&](int from, int to) {
    double sum = 0;
    for (int i = from; i < to; ++i) sum += mean[i];
    return sum / (to - from);
  };
  const double panels = 0.5 * (over(0, of_side) + over(count - of_side, count));
  double darkest = panels, lightest = panels;
  for (int i = of_side; seen > 0 && i + of_joint <= count - of_side; ++i) {
    const double here = over(i, i + of_joint);
    darkest = std::min(darkest, here), lightest = std::max(lightest, here);
  }
  return panels - darkest >= lightest - panels;
}

/// The panels that were not measured, in words; empty: both were.
std::string unmeasured_of(const EdgeLine& a, const EdgeLine& b) {
  std::string names;
  for (const EdgeLine* line : {&a, &b})
    if (!line->surface || !line->surface->not_measured.empty())
      names += (names.empty() ? "panel '" : " and panel '") + line->face->id + "'";
  return names;
}

JointStation station_of(const EdgePlace& a, const EdgePlace& b, const EdgeLine& line_a, const EdgeLine& line_b,
                        const Joint& joint, const OrientationCovariance& orientations, double along) {
  JointStation station;
  station.along = along;
  station.width = b.u - a.u;
  const Eigen::RowVectorXd row = b.by_orientation - a.by_orientation;
  const double common = orientations.size() > 0 ? (row * orientations.matrix * row.transpose())(0) : 0;
  station.width_random = std::sqrt(a.variance + b.variance);
  station.width_by_edge = {-a.by_height, b.by_height}, station.width_by_orientation = row;
  station.width_sigma = std::sqrt(a.variance + b.variance + station.width_by_edge.squaredNorm() + common);
  station.views = std::min(a.views, b.views);
  if (orientations.size() > 0) {
    const Eigen::RowVectorXd of_both = 0.5 * (a.by_orientation + b.by_orientation);
    station.shift = 0.5 * (a.u + b.u);
    station.shift_sigma = std::sqrt(0.25 * (a.variance + b.variance + station.width_by_edge.squaredNorm()) +
                                    (of_both * orientations.matrix * of_both.transpose())(0));
  }
  add_step(station, line_a, line_b, joint.plane, a.u, b.u);
  return station;
}

}  // namespace

MeasuredJoint measure_joint(const Joint& joint, const std::vector<PanelFace>& faces,
                            const std::vector<PanelSurface>& surfaces, const std::vector<FacetView>& views,
                            const OrientationCovariance& orientations, const JointOptions& options) {
  MeasuredJoint measured;
  const bool dark = joint_is_dark(joint, views, options.search);
  const auto lines = edge_lines(joint, faces, surfaces);
  const auto& [a, b] = lines;
  const Station station(joint, a, b, dark, views, orientations, options);
  const int count = std::max(1, static_cast<int>((joint.length - options.station) / options.station));
  int one_edge = 0;
  std::vector<EdgePair> edges;
  std::vector<LookedAt> places;
  for (int s = 0; s < count; ++s) {
    stop_point();
    const double along = ((s + 0.5) / count - 0.5) * (joint.length - options.station);
    ++measured.stations_looked_at;
    if (is_covered(lines, joint.plane, along, options.station)) {
      ++measured.covered;
      places.push_back({along, false, false});
      continue;
    }
    int looking = 0;
    const auto [edge_a, edge_b] = station.edges(along, looking);
    places.push_back({along, looking >= options.min_views, edge_a.found || edge_b.found});
    if (!edge_a.found || !edge_b.found) {
      one_edge += edge_a.found || edge_b.found;
      continue;
    }
    measured.stations.push_back(station_of(edge_a, edge_b, a, b, joint, orientations, along));
    edges.push_back({{edge_a.u, edge_b.u}, {edge_a.variance, edge_b.variance}});
  }
  if (measured.stations.empty()) {
    const std::string unknown = unmeasured_of(a, b);
    measured.not_measured =
        !unknown.empty() ? "its edges show in fewer than 3 photographs, and " + unknown +
                               " is not measured, so that two say nothing of where its edge is in depth"
        : one_edge > 0 ? "only one of its edges shows in " + std::to_string(options.min_views) + " photographs or more"
                       : "its edges show in fewer than " + std::to_string(options.min_views) + " photographs";
    return measured;
  }
  constexpr double bow = 0.0015;  // of an edge: grain that looked like one lies further off [m]
  constexpr size_t run = 3;       // of places that are off together
  keep_straight(measured, edges, bow, run);
  // Of a panel that nobody measured it is not known whether there is anything to see.
  if (unmeasured_of(a, b).empty()) measured.closed = without_edges(places, measured.stations);
  sum_up(measured, "two straight edges show");
  if (!measured.not_measured.empty() && measured.covered > 0)
    measured.not_measured += "; at " + std::to_string(measured.covered) + " something stands before an edge";
  return measured;
}

}  // namespace plumbline::surface

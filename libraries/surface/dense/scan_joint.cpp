#include "surface/dense/scan_joint.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "plumbline/stop.hpp"
#include "surface/dense/joint_places.hpp"

namespace plumbline::surface {
namespace {

constexpr size_t kLeastPoints = 12;  // of a panel's strip at one place along the joint
constexpr double kLeastSpan = 0.25;  // of the strip, from its first point to its last
// Of points in the joint, against the panel's own density, lie as far out as the panels do: by chance one of a
// thousand; where a beam meets edge and ground and comes back from between both (mixed pixels) many; of more nobody can
// tell the joint from the panel.
constexpr double kLeastShare = 0.001, kMostShare = 0.5;
constexpr double kTellApart = 1.5;  // a joint is wider than so many of the largest gaps between the panel's own points

/// Points near the joint at one place along it, by u.
struct Profile {
  std::vector<double> on;          ///< on the surface of the panel of their side, in order
  size_t near = 0, elsewhere = 0;  ///< within the joint's own width: just below a panel's surface, and deeper
};

/// What a place along the joint says.
enum class Saw { joint, too_few_points, one_column, no_gap, shallow, closed, beyond };

/// Between the last point on a and the first one on b.
struct Opening {
  double from = 0, to = 0;  ///< [m]
  double share = 0;         ///< of the panels' density that points in it had when it was found
};

/// By how much the variance of an edge is larger, over that of the panel's own points, where a change of density from 1
/// to `share` has to be told instead of an end: by the inverse square of what a point's distance in the joint says
/// against the panel (Kullback-Leibler), times a factor that holds for points at random, as simulated (3000 edges each:
/// 3.8, 6.4, 15, 38 and 150 in all for 0.05, 0.1, 0.2, 0.3 and 0.5), and for those of a grid.
double blurred_by(double share) {
  constexpr double factor = 6;
  if (share <= kLeastShare) return 0;  // the joint is empty
  const double says = 1 - share + share * std::log(share);
  return factor * (1 / (says * says) - 1);
}

class ScanStations {
 public:
  ScanStations(const Joint& joint, const std::array<EdgeLine, 2>& lines, const std::vector<MeasuredTile>& tiles,
               const ScanJointOptions& options)
      : joint_(joint),
        lines_(lines),
        options_(options),
        count_(std::max(1, static_cast<int>(joint.length / options.station))),
        profiles_(static_cast<size_t>(count_)) {
    for (const MeasuredTile& tile : tiles)
      for (const MeasuredPoint& point : tile.points) sort_in(joint.plane.local(tile.at(point)), point.sigma);
    for (Profile& profile : profiles_) std::sort(profile.on.begin(), profile.on.end());
  }

  int count() const { return count_; }
  double along(int station) const { return ((station + 0.5) / count_ - 0.5) * joint_.length; }

  /// Both edges at a station.
  Saw edges(int station, EdgePair& found) const {
    const Profile& profile = profiles_[station];
    CutOff cut[2];
    double density = 1e300;  // points of a metre across the joint
    for (int side : {0, 1}) {
      const std::vector<double> strip = of_strip(profile, side);
      if (strip.size() < kLeastPoints) return Saw::too_few_points;
      // One column along the joint says nothing of how far the next one is.
      if (strip.back() - strip.front() < kLeastSpan * options_.strip) return Saw::one_column;
      cut[side] = cut_off(strip);
      density = std::min(density, static_cast<double>(strip.size() - 1) / (strip.back() - strip.front()));
    }
    const auto gap = gap_and_share(profile.on, density, options_.search);
    const double least = kTellApart * std::max(cut[0].largest, cut[1].largest);
    if (!shows(gap, least)) return why_none(profile.on, density, least);
    if (profile.near > profile.elsewhere) return Saw::shallow;
    if (at_the_border(*gap, profile.on, cut, density)) return Saw::beyond;
    found.u[0] = gap->from + cut[0].mean, found.u[1] = gap->to - cut[1].mean;
    for (int side : {0, 1})
      found.variance[side] =
          cut[side].variance + blurred_by(gap->share) * std::max(cut[side].variance, 1 / (density * density));
    return Saw::joint;
  }

 private:
  void sort_in(const Eigen::Vector3d& local, float noise) {
    const double reach = 0.5 * joint_.width + options_.search + options_.strip;
    if (!(std::abs(local.x()) <= reach) || !(std::abs(local.y()) <= 0.5 * joint_.length)) return;
    const int station = std::min(count_ - 1, static_cast<int>((local.y() / joint_.length + 0.5) * count_));
    Profile& profile = profiles_[station];
    double nearest = 1e300, limit = 0;
    for (int side : {0, 1}) {
      // In the joint's own width nobody knows yet whose a point is.
      if (side == 0 ? local.x() > options_.search : local.x() < -options_.search) continue;
      // Edges that are bent off the fitted surface are the panel's too.
      const EdgeHeight at = height_at(lines_[side], joint_.plane, local.x(), local.y());
      const double off = std::abs(local.z() - at.height);
      if (off < nearest)
        nearest = off, limit = options_.off * std::hypot(static_cast<double>(noise), std::sqrt(at.variance));
    }
    if (nearest <= limit) return profile.on.push_back(local.x());
    if (std::abs(local.x()) < 0.25 * joint_.width) ++(nearest < 1.5 * limit ? profile.near : profile.elsewhere);
  }

  /// Points on a panel beside its edge, further in than the edge may be.
  std::vector<double> of_strip(const Profile& profile, int side) const {
    const double border = 0.5 * joint_.width + options_.search;
    const auto first = side == 0 ? profile.on.begin() : std::lower_bound(profile.on.begin(), profile.on.end(), border);
    const auto last = side == 0 ? std::upper_bound(profile.on.begin(), profile.on.end(), -border) : profile.on.end();
    return first < last ? std::vector<double>(first, last) : std::vector<double>();
  }

  /// The last place on a and the first one on b: of all pairs within the search the one between which most points are
  /// missing, each that is there counting against it. A change of density as by its likelihood, with a running best.
  /// `share`: of the panel's density that the joint's own points have.
  std::optional<Opening> widest_gap(const std::vector<double>& on, double density, double share, double search) const {
    const double price = -std::log(share);
    std::optional<Opening> best;
    double most = 0, from = 0, start = 0;
    bool any = false;
    for (size_t i = 0; i < on.size(); ++i) {
      const double value = (1 - share) * density * on[i] - price * static_cast<double>(i);
      if (any && std::abs(on[i] - 0.5 * joint_.width) <= search) {
        const double missing = value - start + price;
        if (missing > most) most = missing, best = Opening{from, on[i], share};
      }
      if (std::abs(on[i] + 0.5 * joint_.width) <= search && (!any || value <= start))
        start = value, from = on[i], any = true;
    }
    return best;
  }

  static bool shows(const std::optional<Opening>& gap, double least) {
    return gap && gap->to - gap->from >= least && gap->share < kMostShare;
  }

  /// Of a place between whose panels no points are missing within the search: an edge may lie further in than that; a
  /// hole that is wider than those between the panel's own points, in what is half as dense, is neither joint nor
  /// panel; without one a joint as designed would have shown.
  Saw why_none(const std::vector<double>& on, double density, double least) const {
    const auto anywhere = gap_and_share(on, density, std::max(options_.search, joint_.width));
    if (shows(anywhere, least) && std::max(std::abs(anywhere->from + 0.5 * joint_.width),
                                           std::abs(anywhere->to - 0.5 * joint_.width)) > options_.search)
      return Saw::beyond;
    const auto hole = widest_gap(on, density, kLeastShare, options_.search);
    if (hole && hole->to - hole->from >= least) return Saw::shallow;
    return least < 0.5 * joint_.width ? Saw::closed : Saw::no_gap;
  }

  /// Whether an edge lies further in than it was looked for: the gap ends where the search does, and there the panel's
  /// points go on.
  bool at_the_border(const Opening& gap, const std::vector<double>& on, const CutOff (&cut)[2], double density) const {
    constexpr double steps = 2, share = 0.3;  // of the points beside the edge; of their density
    const double inmost = options_.search - 0.5 * joint_.width;
    // What lies between the ends alone: behind the gap the other panel begins.
    const auto goes_on = [&](double from, double to) {
      if (!(to > from)) return false;
      const auto count = std::lower_bound(on.begin(), on.end(), to) - std::upper_bound(on.begin(), on.end(), from);
      return static_cast<double>(count) > share * density * (to - from);
    };
    const double left = steps * cut[0].largest, right = steps * cut[1].largest;
    return (inmost - gap.from < left && goes_on(inmost, std::min(inmost + left, gap.to))) ||
           (inmost + gap.to < right && goes_on(std::max(-inmost - right, gap.from), -inmost));
  }

  /// With the share that the gap itself shows, in a few turns from the most on: with too small a share the gap would be
  /// the largest hole between two mixed pixels.
  std::optional<Opening> gap_and_share(const std::vector<double>& on, double density, double search) const {
    constexpr int turns = 6;
    double share = kMostShare;
    std::optional<Opening> gap;
    for (int turn = 0; turn < turns; ++turn) {
      gap = widest_gap(on, density, share, search);
      if (!gap) return gap;
      // In its middle, as the last points of a panel, taken into it once, would speak for being there again.
      const double width = gap->to - gap->from, from = gap->from + 0.2 * width, to = gap->to - 0.2 * width;
      const auto inside = std::lower_bound(on.begin(), on.end(), to) - std::upper_bound(on.begin(), on.end(), from);
      const double there = static_cast<double>(inside) / (density * (to - from));
      const double next = std::clamp(there, kLeastShare, kMostShare);
      if (std::abs(next - share) < 0.01 * share) break;
      share = next;
    }
    return gap;
  }

  const Joint& joint_;
  const std::array<EdgeLine, 2>& lines_;
  const ScanJointOptions& options_;
  int count_;
  std::vector<Profile> profiles_;
};

/// What the scan's place is off by across the joint at a place of it, as its nearest tile has it; nan where nobody says
/// how well that place is known.
double place_sigma(const Joint& joint, double along, const std::vector<MeasuredTile>& tiles) {
  const Eigen::Vector3d at = joint.plane.world({0, along, 0}), across = joint.plane.axes.col(0);
  const MeasuredTile* nearest = nullptr;
  for (const MeasuredTile& tile : tiles)
    if (!nearest || (tile.centre - at).squaredNorm() < (nearest->centre - at).squaredNorm()) nearest = &tile;
  if (!nearest || nearest->factor.cols() == 0) return std::numeric_limits<double>::quiet_NaN();
  Eigen::Matrix<double, 1, 6> row;  // of the tile's (t, ω): across · (ω × arm) = ω · (arm × across)
  row << across.transpose(), (at - nearest->centre).cross(across).transpose();
  return (row * nearest->factor).norm();
}

/// Places without a gap that have a neighbour without one.
int closed_together(const std::vector<Saw>& seen) {
  int count = 0;
  for (size_t s = 0; s < seen.size(); ++s)
    count += seen[s] == Saw::closed &&
             ((s > 0 && seen[s - 1] == Saw::closed) || (s + 1 < seen.size() && seen[s + 1] == Saw::closed));
  return count;
}

/// Of the places without a joint, most of which say the same.
std::string reason_of(const std::vector<Saw>& seen, const ScanJointOptions& options) {
  const auto of = [&](Saw saw) { return std::count(seen.begin(), seen.end(), saw); };
  const auto few = of(Saw::too_few_points), shallow = of(Saw::shallow), one = of(Saw::one_column);
  const auto no_gap = of(Saw::no_gap) + of(Saw::closed);
  if (one > 0 && one >= few && one >= no_gap + shallow)
    return "its points stand in columns along it that are too far apart to tell where a panel ends";
  if (of(Saw::beyond) >= few + no_gap + shallow + one)
    return fmt::format(
        "an edge lies further into it than {:g} mm from where the design has it, and was looked for no further; look "
        "further with 'search'",
        1e3 * options.search);
  if (few > no_gap + shallow) return "fewer than " + std::to_string(kLeastPoints) + " points of a panel lie beside it";
  if (shallow > no_gap)
    return "what lies in it is so little behind the panels that their points' noise hides where they end";
  return "no gap between the panels is wider than those between their own points: it is filled flush, or too narrow "
         "for "
         "the scan";
}

}  // namespace

CutOff cut_off(const std::vector<double>& places) {
  CutOff result;
  double first = 0, second = 0, third = 0;
  for (size_t i = 1; i < places.size(); ++i) {
    const double step = places[i] - places[i - 1];
    first += step, second += step * step, third += step * step * step;
    result.largest = std::max(result.largest, step);
  }
  if (!(first > 0)) return result;
  result.mean = second / (2 * first);
  result.variance = third / (3 * first) - result.mean * result.mean;
  return result;
}

MeasuredJoint measure_scan_joint(const Joint& joint, const std::vector<PanelFace>& faces,
                                 const std::vector<PanelSurface>& surfaces, const std::vector<MeasuredTile>& tiles,
                                 const ScanJointOptions& options) {
  MeasuredJoint measured;
  const auto lines = edge_lines(joint, faces, surfaces);
  for (const EdgeLine& line : lines)
    if (!line.surface || !line.surface->not_measured.empty()) {
      measured.not_measured = "panel " + line.face->id + " is not measured, so that nobody knows which points are its";
      return measured;
    }
  const ScanStations stations(joint, lines, tiles, options);
  std::vector<EdgePair> edges;
  std::vector<Saw> seen;
  for (int s = 0; s < stations.count(); ++s) {
    stop_point();
    ++measured.stations_looked_at;
    EdgePair found;
    seen.push_back(stations.edges(s, found));
    if (seen.back() != Saw::joint) continue;
    JointStation station;
    station.along = stations.along(s), station.width = found.u[1] - found.u[0];
    station.width_random = std::sqrt(found.variance[0] + found.variance[1]);
    station.width_sigma = std::hypot(station.width_random, options.beam / std::sqrt(3.0));
    // The beam makes both panels wider or narrower alike, and leaves the middle between them.
    station.shift_sigma = std::hypot(0.5 * station.width_random, place_sigma(joint, station.along, tiles));
    if (std::isfinite(station.shift_sigma)) station.shift = 0.5 * (found.u[0] + found.u[1]);
    add_step(station, lines[0], lines[1], joint.plane, found.u[0], found.u[1]);
    measured.stations.push_back(station), edges.push_back(found);
  }
  measured.closed = closed_together(seen);
  if (measured.stations.empty()) {
    measured.not_measured = reason_of(seen, options);
    return measured;
  }
  double variance = 0;
  for (const EdgePair& pair : edges) variance = std::max({variance, pair.variance[0], pair.variance[1]});
  constexpr size_t run = 2;  // of places that are off together
  keep_straight(measured, edges, std::max(0.0015, 4 * std::sqrt(variance)), run);
  sum_up(measured, "both panels end");
  if (!measured.not_measured.empty() && std::count(seen.begin(), seen.end(), Saw::joint) < stations.count())
    measured.not_measured += "; elsewhere " + reason_of(seen, options);
  return measured;
}

}  // namespace plumbline::surface

#include "surface/dense/hidden_waves.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/median.hpp"

namespace plumbline::surface {
namespace {

constexpr double kLeast = 16;  ///< points in a cell
constexpr double kSure = 6;    ///< standard deviations of their mean square

struct Spot {
  double u, v, off, variance;  ///< on the face, beside the fitted surface [m], stated [m²]
};

struct CellPoints {
  std::vector<Spot> own;       ///< that count
  std::vector<double> behind;  ///< how far those that do not count lie behind the surface [m]
};

/// Half the mean square of differences of neighbours along strips in one direction, each about as wide as points are
/// apart: of white noise its variance, of a wave that is longer than the points are apart little of it. nan: none.
double successive_variance(std::vector<Spot> places, double Spot::*along, double Spot::*across) {
  constexpr double same = 1e-4;  // a point that stands in the file twice is no neighbour [m]
  const auto strips = static_cast<size_t>(std::lround(std::sqrt(static_cast<double>(places.size()))));
  std::sort(places.begin(), places.end(), [&](const Spot& a, const Spot& b) { return a.*across < b.*across; });
  double squares = 0, count = 0;
  for (size_t strip = 0; strip < strips; ++strip) {
    const auto begin = places.begin() + static_cast<std::ptrdiff_t>(strip * places.size() / strips);
    const auto end = places.begin() + static_cast<std::ptrdiff_t>((strip + 1) * places.size() / strips);
    std::sort(begin, end, [&](const Spot& a, const Spot& b) { return a.*along < b.*along; });
    for (auto it = begin; it + 1 < end; ++it) {
      if (std::hypot(it[1].u - it[0].u, it[1].v - it[0].v) < same) continue;
      squares += std::pow(it[1].off - it[0].off, 2), ++count;
    }
  }
  return count > 0 ? squares / count / 2 : std::numeric_limits<double>::quiet_NaN();
}

double wave_in(const CellPoints& cell, bool independent) {
  const auto count = static_cast<double>(cell.own.size());
  if (count < kLeast) return 0;
  double sum = 0, squares = 0, noise = 0;
  for (const Spot& place : cell.own) sum += place.off, squares += place.off * place.off, noise += place.variance;
  const double found = (squares - sum * sum / count) / (count - 1);
  noise /= count;
  if (independent)  // of so few neighbours the least of two estimates is low
    noise = std::fmin(
        noise, (1 + kSure * std::sqrt(3 / count)) * std::fmin(successive_variance(cell.own, &Spot::u, &Spot::v),
                                                              successive_variance(cell.own, &Spot::v, &Spot::u)));
  return found > noise * (1 + kSure * std::sqrt(2 / count)) ? 2 * std::sqrt(2 * (found - noise)) : 0;
}

double groove_in(const CellPoints& cell) {
  constexpr size_t least = 3;     // points that can agree with each other
  constexpr double share = 0.05;  // of the cell's points: a stray echo is no groove
  if (cell.behind.size() < least) return 0;
  const auto all = static_cast<double>(cell.own.size() + cell.behind.size());
  return static_cast<double>(cell.behind.size()) < share * all ? 0 : upper_median(cell.behind);
}

}  // namespace

double hidden_in_cells(const PanelFace& face, const std::vector<Sample>& samples, const std::vector<char>& counts,
                       const Vector6& form, const PanelOptions& options) {
  const Division division(face, options);
  std::vector<CellPoints> cells(static_cast<size_t>(division.columns) * division.rows);
  for (size_t i = 0; i < samples.size(); ++i) {
    const Sample& s = samples[i];
    const double off = s.h - base_of(face, s).dot(form);
    CellPoints& cell = cells[division.cell_of(s)];
    if (counts[i])
      cell.own.push_back({s.u, s.v, off, s.sigma * s.sigma});
    else if (options.independent && off < 0)
      cell.behind.push_back(-off);
  }
  double hidden = 0;
  for (const CellPoints& cell : cells) hidden = std::max({hidden, wave_in(cell, options.independent), groove_in(cell)});
  return hidden;
}

}  // namespace plumbline::surface

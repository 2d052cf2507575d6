#include "survey/start/set_up_chain.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "plumbline/stop.hpp"
#include "survey/model/observation_equations.hpp"

namespace plumbline::survey {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Gross errors are looked for here, the fine ones by the adjustment: beyond any noise, and never below this.
constexpr double kSigmas = 6, kSmallest = 0.004;

double tolerance(double a, double b) { return kSmallest + kSigmas * std::hypot(a, b); }

/// What one set-up read to one target at one target height.
struct Readings {
  const MeanObservation *direction = nullptr, *zenith = nullptr, *slope = nullptr, *horizontal = nullptr;
  std::vector<int> observations;
  double heights = 0;
  int order = 0;
};

std::optional<LocalSight> local_sight(const std::string& point, const Readings& r, const InstrumentProfile& profile) {
  if (!r.direction || (!r.slope && !r.horizontal)) return std::nullopt;
  LocalSight sight;
  sight.point = point;
  sight.heights = r.heights;
  sight.order = r.order;
  sight.observations = r.observations;
  const double zenith = r.zenith ? r.zenith->observation.value : kNotGiven;
  double h = r.horizontal ? r.horizontal->observation.value : kNotGiven;
  if (r.slope && r.zenith) h = r.slope->observation.value * std::sin(zenith);
  if (std::isnan(h)) return std::nullopt;  // a slope without its zenith angle
  const double sine = r.zenith ? std::sin(zenith) : 1;
  if (!(h > kShortestHorizontal) || !(sine > 1e-3)) return std::nullopt;
  const double s = h / sine, d = r.direction->observation.value;
  const double up = r.zenith ? s * std::cos(zenith) + h * h / (2 * kEarthRadius) : kNotGiven;
  sight.ray = {h * std::sin(d), h * std::cos(d), up};
  const MeanObservation& length = r.slope ? *r.slope : *r.horizontal;
  const auto sigma = [](const MeanObservation& o, double fallback) { return or_else(o.observation.sigma, fallback); };
  sight.sigma = std::max(h * sigma(*r.direction, profile.direction(h, s, r.direction->sets, r.direction->single_face)),
                         sigma(length, profile.distance(s, length.sets)));
  if (r.zenith)
    sight.sigma =
        std::max(sight.sigma, s * sigma(*r.zenith, profile.zenith_angle(s, r.zenith->sets, r.zenith->single_face)));
  return sight;
}

std::vector<SetUpFigure> make_local_figures(const SurveyObservations& survey,
                                            const std::vector<MeanObservation>& observations,
                                            const InstrumentProfile& profile) {
  std::vector<std::map<std::pair<std::string, double>, Readings>> readings(survey.set_ups.size());
  for (int i = 0; i < static_cast<int>(observations.size()); ++i) {
    const MeanObservation& mean = observations[i];
    const Observation& o = mean.observation;
    if (o.set_up < 0 || o.from != survey.set_ups[o.set_up].station || o.to == o.from) continue;
    const double own = survey.set_ups[o.set_up].instrument_height;
    const double heights = or_zero(or_else(o.instrument_height, own)) - or_zero(o.target_height);
    Readings& r = readings[o.set_up][{o.to, heights}];
    if (r.observations.empty()) r.order = mean.members.front();
    r.order = std::min(r.order, mean.members.front());
    r.heights = heights;
    const MeanObservation** slot = o.kind == ObservationKind::direction             ? &r.direction
                                   : o.kind == ObservationKind::zenith_angle        ? &r.zenith
                                   : o.kind == ObservationKind::slope_distance      ? &r.slope
                                   : o.kind == ObservationKind::horizontal_distance ? &r.horizontal
                                                                                    : nullptr;
    if (!slot || *slot) continue;  // a second one of the kind, with a sigma of its own: the first will do
    *slot = &mean;
    r.observations.push_back(i);
  }
  std::vector<SetUpFigure> figures;
  for (size_t s = 0; s < readings.size(); ++s) {
    SetUpFigure figure;
    figure.set_up = static_cast<int>(s);
    LocalSight mark;
    mark.point = survey.set_ups[s].station;
    mark.sigma = profile.instrument_centring + profile.height_centring;
    figure.sights.push_back(mark);
    const InstrumentProfile sights = profile.without_instrument_centring();  // it is the mark's, not the sights'
    for (const auto& [key, r] : readings[s])
      if (auto sight = local_sight(key.first, r, sights)) figure.sights.push_back(std::move(*sight));
    if (figure.sights.size() > 1) figures.push_back(std::move(figure));
  }
  return figures;
}

}  // namespace

SetUpChain::SetUpChain(const SurveyObservations& survey, const std::vector<MeanObservation>& observations,
                       const InstrumentProfile& profile)
    : figures_(make_local_figures(survey, observations, profile)), fits_(figures_.size()) {
  for (size_t f = 0; f < figures_.size(); ++f)
    for (size_t s = 0; s < figures_[f].sights.size(); ++s)
      views_[figures_[f].sights[s].point].emplace_back(static_cast<int>(f), static_cast<int>(s));
  if (figures_.empty()) return;
  grow(choose_root());
  for (int round = 0; round < 2; ++round)
    for (size_t f = 0; f < figures_.size(); ++f) {
      stop_point();
      if (!fits_[f]) continue;
      if (const auto fit = best_fit(pairs_of(f))) fits_[f] = fit;
    }
}

std::optional<SetUpChain::Place> SetUpChain::place_of(const std::string& point, int without) const {
  constexpr size_t kCentres = 48;  // tried for most that agree; all of them where a point has no more views
  struct View {
    Vector3d position;
    double sigma;
    int figure;
  };
  std::vector<View> views;
  const auto at = views_.find(point);
  if (at == views_.end()) return std::nullopt;
  for (const auto& [f, s] : at->second) {
    if (f == without || !fits_[f]) continue;
    const LocalSight& sight = figures_[f].sights[s];
    views.push_back({(*fits_[f])(sight), sight.sigma, f});
  }
  if (views.empty()) return std::nullopt;
  Place best;
  // Views of one figure follow each other: it counts once.
  for (size_t i = 0; i < views.size(); ++i) best.views += i == 0 || views[i].figure != views[i - 1].figure;
  const size_t step = (views.size() + kCentres - 1) / kCentres;
  for (size_t c = 0; c < views.size(); c += step) {
    const View& centre = views[c];
    Vector3d sum = Vector3d::Zero();
    double weights = 0, up_weights = 0;
    int agree = 0, last = -1;
    for (const View& v : views) {
      Vector3d d = v.position - centre.position;
      if (std::isnan(d.z())) d.z() = 0;
      if (d.norm() > tolerance(v.sigma, centre.sigma)) continue;
      const double w = 1 / std::max(1e-12, v.sigma * v.sigma);
      agree += std::exchange(last, v.figure) != v.figure;
      weights += w;
      sum.head<2>() += w * v.position.head<2>();
      if (!std::isnan(v.position.z())) sum.z() += w * v.position.z(), up_weights += w;
    }
    if (agree <= best.agree) continue;
    best.agree = agree;
    best.position << sum.head<2>() / weights, up_weights > 0 ? sum.z() / up_weights : kNotGiven;
    best.sigma = centre.sigma;
    if (10 * best.agree >= 9 * best.views) break;  // no centre has many more, and there may be a hundred views
  }
  return best;
}

std::vector<FigurePair> SetUpChain::pairs_of(size_t figure) const {
  std::vector<FigurePair> pairs;
  for (const LocalSight& sight : figures_[figure].sights)
    if (const auto place = place_of(sight.point, static_cast<int>(figure)))
      pairs.push_back({&sight, place->position, tolerance(sight.sigma, place->sigma)});
  return pairs;
}

std::vector<std::string> SetUpChain::points() const {
  std::vector<std::string> ids;
  for (const auto& [id, views] : views_) ids.push_back(id);
  return ids;
}

std::optional<FigureFit> SetUpChain::best_fit(const std::vector<FigurePair>& pairs) {
  std::optional<FigureFit> best = fit_robustly(pairs, 1);
  if (best && 2 * best->agree > static_cast<int>(pairs.size())) return best;
  // Four points at least, so that two that agree by chance at some scale decide nothing.
  for (const LengthUnit& unit : kLengthUnits)
    for (const double scale : {unit.metres, 1 / unit.metres}) {
      const auto fit = pairs.size() >= 4 ? fit_robustly(pairs, scale) : std::nullopt;
      if (fit && fit->agree >= 3 && (!best || fit->agree > best->agree)) best = fit;
    }
  return best;
}

/// Of the figures with most shared points, the one that most others agree with.
size_t SetUpChain::choose_root() const {
  constexpr size_t kTried = 6;
  std::vector<size_t> shared(figures_.size(), 0), order(figures_.size());
  for (const auto& [point, views] : views_)
    if (views.size() > 1)
      for (const auto& [f, s] : views) ++shared[f];
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return shared[a] > shared[b]; });
  size_t root = order.front();
  int most = -1;
  for (size_t k = 0; k < std::min(kTried, order.size()); ++k) {
    int agree = 0;
    std::map<int, std::vector<FigurePair>> by_figure;  // in the order of this figure's sights
    for (const LocalSight& a : figures_[order[k]].sights)
      for (const auto& [f, s] : views_.at(a.point)) {
        const LocalSight& b = figures_[f].sights[s];
        if (f != static_cast<int>(order[k])) by_figure[f].push_back({&b, a.place(1), tolerance(a.sigma, b.sigma)});
      }
    for (const auto& [other, pairs] : by_figure) {
      stop_point();
      const auto fit = fit_robustly(pairs, 1);
      if (fit && (fit->agree > 2 || pairs.size() == 2)) agree += fit->agree;
    }
    if (agree <= most) continue;
    most = agree;
    root = order[k];
  }
  return root;
}

/// One after another, always the figure that most placed points agree with (of equals the first). No more points can
/// agree than are placed, so that only figures are fitted which may be the next.
void SetUpChain::grow(size_t root) {
  struct Candidate {
    std::optional<FigureFit> fit;
    int placed = 0;  ///< of its points
    bool stale = true;
    bool usable() const { return fit && (fit->agree >= 3 || fit->compared <= 2); }
    /// So many placed points agree, and so few do not, that no other order of placing would put it elsewhere.
    bool certain() const { return fit && fit->scale == 1 && fit->agree >= 12 && 10 * fit->agree >= 9 * fit->compared; }
  };
  std::vector<Candidate> candidates(figures_.size());
  std::map<std::string, std::optional<Place>> places;  // of points that are placed; no candidate has a part in them
  const auto place = [&](size_t f, const FigureFit& fit) {
    fits_[f] = fit;
    for (const LocalSight& sight : figures_[f].sights) {
      const bool is_new = !places.contains(sight.point);
      places[sight.point] = place_of(sight.point);
      for (const auto& [other, s] : views_.at(sight.point)) {
        candidates[other].stale = true;
        candidates[other].placed += is_new;
      }
    }
  };
  const auto evaluate = [&](size_t f) {
    stop_point();
    std::vector<FigurePair> pairs;
    for (const LocalSight& sight : figures_[f].sights)
      if (const auto at = places.find(sight.point); at != places.end() && at->second)
        pairs.push_back({&sight, at->second->position, tolerance(sight.sigma, at->second->sigma)});
    candidates[f].fit = best_fit(pairs);
    candidates[f].stale = false;
  };
  place(root, FigureFit());
  for (;;) {
    stop_point();
    int best = -1;
    // A fit without scale goes before one with, however many agree there.
    const auto before = [&](size_t f, int agree, bool scaled) {
      if (best < 0) return true;
      const FigureFit& least = *candidates[best].fit;
      if (scaled != (least.scale != 1)) return !scaled;
      return agree > least.agree || (agree == least.agree && static_cast<int>(f) < best);
    };
    for (size_t f = 0; f < figures_.size(); ++f)
      if (!fits_[f] && !candidates[f].stale && candidates[f].usable() &&
          before(f, candidates[f].fit->agree, candidates[f].fit->scale != 1))
        best = static_cast<int>(f);
    std::vector<size_t> open;
    for (size_t f = 0; f < figures_.size(); ++f)
      if (!fits_[f] && candidates[f].stale && candidates[f].placed >= 2) open.push_back(f);
    std::stable_sort(open.begin(), open.end(),
                     [&](size_t a, size_t b) { return candidates[a].placed > candidates[b].placed; });
    // With many set-ups over the same points each step would fit all that are left, to find which of them fits best:
    // one that is certain is as good.
    for (const size_t f : open) {
      if (best >= 0 && candidates[best].certain()) break;
      if (!before(f, candidates[f].placed, false)) continue;
      evaluate(f);
      if (candidates[f].usable() && before(f, candidates[f].fit->agree, candidates[f].fit->scale != 1))
        best = static_cast<int>(f);
    }
    if (best < 0) return;
    place(static_cast<size_t>(best), *candidates[best].fit);
  }
}

std::optional<ChainStart> start_from_chain(const SetUpChain& chain, size_t set_ups,
                                           const std::map<std::string, Vector3d>& known) {
  if (chain.figures().empty()) return std::nullopt;
  std::vector<LocalSight> placed;
  std::vector<FigurePair> pairs;
  for (const std::string& id : chain.points())
    if (const auto place = chain.place_of(id)) {
      LocalSight& p = placed.emplace_back();
      p.point = id;
      p.ray = place->position;
    }
  double extent = 0;
  for (const LocalSight& p : placed) extent = std::max(extent, (p.ray - placed.front().ray).head<2>().norm());
  for (const LocalSight& p : placed)
    if (const auto at = known.find(p.point); at != known.end() && !at->second.head<2>().hasNaN())
      pairs.push_back({&p, at->second, 0.05 + 0.005 * extent});
  FigureFit frame;
  if (!known.empty()) {
    const auto fit = fit_robustly(pairs, 1);
    if (!fit || 2 * fit->agree <= fit->compared) return std::nullopt;
    frame = *fit;
  } else {
    size_t largest = 0;
    for (size_t f = 1; f < chain.figures().size(); ++f)
      if (chain.figures()[f].sights.size() > chain.figures()[largest].sights.size()) largest = f;
    if (!chain.placed(largest)) return std::nullopt;
    frame.rotation = -chain.fit(largest).rotation;
    LocalSight origin;
    origin.ray = chain.fit(largest).shift;
    frame.shift = -frame(origin);
  }
  ChainStart start;
  for (const LocalSight& p : placed) start.points[p.point] = frame(p);
  start.orientations.assign(set_ups, kNotGiven);
  for (size_t f = 0; f < chain.figures().size(); ++f)
    if (chain.placed(f))
      start.orientations[chain.figures()[f].set_up] = wrap_angle(chain.fit(f).rotation + frame.rotation);
  return start;
}

}  // namespace plumbline::survey

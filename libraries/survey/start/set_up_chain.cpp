#include "survey/start/set_up_chain.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "survey/model/observation_equations.hpp"

namespace plumbline::survey {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Gross errors are looked for here, the fine ones by the adjustment: beyond any noise, and never below this.
constexpr double kSigmas = 6, kSmallest = 0.004;

double or_zero(double v) { return std::isnan(v) ? 0.0 : v; }
double or_else(double v, double other) { return std::isnan(v) ? other : v; }

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
    const MeanObservation& mean = observations[static_cast<size_t>(i)];
    const Observation& o = mean.observation;
    if (o.set_up < 0 || o.from != survey.set_ups[static_cast<size_t>(o.set_up)].station || o.to == o.from) continue;
    const double own = survey.set_ups[static_cast<size_t>(o.set_up)].instrument_height;
    const double heights = or_zero(or_else(o.instrument_height, own)) - or_zero(o.target_height);
    Readings& r = readings[static_cast<size_t>(o.set_up)][{o.to, heights}];
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
    for (const auto& [key, r] : readings[s])
      if (auto sight = local_sight(key.first, r, profile)) figure.sights.push_back(std::move(*sight));
    if (figure.sights.size() > 1) figures.push_back(std::move(figure));
  }
  return figures;
}

Vector2d turned(const Vector2d& p, double rotation) {
  const double c = std::cos(rotation), s = std::sin(rotation);
  return {p.x() * c + p.y() * s, -p.x() * s + p.y() * c};
}

double azimuth(const Vector2d& d) { return std::atan2(d.x(), d.y()); }

/// Truncated squares over all pairs: a point that does not agree costs 1, however far off it is.
double cost_of(const FigureFit& fit, const std::vector<FigurePair>& pairs, int& agree) {
  double cost = 0;
  agree = 0;
  for (const FigurePair& p : pairs) {
    Vector3d d = fit(*p.sight) - p.target;
    if (std::isnan(d.z())) d.z() = 0;
    const double share = d.squaredNorm() / (p.tolerance * p.tolerance);
    cost += std::min(1.0, share);
    agree += share <= 1;
  }
  return cost;
}

std::optional<FigureFit> fit_of_two(const FigurePair& a, const FigurePair& b, double scale) {
  const Vector3d from = b.sight->place(scale) - a.sight->place(scale), to = b.target - a.target;
  const double allowed = a.tolerance + b.tolerance;
  if (std::abs(from.head<2>().norm() - to.head<2>().norm()) > allowed || to.head<2>().norm() < 2 * allowed)
    return std::nullopt;
  if (std::abs(from.z() - to.z()) > allowed) return std::nullopt;  // NaN passes: a height that is not compared
  FigureFit fit;
  fit.scale = scale;
  fit.rotation = wrap_angle(azimuth(to.head<2>()) - azimuth(from.head<2>()));
  const Vector3d first = a.target - fit(*a.sight), second = b.target - fit(*b.sight);
  fit.shift = 0.5 * (first + second);
  if (std::isnan(fit.shift.z())) fit.shift.z() = or_else(first.z(), or_else(second.z(), 0));
  return fit;
}

/// Least squares over the pairs that agree.
void refine(const std::vector<FigurePair>& pairs, FigureFit& fit) {
  Vector3d from = Vector3d::Zero(), to = Vector3d::Zero();
  double weights = 0, lift = 0, lift_weights = 0;
  std::vector<const FigurePair*> used;
  for (const FigurePair& p : pairs) {
    if (!agrees(fit, p)) continue;
    const double w = 1 / (p.tolerance * p.tolerance);
    const Vector3d local = p.sight->place(fit.scale, fit.constant);
    used.push_back(&p);
    weights += w;
    from.head<2>() += w * local.head<2>();
    to.head<2>() += w * p.target.head<2>();
    if (const double up = p.target.z() - local.z(); !std::isnan(up)) lift += w * up, lift_weights += w;
  }
  if (used.size() < 2) return;
  from /= weights, to /= weights;
  double sine = 0, cosine = 0;
  for (const FigurePair* p : used) {
    const double w = 1 / (p->tolerance * p->tolerance);
    const Vector2d a = p->sight->place(fit.scale, fit.constant).head<2>() - from.head<2>(),
                   b = p->target.head<2>() - to.head<2>();
    cosine += w * a.dot(b);
    sine += w * (b.x() * a.y() - b.y() * a.x());
  }
  fit.rotation = std::atan2(sine, cosine);
  fit.shift.head<2>() = to.head<2>() - turned(from.head<2>(), fit.rotation);
  if (lift_weights > 0) fit.shift.z() = lift / lift_weights;
}

}  // namespace

Vector3d FigureFit::operator()(const LocalSight& sight) const {
  const Vector3d local = sight.place(scale, constant);
  const Vector2d plan = turned(local.head<2>(), rotation);
  return Vector3d(plan.x(), plan.y(), local.z()) + shift;
}

bool agrees(const FigureFit& fit, const FigurePair& pair) {
  Vector3d d = fit(*pair.sight) - pair.target;
  if (std::isnan(d.z())) d.z() = 0;
  return d.norm() <= pair.tolerance;
}

std::optional<FigureFit> fit_robustly(const std::vector<FigurePair>& pairs, double scale) {
  constexpr size_t kHypotheses = 400;
  const size_t n = pairs.size();
  if (n < 2) return std::nullopt;
  std::optional<FigureFit> best;
  double least = static_cast<double>(n);
  const size_t all = n * (n - 1) / 2, step = std::max<size_t>(1, all / kHypotheses);
  // Neighbours in the list come last: long baselines turn least with the noise of their ends.
  size_t count = 0;
  for (size_t apart = n - 1; apart >= 1; --apart)
    for (size_t a = 0; a + apart < n; ++a, ++count) {
      if (count % step != 0) continue;
      auto fit = fit_of_two(pairs[a], pairs[a + apart], scale);
      if (!fit) continue;
      double cost = cost_of(*fit, pairs, fit->agree);
      if (cost >= least) continue;
      least = cost;
      best = fit;
    }
  if (!best) return std::nullopt;
  for (int round = 0; round < 3; ++round) {
    FigureFit better = *best;
    refine(pairs, better);
    const double cost = cost_of(better, pairs, better.agree);
    if (cost >= least) break;
    least = cost;
    best = better;
  }
  best->compared = static_cast<int>(n);
  return best;
}

FigureFit with_constant(const std::vector<FigurePair>& pairs, const FigureFit& fit) {
  constexpr double kLargest = 0.1, kStep = 0.0025;
  int agree = 0;
  double least = cost_of(fit, pairs, agree);
  FigureFit best = fit;
  // Outwards from none, each from the fit of its neighbour, so that the points that agree can follow.
  for (const double direction : {1.0, -1.0}) {
    FigureFit trial = fit;
    for (double constant = kStep; constant <= kLargest; constant += kStep) {
      trial.constant = direction * constant;
      for (int round = 0; round < 3; ++round) refine(pairs, trial);
      const double cost = cost_of(trial, pairs, trial.agree);
      if (cost >= least) continue;
      least = cost;
      best = trial;
    }
  }
  // It must explain nearly all that did not agree before.
  return pairs.size() - static_cast<size_t>(best.agree) <= (pairs.size() - static_cast<size_t>(agree)) / 4 ? best : fit;
}

SetUpChain::SetUpChain(const SurveyObservations& survey, const std::vector<MeanObservation>& observations,
                       const InstrumentProfile& profile)
    : figures_(make_local_figures(survey, observations, profile)), fits_(figures_.size()) {
  for (size_t f = 0; f < figures_.size(); ++f)
    for (size_t s = 0; s < figures_[f].sights.size(); ++s)
      views_[figures_[f].sights[s].point].emplace_back(static_cast<int>(f), static_cast<int>(s));
  if (figures_.empty()) return;
  grow(choose_root());
  for (int round = 0; round < 2; ++round)
    for (size_t f = 0; f < figures_.size(); ++f)
      if (fits_[f])
        if (const auto fit = best_fit(f)) fits_[f] = fit;
}

std::optional<SetUpChain::Place> SetUpChain::place_of(const std::string& point, int without) const {
  struct View {
    Vector3d position;
    double sigma;
    int figure;
  };
  std::vector<View> views;
  const auto at = views_.find(point);
  if (at == views_.end()) return std::nullopt;
  for (const auto& [f, s] : at->second) {
    if (f == without || !fits_[static_cast<size_t>(f)]) continue;
    const LocalSight& sight = figures_[static_cast<size_t>(f)].sights[static_cast<size_t>(s)];
    views.push_back({(*fits_[static_cast<size_t>(f)])(sight), sight.sigma, f});
  }
  if (views.empty()) return std::nullopt;
  Place best;
  std::set<int> all;
  for (const View& v : views) all.insert(v.figure);
  best.views = static_cast<int>(all.size());
  for (const View& centre : views) {
    Vector3d sum = Vector3d::Zero();
    double weights = 0, up_weights = 0;
    std::set<int> figures;
    for (const View& v : views) {
      Vector3d d = v.position - centre.position;
      if (std::isnan(d.z())) d.z() = 0;
      if (d.norm() > tolerance(v.sigma, centre.sigma)) continue;
      const double w = 1 / std::max(1e-12, v.sigma * v.sigma);
      figures.insert(v.figure);
      weights += w;
      sum.head<2>() += w * v.position.head<2>();
      if (!std::isnan(v.position.z())) sum.z() += w * v.position.z(), up_weights += w;
    }
    if (static_cast<int>(figures.size()) <= best.agree) continue;
    best.agree = static_cast<int>(figures.size());
    best.position << sum.head<2>() / weights, up_weights > 0 ? sum.z() / up_weights : kNotGiven;
    best.sigma = centre.sigma;
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

std::optional<FigureFit> SetUpChain::best_fit(size_t figure) const {
  const std::vector<FigurePair> pairs = pairs_of(figure);
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
      for (const auto& [f, s] : views) ++shared[static_cast<size_t>(f)];
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return shared[a] > shared[b]; });
  size_t root = order.front();
  int most = -1;
  for (size_t k = 0; k < std::min(kTried, order.size()); ++k) {
    int agree = 0;
    for (size_t other = 0; other < figures_.size(); ++other) {
      if (other == order[k]) continue;
      std::vector<FigurePair> pairs;
      for (const LocalSight& a : figures_[order[k]].sights)
        for (const LocalSight& b : figures_[other].sights)
          if (a.point == b.point) pairs.push_back({&b, a.place(1), tolerance(a.sigma, b.sigma)});
      const auto fit = fit_robustly(pairs, 1);
      if (fit && (fit->agree > 2 || pairs.size() == 2)) agree += fit->agree;
    }
    if (agree <= most) continue;
    most = agree;
    root = order[k];
  }
  return root;
}

/// One after another, always the figure that most placed points agree with.
void SetUpChain::grow(size_t root) {
  fits_[root] = FigureFit();
  std::vector<std::optional<FigureFit>> offered(figures_.size());
  std::vector<char> stale(figures_.size(), 1);
  for (;;) {
    int best = -1;
    for (size_t f = 0; f < figures_.size(); ++f) {
      if (fits_[f]) continue;
      if (stale[f]) offered[f] = best_fit(f);
      stale[f] = 0;
      if (!offered[f] || (offered[f]->agree < 3 && offered[f]->compared > 2)) continue;
      const auto better = [&](const FigureFit& a, const FigureFit& b) {
        return (a.scale == 1) != (b.scale == 1) ? a.scale == 1 : a.agree > b.agree;
      };
      if (best < 0 || better(*offered[f], *offered[static_cast<size_t>(best)])) best = static_cast<int>(f);
    }
    if (best < 0) return;
    fits_[static_cast<size_t>(best)] = offered[static_cast<size_t>(best)];
    for (const LocalSight& sight : figures_[static_cast<size_t>(best)].sights)
      for (const auto& [f, s] : views_.at(sight.point)) stale[static_cast<size_t>(f)] = 1;
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
      start.orientations[static_cast<size_t>(chain.figures()[f].set_up)] =
          wrap_angle(chain.fit(f).rotation + frame.rotation);
  return start;
}

}  // namespace plumbline::survey

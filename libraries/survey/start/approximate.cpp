// Two levels. A Frame places as much as it can from the points it knows. Where it is stuck, a figure that is not placed
// yet starts a Frame of its own, which grows without any known point and is then fitted onto the first one by the
// points both have. Networks of angles, where no figure has distances, grow from one side of assumed length, networks
// of distances from one of them. The whole is repeated for other choices between places that fit equally well.
#include "survey/start/approximate.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include "plumbline/stop.hpp"
#include "survey/start/approximate_figure.hpp"
#include "survey/start/approximate_frame.hpp"

namespace plumbline::survey {

namespace {

/// The figure with the most complete sights to points that are not placed; -1 if none has any.
int best_seed(const Figures& figures, const Frame& frame, const std::vector<char>& tried) {
  int best = -1;
  size_t most = 0;
  for (size_t f = 0; f < figures.figures.size(); ++f) {
    if (tried[f]) continue;
    size_t count = 0, open = frame.has_plan(figures.figures[f].station) ? 0 : 1;
    for (const PolarSight& s : figures.figures[f].sights) {
      if (std::isnan(s.direction) || (std::isnan(s.horizontal) && std::isnan(s.slope))) continue;
      ++count;
      if (!frame.has_plan(s.to)) ++open;
    }
    if (open == 0 || count <= most) continue;
    most = count;
    best = static_cast<int>(f);
  }
  return best;
}

/// Figures with distances, each grown as far as it goes, one after another fitted onto the frame.
void chain_figures(const SurveyObservations& survey, const Figures& figures, Choices& choices, bool guess,
                   bool unrelated, Frame& frame) {
  std::vector<char> tried(figures.figures.size(), 0);
  for (int f = best_seed(figures, frame, tried); f >= 0; f = best_seed(figures, frame, tried)) {
    tried[f] = 1;
    Frame local(survey, figures, choices, figures.figures[f].station + "/" + std::to_string(f) + ":");
    local.seed(static_cast<size_t>(f));
    local.grow(guess);
    local.settle_north();
    if (frame.adopt(local, guess) || (unrelated && frame.adopt_unrelated(local))) {
      frame.grow(guess);
      std::fill(tried.begin(), tried.end(), 0);
      tried[f] = 1;
    }
  }
}

/// Triangulation: what directions place between two points without a length.
void chain_triangles(const SurveyObservations& survey, const Figures& figures, Choices& choices, bool guess,
                     Frame& frame) {
  std::set<std::string> seen;
  for (size_t f = 0; f < figures.figures.size(); ++f)
    for (const PolarSight& s : figures.figures[f].sights) {
      const std::string& station = figures.figures[f].station;
      if (std::isnan(s.direction) || frame.has_plan(station) || seen.contains(station)) continue;
      Frame local(survey, figures, choices, station + "/" + std::to_string(f) + "/" + s.to + ":");
      local.seed_shape(f, s.to);
      local.grow(guess);
      if (local.plan().size() < 3) continue;  // not a triangle
      for (const auto& [id, p] : local.plan()) seen.insert(id);
      if (!local.settle_scale(frame) && !guess) continue;
      local.grow(guess);
      local.settle_north();
      if (frame.adopt(local, guess)) frame.grow(guess);
    }
}

/// Vectors between points that nothing else has placed.
void chain_vectors(const SurveyObservations& survey, const Figures& figures, Choices& choices, bool guess,
                   Frame& frame) {
  std::set<std::string> seen;
  for (const VectorGroup& group : survey.vectors)
    for (const auto& v : group.vectors) {
      if ((frame.has_plan(v.from) && frame.has_plan(v.to)) || seen.contains(v.from)) continue;
      Frame local(survey, figures, choices, v.from + ">");
      local.seed_vector(v.from);
      local.grow(guess);
      for (const auto& [id, p] : local.plan()) seen.insert(id);
      if (frame.adopt(local, guess)) frame.grow(guess);
    }
}

/// Trilateration without enough known points: from a triangle of distances, in the plane as a distance whose ends see
/// most third points, in space (if the main frame is empty) as a level triangle.
void chain_distances(const SurveyObservations& survey, const Figures& figures, Choices& choices, Frame& frame) {
  std::map<std::string, std::set<std::string>> joined;
  bool slopes = false;
  const auto join = [&](const std::string& a, const std::string& b, double horizontal, double slope) {
    if ((std::isnan(horizontal) && std::isnan(slope)) || (frame.has_plan(a) && frame.has_plan(b))) return;
    slopes |= std::isnan(horizontal) && !frame.heightless(a) && !frame.heightless(b);
    joined[a].insert(b);
    joined[b].insert(a);
  };
  for (const DistanceLine& d : figures.distances) join(d.from, d.to, d.horizontal, d.slope);
  for (const Figure& f : figures.figures)
    for (const PolarSight& s : f.sights) join(f.station, s.to, s.horizontal, s.slope);
  if (slopes && !frame.plan().empty()) return;
  size_t most = 0;
  std::string first, second, third;
  for (const auto& [a, others] : joined)
    for (const std::string& b : others) {
      if (b < a) continue;
      std::vector<std::string> common;
      std::set_intersection(others.begin(), others.end(), joined.at(b).begin(), joined.at(b).end(),
                            std::back_inserter(common));
      if (common.size() <= most) continue;
      most = common.size();
      first = a;
      second = b;
      third = slopes ? common.front() : "";
    }
  if (most == 0) return;
  Frame local(survey, figures, choices, first + "-" + second + ":");
  if (!local.seed_distance(first, second, third)) return;
  local.grow(true);
  local.settle_north();
  if (frame.adopt(local, true)) frame.grow(true);
}

/// Heights of networks that have nothing but height differences.
void seed_height(const Figures& figures, Frame& frame) {
  if (!frame.height().empty()) return;
  if (!figures.height_differences.empty()) {
    frame.set_height(figures.height_differences.front().from, 0);
  } else {
    for (const Figure& f : figures.figures)
      if (!f.sights.empty()) {
        frame.set_height(f.station, 0);
        break;
      }
  }
  frame.grow(true);
}

/// Everything that is known of the network before a search starts.
struct Search {
  const SurveyObservations& survey;
  const Figures figures;
  const std::map<std::string, Eigen::Vector3d>& points;
  bool unrelated = false;
};

/// One search, with the choices it met.
struct Hypothesis {
  Choices choices;
  Approximation approximation;
  size_t placed = 0;
  double misfit = 0;

  bool better_than(const Hypothesis& other) const {
    return placed != other.placed ? placed > other.placed : misfit < other.misfit;
  }
  bool equals(const Hypothesis& other) const {
    if (approximation.points.size() != other.approximation.points.size()) return false;
    for (const auto& [id, p] : approximation.points) {
      const auto at = other.approximation.points.find(id);
      if (at == other.approximation.points.end()) return false;
      for (int k = 0; k < 3; ++k)
        if (std::isnan(p[k]) != std::isnan(at->second[k]) || std::abs(p[k] - at->second[k]) > 1e-6) return false;
    }
    return true;
  }
};

void place_known(const Search& search, Frame& frame) {
  for (const auto& [id, p] : search.points) {
    if (!p.head<2>().hasNaN()) frame.set_plan(id, p.head<2>());
    if (!std::isnan(p.z())) frame.set_height(id, p.z());
  }
  for (const CoordinateGroup& group : search.survey.coordinates)
    for (size_t k = 0; k + 1 < group.components.size(); ++k) {
      const auto& c = group.components[k];
      const auto at = static_cast<Eigen::Index>(k);
      if (c.axis == 0 && group.components[k + 1].point == c.point && group.components[k + 1].axis == 1)
        frame.set_plan(c.point, group.values.segment<2>(at));
    }
  for (const CoordinateGroup& group : search.survey.coordinates)
    for (size_t k = 0; k < group.components.size(); ++k)
      if (group.components[k].axis == 2)
        frame.set_height(group.components[k].point, group.values[static_cast<Eigen::Index>(k)]);
}

Hypothesis try_choices(const Search& search, Choices choices) {
  Hypothesis result{std::move(choices), {}};
  Frame frame(search.survey, search.figures, result.choices, "");
  place_known(search, frame);
  for (const bool guess : {false, true}) {
    frame.grow(guess);
    chain_figures(search.survey, search.figures, result.choices, guess, false, frame);
    chain_triangles(search.survey, search.figures, result.choices, guess, frame);
    chain_vectors(search.survey, search.figures, result.choices, guess, frame);
  }
  chain_distances(search.survey, search.figures, result.choices, frame);
  if (search.unrelated) chain_figures(search.survey, search.figures, result.choices, true, true, frame);
  seed_height(search.figures, frame);

  std::map<std::string, Eigen::Vector3d>& points = result.approximation.points;
  points = search.points;
  for (const auto& [id, p] : frame.plan()) {
    auto& q = points.try_emplace(id, Eigen::Vector3d::Constant(kNotGiven)).first->second;
    if (std::isnan(q.x())) q.head<2>() = p;
  }
  for (const auto& [id, h] : frame.height()) {
    auto& q = points.try_emplace(id, Eigen::Vector3d::Constant(kNotGiven)).first->second;
    if (std::isnan(q.z())) q.z() = h;
  }
  for (size_t i = 0; i < search.survey.set_ups.size(); ++i)
    result.approximation.orientations.push_back(frame.orientation(i));
  result.placed = frame.plan().size() + frame.height().size();
  result.misfit = frame.misfit();
  return result;
}

/// Points that only one other point is tied to, such as the details of a topographic job: they place nothing else, so
/// they wait until the rest is found. Not points with a known coordinate, nor those that give a north or a vector.
std::set<std::string> hanging_points(const Search& search) {
  std::map<std::string, std::set<std::string>> tied;
  std::set<std::string> kept;
  const auto tie = [&](const std::string& a, const std::string& b) {
    tied[a].insert(b);
    tied[b].insert(a);
  };
  for (const Figure& f : search.figures.figures)
    for (const PolarSight& s : f.sights) {
      tie(f.station, s.to);
      kept.insert(f.station);
      if (f.oriented_to_north) kept.insert(s.to);
    }
  for (const DistanceLine& d : search.figures.distances) tie(d.from, d.to);
  for (const HeightDifference& d : search.figures.height_differences) tie(d.from, d.to);
  for (const auto& [id, p] : search.points)
    if (!p.array().isNaN().all()) kept.insert(id);
  for (const CoordinateGroup& group : search.survey.coordinates)
    for (const auto& c : group.components) kept.insert(c.point);
  for (const VectorGroup& group : search.survey.vectors)
    for (const auto& v : group.vectors) kept.insert({v.from, v.to});
  std::set<std::string> hanging;
  for (const auto& [id, others] : tied)
    if (others.size() == 1 && !kept.contains(id)) hanging.insert(id);
  return hanging;
}

Figures without(Figures figures, const std::set<std::string>& points) {
  for (Figure& f : figures.figures) std::erase_if(f.sights, [&](const PolarSight& s) { return points.contains(s.to); });
  const auto concerned = [&](const auto& line) { return points.contains(line.from) || points.contains(line.to); };
  std::erase_if(figures.distances, concerned);
  std::erase_if(figures.height_differences, concerned);
  return figures;
}

/// All coordinates that fit, the best first.
std::vector<Approximation> follow_choices(const Search& search) {
  constexpr size_t kFollowed = 16, kReturned = 8, kMostSearches = 300;
  constexpr size_t kMostIterated = 200;  // points iterated from all around, which is dear
  std::vector<Hypothesis> followed = {try_choices(search, Choices())};
  size_t searches = 1;
  bool open = true;
  for (size_t level = 0; open && searches < kMostSearches && search.figures.places_found->size() < kMostIterated;
       ++level) {
    open = false;
    for (size_t h = 0, n = followed.size(); h < n; ++h) {
      stop_point();
      if (followed[h].choices.met().size() <= level) continue;
      open = true;
      for (int place = 1; place < followed[h].choices.met()[level].places; ++place, ++searches) {
        Hypothesis other = try_choices(search, Choices(followed[h].choices.decide(level, place)));
        const auto same = [&](const Hypothesis& known) { return known.equals(other); };
        if (std::none_of(followed.begin(), followed.end(), same)) followed.push_back(std::move(other));
      }
    }
    std::stable_sort(followed.begin(), followed.end(),
                     [](const Hypothesis& a, const Hypothesis& b) { return a.better_than(b); });
    if (followed.size() > kFollowed) followed.resize(kFollowed);
  }
  std::vector<Approximation> result;
  for (const Hypothesis& h : followed)
    if (h.placed == followed.front().placed && result.size() < kReturned) result.push_back(h.approximation);
  return result;
}

}  // namespace

std::vector<Approximation> approximate_coordinates(const SurveyObservations& survey,
                                                   const std::vector<MeanObservation>& observations,
                                                   const std::map<std::string, Eigen::Vector3d>& points,
                                                   bool unrelated) {
  constexpr size_t kMany = 32;  // fewer cost little
  const Search search{survey, make_figures(survey, observations), points, unrelated};
  const std::set<std::string> hanging = hanging_points(search);
  const Search rest{survey, without(search.figures, hanging), points, unrelated};
  const bool nothing = std::all_of(rest.figures.figures.begin(), rest.figures.figures.end(),
                                   [](const Figure& f) { return f.sights.empty(); });
  if (hanging.size() < kMany || nothing) return follow_choices(search);
  std::vector<Approximation> result = follow_choices(rest);
  for (Approximation& a : result) {
    const std::map<std::string, Eigen::Vector3d> placed = std::move(a.points);
    a = try_choices({survey, search.figures, placed, unrelated}, Choices()).approximation;
  }
  return result;
}

}  // namespace plumbline::survey

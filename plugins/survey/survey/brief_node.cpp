#include "brief_node.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

namespace plumbline::survey {

namespace {

/// Numbers of the observations that are kept, ascending.
std::vector<std::size_t> kept_observations(const SurveyNetworkT& network, std::size_t most) {
  const auto& all = network.observations;
  std::set<int> acted_on;
  for (const auto& step : network.snooping) acted_on.insert(step->observation);
  const auto is_told = [&](std::size_t i) {
    return all[i]->flagged || all[i]->removed || acted_on.contains(static_cast<int>(i));
  };
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto rank = [&](std::size_t i) {
    return is_told(i) ? 3 : all[i]->control == "uncontrolled" ? 2 : std::isfinite(all[i]->w) ? 1 : 0;
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return rank(a) != rank(b) ? rank(a) > rank(b) : rank(a) == 1 && std::abs(all[a]->w) > std::abs(all[b]->w);
  });
  const auto told = static_cast<std::size_t>(std::count_if(order.begin(), order.end(), is_told));
  order.resize(std::min(all.size(), std::max(most, told)));
  std::sort(order.begin(), order.end());
  return order;
}

/// Points of which something is to be said, those of the datum, and the weakest.
void keep_points(SurveyNetworkT& network) {
  constexpr std::size_t kMost = 500;
  auto& all = network.points;
  if (all.size() <= kMost) return;
  std::set<std::string> told(network.datum_points.begin(), network.datum_points.end());
  for (const auto& f : network.findings) told.insert(f->points.begin(), f->points.end());
  for (const auto& k : network.known_points) told.insert(k->id);
  for (const auto& o : network.observations)
    if (o->flagged || o->removed) told.insert({o->from, o->to});
  if (told.size() > kMost) told.clear();  // of so many the worst
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto weight = [&](std::size_t i) {
    const double sigma = all[i]->sigma.array().isFinite().select(all[i]->sigma.array(), 0.0).matrix().norm();
    return std::pair(told.contains(all[i]->id), sigma);
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return weight(a) > weight(b); });
  order.resize(kMost);
  std::sort(order.begin(), order.end());
  std::vector<std::unique_ptr<PointT>> kept;
  for (const std::size_t i : order) kept.push_back(std::move(all[i]));
  all = std::move(kept);
}

}  // namespace

void make_brief(SurveyNetworkT& network, std::size_t most) {
  network.covariances.clear();
  if (network.observations.size() <= most) return;
  const std::vector<std::size_t> kept = kept_observations(network, most);
  std::vector<int> number(network.observations.size(), -1);
  std::vector<std::unique_ptr<NetworkObservationT>> observations;
  for (const std::size_t i : kept) {
    number[i] = static_cast<int>(observations.size());
    observations.push_back(std::move(network.observations[i]));
  }
  const std::size_t points = network.points.size();
  const std::size_t rows = network.observations.size();
  for (auto& step : network.snooping) {
    const bool is_one = step->observation >= 0 && static_cast<std::size_t>(step->observation) < number.size();
    step->observation = is_one ? number[step->observation] : -1;
  }
  network.observations = std::move(observations);
  keep_points(network);
  auto note = std::make_unique<NetworkFindingT>();
  note->severity = "note";
  note->text = "of " + std::to_string(rows) + " observations this file has " + std::to_string(kept.size()) +
               (network.points.size() < points
                    ? ", of " + std::to_string(points) + " points " + std::to_string(network.points.size())
                    : "") +
               ": those that something is to be said of, the most suspect and the weakest; all are in "
               "observations.csv and coordinates.csv, ellipses and covariances in coordinates.csv, points.json and "
               "relative.csv";
  network.findings.push_back(std::move(note));
  network.ellipsoids.clear();
  std::erase_if(network.pointings, [](const auto& p) { return !p->flagged; });
}

void BriefNode::run(Context&) {
  SurveyNetworkT brief = network.unpack();
  make_brief(brief, static_cast<std::size_t>(*most));
  result.commit(brief);
}

}  // namespace plumbline::survey

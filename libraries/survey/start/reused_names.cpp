#include "survey/start/reused_names.hpp"

#include <optional>

#include "survey/start/set_up_chain.hpp"

namespace plumbline::survey {

std::map<std::string, Eigen::Vector3d> seen_places(const SurveyObservations& survey) {
  std::map<std::string, Eigen::Vector3d> places;
  if (survey.set_ups.empty()) return places;
  const SetUpChain chain(survey, mean_observations(survey).observations, {});
  for (const std::string& id : chain.points())
    if (const auto place = chain.place_of(id)) places[id] = place->position;
  return places;
}

std::vector<std::string> reused_names(const std::map<std::string, Eigen::Vector3d>& a,
                                      const std::map<std::string, Eigen::Vector3d>& b) {
  constexpr size_t kFewest = 4;
  constexpr double kSamePlace =
      0.1;  // [m]: a mark is sighted again to centimetres, and a facade's marks lie further apart
  std::vector<LocalSight> sights;
  std::vector<Eigen::Vector3d> targets;
  for (const auto& [id, p] : b) {
    const auto other = a.find(id);
    if (other == a.end()) continue;
    LocalSight& sight = sights.emplace_back();
    sight.point = id, sight.ray = p;
    targets.push_back(other->second);
  }
  if (sights.size() < kFewest) return {};
  std::vector<FigurePair> pairs;
  for (size_t i = 0; i < sights.size(); ++i) pairs.push_back({&sights[i], targets[i], kSamePlace});
  std::optional<FigureFit> best = fit_robustly(pairs, 1);
  for (const LengthUnit& unit : kLengthUnits)
    for (const double scale : {unit.metres, 1 / unit.metres})
      if (const auto fit = fit_robustly(pairs, scale); fit && (!best || fit->agree > best->agree)) best = fit;
  const int agree = best ? best->agree : 0;
  if (2 * static_cast<size_t>(agree) >= sights.size()) return {};
  std::vector<std::string> reused;
  for (const FigurePair& pair : pairs)
    if (agree < 3 || !agrees(*best, pair)) reused.push_back(pair.sight->point);
  return reused;
}

}  // namespace plumbline::survey

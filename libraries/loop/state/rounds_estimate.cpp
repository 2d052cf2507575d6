#include "loop/state/rounds_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "geometry/packed_symmetric.hpp"
#include "loop/state/hash.hpp"

namespace plumbline::loop {
namespace {

AnchorPlaces places_of(const AnchorEstimateT& estimate) {
  AnchorPlaces places;
  places.ids = estimate.ids, places.campaigns = estimate.campaigns;
  places.floors.assign(estimate.floors.begin(), estimate.floors.end());
  const std::size_t n = places.size();
  if (estimate.places.size() != 3 * n || places.floors.size() != n || places.campaigns.size() != n)
    throw std::runtime_error("the state's estimate of the anchors has " + std::to_string(n) + " names and " +
                             std::to_string(estimate.places.size()) + " coordinates; it is torn");
  places.places = Eigen::Map<const Eigen::VectorXd>(estimate.places.data(), static_cast<Eigen::Index>(3 * n));
  places.own = unpack_symmetric(estimate.own, 3 * n, "the state's estimate of the anchors");
  return places;
}

std::unique_ptr<AnchorEstimateT> artifact_of(const AnchorPlaces& places) {
  auto out = std::make_unique<AnchorEstimateT>();
  out->ids = places.ids, out->campaigns = places.campaigns;
  out->floors.assign(places.floors.begin(), places.floors.end());
  out->places.assign(places.places.begin(), places.places.end());
  out->own = pack_symmetric(places.own);
  return out;
}

/// The measured anchors of this campaign.
AnchorPlaces campaign_of(const Facade& facade, const std::vector<std::size_t>& measured) {
  AnchorPlaces places;
  std::vector<Eigen::Index> rows;
  places.places.resize(static_cast<Eigen::Index>(3 * measured.size()));
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const Bracket& bracket = facade.brackets[measured[i]];
    places.ids.push_back(bracket.id), places.floors.push_back(bracket.floor);
    places.campaigns.push_back(bracket.basis + " ");
    places.places.segment<3>(static_cast<Eigen::Index>(3 * i)) = bracket.design + bracket.deviation;
    for (Eigen::Index k = 0; k < 3; ++k) rows.push_back(static_cast<Eigen::Index>(3 * measured[i]) + k);
  }
  places.own = facade.own(rows, rows);
  return places;
}

std::set<std::string> worked_on(const LoopStateT* state) {
  std::set<std::string> ids;
  if (!state) return ids;
  for (const auto& item : state->items)
    if (item->kind == "bracket" && (item->status == ItemStatus::executed || !item->expected.allFinite()))
      ids.insert(item->id);
  return ids;
}

/// Of the difference of its place to that of any campaign before: each has its own errors, and storeys drift between
/// them.
Eigen::Vector3d difference_sigma(const Eigen::Matrix3d& own, int campaigns, int floor, double drift_per_storey) {
  Eigen::Vector3d variance = 2 * own.diagonal().cwiseMax(0);
  const double drift = drift_per_storey * std::max(1, floor);
  variance.z() += std::max(1, campaigns) * drift * drift;
  return variance.cwiseSqrt();
}

int count_of(const std::string& campaigns) {
  return static_cast<int>(std::count(campaigns.begin(), campaigns.end(), ' '));
}

void put_into(Facade& facade, const std::vector<std::size_t>& measured, const AnchorPlaces& estimate,
              double drift_per_storey) {
  std::map<std::string, Eigen::Index> at;
  for (std::size_t i = 0; i < estimate.size(); ++i) at[estimate.ids[i]] = static_cast<Eigen::Index>(i);
  const Eigen::MatrixXd of_campaign = facade.own;
  for (const std::size_t b : measured) {
    Bracket& bracket = facade.brackets[b];
    const Eigen::Index i = at.at(bracket.id), to = 3 * static_cast<Eigen::Index>(b);
    bracket.deviation = estimate.places.segment<3>(3 * i) - bracket.design;
    bracket.campaigns = count_of(estimate.campaigns[i]);
    bracket.difference_sigma =
        difference_sigma(of_campaign.block<3, 3>(to, to), bracket.campaigns, bracket.floor, drift_per_storey);
    for (const std::size_t other : measured) {
      const Eigen::Index j = at.at(facade.brackets[other].id), across = 3 * static_cast<Eigen::Index>(other);
      const Eigen::Matrix3d own = estimate.own.block<3, 3>(3 * i, 3 * j);
      facade.covariance.block<3, 3>(to, across) += own - of_campaign.block<3, 3>(to, across);
      facade.own.block<3, 3>(to, across) = own;
    }
  }
}

/// Whether the estimate has each of its anchors by this campaign.
bool is_known(const AnchorPlaces& campaign, const AnchorPlaces& before) {
  std::map<std::string, const std::string*> known;
  for (std::size_t i = 0; i < before.size(); ++i) known[before.ids[i]] = &before.campaigns[i];
  for (std::size_t i = 0; i < campaign.size(); ++i) {
    const auto found = known.find(campaign.ids[i]);
    if (found == known.end() || found->second->find(campaign.campaigns[i]) == std::string::npos) return false;
  }
  return true;
}

/// What was not measured since keeps the hash of the measurement before.
void keep_bases(Facade& facade, const LoopStateT& state, const std::set<std::string>& repeated) {
  std::map<std::string, const LoopItemT*> items;
  for (const auto& item : state.items)
    if (item->kind == "bracket") items[item->id] = item.get();
  for (Bracket& bracket : facade.brackets)
    if (const auto item = items.find(bracket.id);
        item != items.end() && bracket.measured() && repeated.count(bracket.id) > 0 && !item->second->basis.empty())
      bracket.basis = item->second->basis;
}

}  // namespace

std::string basis_of_bracket(const Facade& facade, std::size_t index) {
  const Bracket& bracket = facade.brackets[index];
  if (!bracket.measured()) return {};
  const Eigen::Vector3d measured = bracket.design + bracket.deviation;
  std::vector<double> numbers(measured.begin(), measured.end());
  const auto at = 3 * static_cast<Eigen::Index>(index);
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) numbers.push_back(1e4 * facade.covariance(at + i, at + j));
  return sha256_hex(numbers, 1e-6).substr(0, 16);
}

namespace {

RoundsEstimate combined_rounds(Facade& facade, const LoopStateT* state, const CombineOptions& options, std::size_t most,
                               bool repeats) {
  RoundsEstimate out;
  std::vector<std::size_t> measured;
  for (std::size_t b = 0; b < facade.brackets.size(); ++b)
    if (facade.brackets[b].measured()) measured.push_back(b);
  if (facade.own.size() == 0 || measured.empty()) return out;
  if (measured.size() > most) {
    out.words.push_back(std::to_string(measured.size()) + " anchors were measured: campaigns are combined up to " +
                        std::to_string(most) + ", here the last one counts alone");
    facade.own.resize(0, 0);
    return out;
  }
  AnchorPlaces before;
  before.own.resize(0, 0);
  if (state && state->estimate) before = places_of(*state->estimate);
  std::set<std::string> anew = worked_on(state), now;
  for (const std::size_t b : measured) now.insert(facade.brackets[b].id);
  std::vector<std::string> others;  // that this campaign did not measure
  for (const std::string& id : before.ids)
    if (now.count(id) == 0) others.push_back(id);
  if (measured.size() + others.size() > most) {
    anew.insert(others.begin(), others.end());
    out.words.push_back(std::to_string(others.size()) +
                        " anchors of campaigns before were not measured by this one and start anew with the next that "
                        "measures them: an estimate has " +
                        std::to_string(most) + " anchors at most");
  }
  const AnchorPlaces campaign = campaign_of(facade, measured);
  CombinedCampaigns combined;
  try {
    if (repeats && !is_known(campaign, before))
      combined.estimate = campaign;
    else
      combined = combine_campaigns(before, campaign, anew, options);
  } catch (const std::runtime_error& error) {
    out.words.push_back(std::string(error.what()) + "; the last campaign counts alone");
    facade.own.resize(0, 0);
    return out;
  }
  put_into(facade, measured, combined.estimate, options.drift_per_storey);
  for (std::string& line : words_of(combined)) out.words.push_back(std::move(line));
  // That it agrees too well says as much of the profile as of the campaign.
  if (!repeats && combined.known > 0) out.repetition = repetition_words(combined);
  out.estimate = artifact_of(combined.estimate);
  return out;
}

}  // namespace

RoundsEstimate combine_rounds(Facade& facade, const LoopStateT* state, const CombineOptions& options, std::size_t most,
                              const std::set<std::string>& repeated) {
  for (std::size_t b = 0; b < facade.brackets.size(); ++b) facade.brackets[b].basis = basis_of_bracket(facade, b);
  RoundsEstimate out = combined_rounds(facade, state, options, most, !repeated.empty());
  if (state) keep_bases(facade, *state, repeated);
  return out;
}

}  // namespace plumbline::loop

// What of the mistakes of set-ups can be mended without losing a reading.
#include <algorithm>
#include <set>
#include <utility>

#include "survey/start/check_set_ups.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

using Kind = SetUpProblem::Kind;

void multiply_distances(const SetUpProblem& p, SurveyObservations& survey) {
  for (Observation& o : survey.observations) {
    if (o.set_up != p.set_up) continue;
    if (o.kind != ObservationKind::slope_distance && o.kind != ObservationKind::horizontal_distance) continue;
    o.value *= p.size;
    o.corrections.push_back("unit: times " + fixed_digits(p.size, 6));
  }
}

/// The sights concerned become a set-up of their own; on a station of its own if the instrument was moved.
void split_off(const SetUpProblem& p, bool moved, const std::vector<MeanObservation>& means,
               SurveyObservations& survey) {
  std::set<std::pair<std::string, int>> sights;  // target and pointing: all readings of a sight go together
  const std::set<int> orders(p.orders.begin(), p.orders.end());
  for (const MeanObservation& mean : means) {
    if (std::none_of(mean.members.begin(), mean.members.end(), [&](int i) { return orders.contains(i); })) continue;
    for (const int i : mean.members)  // in the other face too
      sights.insert({survey.observations[i].to, survey.observations[i].pointing});
  }
  SetUp part = survey.set_ups[p.set_up];
  int number = 2;
  const auto taken = [&](const std::string& id) {
    return std::any_of(survey.set_ups.begin(), survey.set_ups.end(), [&](const SetUp& s) { return s.id == id; });
  };
  const std::string base = part.id;
  while (taken(part.id = base + " (part " + std::to_string(number) + ")")) ++number;
  if (moved) part.station = part.id;
  const int index = static_cast<int>(survey.set_ups.size());
  survey.set_ups.push_back(part);
  for (Observation& o : survey.observations) {
    if (o.set_up != p.set_up || !sights.contains({o.to, o.pointing})) continue;
    o.set_up = index;
    if (moved) o.from = part.station;
  }
}

}  // namespace

bool mend_set_ups(const std::vector<SetUpProblem>& problems, const std::vector<MeanObservation>& means,
                  SurveyObservations& survey) {
  bool mended = false;
  for (const SetUpProblem& p : problems) {
    if (!p.certain) continue;
    if (p.kind == Kind::unit) multiply_distances(p, survey);
    if (p.kind == Kind::turned_circle || p.kind == Kind::moved_instrument)
      split_off(p, p.kind == Kind::moved_instrument, means, survey);
    mended |= p.kind == Kind::unit || p.kind == Kind::turned_circle || p.kind == Kind::moved_instrument;
  }
  return mended;
}

}  // namespace plumbline::survey

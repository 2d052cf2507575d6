// May the result be used?
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "geometry/statistics.hpp"
#include "survey/doctor/network_doctor.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

/// Beyond that it is not the instrument that is worse than its profile: readings are wrong, or their units.
constexpr double kLargestSigma0 = 10;
constexpr double kClearly = 0.001;  ///< error of the first kind of the doubt

long failing(const NetworkResult& r, double critical) {
  return std::count_if(r.rows.begin(), r.rows.end(),
                       [&](const ResultRow& row) { return !row.removed && std::abs(row.statistics.w) > critical; });
}

/// Where all readings agree far better than stated, the tests at the stated accuracies see nothing: against each other
/// (tau) they are tested at the level of removals, over all of them together.
long failing_among_themselves(const NetworkResult& r, double critical) {
  const double alpha = 2 * (1 - normal_probability(critical));
  const double tau = least_squares::tau_critical(std::max(alpha, 1e-12), r.degrees_of_freedom);
  return r.sigma0 > 0 && std::isfinite(tau) ? failing(r, tau * r.sigma0) : 0;
}

std::string mended(const NetworkResult& r) {
  const auto removed = std::count_if(r.rows.begin(), r.rows.end(), [](const ResultRow& row) { return row.removed; });
  if (removed == 0) return "";
  return "; " + std::to_string(removed) + (removed == 1 ? " reading was" : " readings were") + " taken out";
}

/// One turn that was found in two steps leaves two parts of one orientation, which is not that from before it.
bool are_turned_alike(const ResultSetUp& a, const ResultSetUp& b) {
  constexpr double kSigmas = 5;
  if (a.id.find(" (part ") == std::string::npos || b.id.find(" (part ") == std::string::npos) return false;
  return a.station == b.station && std::abs(std::remainder(a.orientation - b.orientation, 2 * std::numbers::pi)) <
                                       kSigmas * std::hypot(a.orientation_sigma, b.orientation_sigma);
}

/// A set-up that was split at two places or more, or lost a third of its readings, was not measured as the model says:
/// what is left agrees because everything that did not was taken out. Empty if there is none.
std::string broken_set_up(const NetworkResult& r) {
  constexpr std::size_t kMostParts = 2;
  constexpr int kFewRemoved = 6;
  struct Mended {
    std::vector<const ResultSetUp*> parts;  // of different orientations
    int readings = 0, removed = 0;
  };
  const auto base = [](const std::string& id) { return id.substr(0, id.find(" (part ")); };
  std::map<std::string, Mended> set_ups;
  for (const ResultSetUp& s : r.set_ups) {
    auto& parts = set_ups[base(s.id)].parts;
    if (std::none_of(parts.begin(), parts.end(), [&](const ResultSetUp* p) { return are_turned_alike(*p, s); }))
      parts.push_back(&s);
  }
  for (const ResultRow& row : r.rows) {
    if (row.set_up.empty()) continue;
    Mended& m = set_ups[base(row.set_up)];
    ++m.readings;
    m.removed += row.removed;
  }
  for (const auto& [id, m] : set_ups) {
    if (m.parts.size() > kMostParts)
      return "the readings of set-up " + id + " contradict each other: its circle would have been turned " +
             std::to_string(m.parts.size() - 1) + " times";
    if (m.removed >= kFewRemoved && 3 * m.removed > m.readings)
      return "the readings of set-up " + id + " contradict the others: " + std::to_string(m.removed) + " of " +
             std::to_string(m.readings) + " were taken out";
  }
  return "";
}

/// Of coordinates that nothing here measured again.
std::string verdict_of_list(const SurveyObservations& list, const AdjustOptions& options) {
  if (!options.coordinates_are_tested)
    return "not tested: a list of coordinates without readings is taken as given, and nothing here tests it";
  const bool apart = std::all_of(list.coordinates.begin(), list.coordinates.end(), [](const CoordinateGroup& g) {
    return std::all_of(g.components.begin(), g.components.end(),
                       [&](const auto& component) { return component.point == g.components.front().point; });
  });
  return std::string(
             "as given: a list of coordinates without readings, adjusted and tested elsewhere by what was said") +
         (apart ? "; the errors of each point are taken as its own" : "");
}

/// Readings that pass one by one may all share an error, and one that was taken off may have been another.
void doubt_common_errors(NetworkResult& r) {
  if (r.validity != Validity::sound || (r.common_error.empty() && r.undecided.empty())) return;
  r.validity = Validity::doubtful;
  r.verdict = (r.common_error.empty()
                   ? "doubtful: two errors explain the readings alike, and the first was taken off: " + r.undecided
                   : "doubtful: one error explains the readings better than chance: " + r.common_error) +
              "; of the readings one by one: " + r.verdict;
}

/// A set-up of which sights to three targets were taken out, more than a tenth of its readings: where it was moved, or
/// they were, what is left of it agrees with either. Distances alone (edges, glass) leave the directions of the same
/// sights, which no instrument that moved would have left. In words; empty: none.
std::string thinned_set_up(const NetworkResult& r) {
  constexpr std::size_t kTargets = 3;
  constexpr int kOneIn = 10;
  std::map<std::string, std::map<std::string, std::set<std::string>>> targets;  // kinds that were taken out
  std::map<std::string, std::pair<int, int>> counts;                            // readings, removed
  for (const ResultRow& row : r.rows) {
    if (row.set_up.empty()) continue;
    auto& [readings, removed] = counts[row.set_up];
    ++readings, removed += row.removed;
    if (row.removed) targets[row.set_up][row.to].insert(row.kind);
  }
  for (auto& [id, seen] : targets) {
    std::erase_if(seen,
                  [](const auto& target) { return target.second.size() == 1 && !target.second.contains("direction"); });
    if (seen.size() >= kTargets && kOneIn * counts.at(id).second > counts.at(id).first)
      return "sights of set-up " + id + " to " + std::to_string(seen.size()) +
             " targets were taken out, so that the rest of it had to agree: these may be right and the others wrong";
  }
  return "";
}

/// What is left agrees whichever of two readings is taken out: that it does is no proof that it was the wrong one.
void doubt_choices(NetworkResult& r) {
  if (r.validity != Validity::sound || r.either.empty()) return;
  r.validity = Validity::doubtful;
  r.verdict = "doubtful: " + r.either + "; of the readings that are left: " + r.verdict;
}

/// What is left agrees because what did not was taken out. One reading in twenty at most is wrong by itself, and an
/// error in common that was found ends the matter but for one in a hundred: where it does not, it was another one.
void doubt_mending(NetworkResult& r) {
  constexpr long kFew = 3, kOneIn = 20, kOneInBesides = 100;
  const long removed = std::count_if(r.rows.begin(), r.rows.end(), [](const ResultRow& row) { return row.removed; });
  const auto splits = std::count_if(r.set_ups.begin(), r.set_ups.end(),
                                    [](const ResultSetUp& s) { return s.id.find(" (part ") != std::string::npos; });
  const long rows = static_cast<long>(r.rows.size());
  const bool many = removed >= kFew && kOneIn * removed > rows;
  const bool besides = removed >= kFew && kOneInBesides * removed > rows && (r.errors_taken_off > 0 || splits > 0);
  if (r.validity != Validity::sound) return;
  const std::string thinned = thinned_set_up(r);
  if (!many && !besides && thinned.empty()) return;
  r.validity = Validity::doubtful;
  if (!many && !besides) {
    r.verdict = "doubtful: " + thinned + "; of the readings that are left: " + r.verdict;
    return;
  }
  r.verdict = "doubtful: so much was mended that what is left had to agree, and the cause may be another one" +
              std::string(many ? "" : " than was taken off") + "; of the readings that are left: " + r.verdict;
}

/// A network has its readings by the hundred and its known points by the handful: in its global test one of these that
/// is wrong by ten standard deviations may drown.
void doubt_known_points(NetworkResult& r) {
  const std::vector<std::string> wrong = contradicting(r.known_points);
  if (r.validity != Validity::sound || wrong.empty()) return;
  r.validity = Validity::doubtful;
  r.verdict = "doubtful: known points contradict the readings and each other, most of all " + wrong.front() +
              "; of the readings: " + r.verdict;
}

/// What a file's tolerance leaves out (gama's tol-abs) tests nothing: of a known point it may be the point that is
/// wrong.
void doubt_outlying(const NetworkModel& model, NetworkResult& r) {
  if (model.outlying_known.empty() || r.validity != Validity::sound) return;
  r.validity = Validity::doubtful;
  r.verdict =
      "doubtful: known points contradict all readings that touch them, which the file's own tolerance leaves out (" +
      join(model.outlying_known, 4) + "); of the readings: " + r.verdict;
}

}  // namespace

void judge(const NetworkModel& model, const AdjustOptions& options, double critical, NetworkResult& r) {
  const std::string sigma0 = "sigma0 " + fixed_digits(r.sigma0, 2);
  const bool high = r.degrees_of_freedom > 0 && r.global_test.verdict == least_squares::GlobalTest::Verdict::high;
  // One sound network in forty fails its global test; without a suspect it is doubted only if it fails clearly.
  const bool clearly = high && r.sum_of_squares > chi_squared_quantile(1 - kClearly, r.degrees_of_freedom);
  const bool low = r.degrees_of_freedom > 0 && r.sum_of_squares < chi_squared_quantile(kClearly, r.degrees_of_freedom);
  const bool error = std::any_of(r.findings.begin(), r.findings.end(),
                                 [](const Finding& f) { return f.severity == Finding::Severity::error; });
  const long suspects = failing(r, critical);
  const std::string broken = broken_set_up(r);
  const bool contradicted = !model.contradiction.empty();
  if (contradicted || error || !broken.empty() || (high && r.sigma0 > kLargestSigma0)) {
    r.validity = Validity::invalid;
    r.verdict = "not a result: " +
                std::string(contradicted      ? "set-ups contradict each other: " + model.contradiction
                            : error           ? "the coordinates are probably wrong"
                            : !broken.empty() ? broken
                                              : "the readings contradict each other") +
                " (" + sigma0 + "); mend what the findings name and adjust again";
    const double factor = std::max(1.0, r.sigma0 * r.sigma0 / r.variance_factor);
    r.cofactors.multiply(factor);
    r.variance_factor *= factor;
  } else if (r.without_readings && !clearly && suspects == 0) {
    r.validity = options.coordinates_are_tested ? Validity::sound : Validity::doubtful;
    r.verdict = verdict_of_list(model.survey, options);
  } else if (r.degrees_of_freedom == 0) {
    r.validity = Validity::doubtful;
    r.verdict = "cannot be tested: no reading is controlled by another";
  } else if (clearly || suspects > 0) {
    r.validity = Validity::doubtful;
    r.verdict =
        "doubtful: " +
        (suspects > 0 ? std::to_string(suspects) + (suspects == 1 ? " reading fails" : " readings fail") + " the test"
                      : std::string("the readings agree less well than their accuracies say")) +
        " (" + sigma0 + ")" + mended(r);
  } else if (low) {
    const long among = failing_among_themselves(r, critical);
    const std::string found = sigma0 + ", v'Pv " + fixed_digits(r.sum_of_squares, 1) + " where " +
                              fixed_digits(r.global_test.lower, 0) + " to " + fixed_digits(r.global_test.upper, 0) +
                              " were to be expected";
    r.validity = among > 0 ? Validity::doubtful : Validity::sound;
    r.verdict = std::string(among > 0 ? "doubtful" : "sound") +
                ": the readings agree far better than their accuracies say (" + found +
                "): these are too cautious, and standard deviations and ellipses too large by a factor of about " +
                fixed_digits(1 / r.sigma0, 1) +
                (among > 0 ? "; measured by their own agreement " + std::to_string(among) +
                                 (among == 1 ? " reading fails" : " readings fail") + " the test"
                           : "") +
                mended(r);
  } else {
    r.validity = Validity::sound;
    r.verdict = "sound: the readings agree as well as their accuracies say (" + sigma0 +
                (high ? ", a little high" : "") + ")" + mended(r);
  }
  doubt_common_errors(r);
  doubt_choices(r);
  doubt_mending(r);
  doubt_known_points(r);
  doubt_outlying(model, r);
}

std::vector<std::string> contradicting(const std::vector<KnownPoint>& known) {
  std::vector<const KnownPoint*> wrong;
  for (const KnownPoint& k : known)
    if (!k.stands()) wrong.push_back(&k);
  std::stable_sort(wrong.begin(), wrong.end(),
                   [](const KnownPoint* a, const KnownPoint* b) { return a->statistic > b->statistic; });
  std::vector<std::string> ids;
  for (const KnownPoint* k : wrong) ids.push_back(k->id);
  return ids;
}

void doubt_known_names(const std::vector<std::string>& points, NetworkResult& r) {
  if (points.empty() || r.validity == Validity::invalid) return;
  r.validity = Validity::doubtful;
  r.verdict = "doubtful: known points hold nothing, as their names are written otherwise than those read (" +
              join(points, 4) + "); of the readings: " + r.verdict;
}

}  // namespace plumbline::survey

// Mistakes that a whole set-up shares are named as such; no single observation is taken out for them.
#include <algorithm>
#include <set>

#include "geometry/random.hpp"
#include "simulated_network.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace {

using test::simulate;

AdjustOptions free_network(bool remove) {
  AdjustOptions options;
  options.datum = DatumMode::inner;
  options.curvature = Switch::off;
  options.remove_blunders = remove;
  return options;
}

std::string first_warning(const NetworkResult& result) {
  for (const Finding& f : result.findings)
    if (f.severity == Finding::Severity::warning) return f.text;
  return "";
}

void expect_words(const std::string& text, std::initializer_list<const char*> words) {
  for (const char* word : words) EXPECT_NE(text.find(word), std::string::npos) << word << " in: " << text;
}

TEST(CommonErrors, WrongPrismConstantOfOneSetUp) {
  auto n = simulate({}, 11);
  for (Observation& o : n.survey.observations)
    if (o.set_up == 1 && o.kind == ObservationKind::slope_distance) o.value += 0.0344;
  const NetworkResult result = adjust_network(n.survey, free_network(true));
  EXPECT_TRUE(result.snooping.empty()) << "data snooping took innocent observations out";
  expect_words(first_warning(result), {"all 12 distances of set-up S2 look too long by 34", "prism constant"});
}

TEST(CommonErrors, WrongInstrumentHeightOnAKnownPoint) {
  auto n = simulate({}, 12);
  // S1 stands twice on its point: the second time with a height that is 20 mm too large.
  const size_t count = n.survey.observations.size();
  n.survey.set_ups.push_back({"S1 again", "S1", 0.02, {}});
  n.survey.set_ups[0].instrument_height = 0.0;
  const int pointings = static_cast<int>(count);
  for (size_t i = 0; i < count; ++i) {
    Observation o = n.survey.observations[i];
    if (o.set_up != 0) continue;
    o.set_up = 3, o.pointing += pointings;
    n.survey.observations.push_back(o);
  }
  const NetworkResult result = adjust_network(n.survey, free_network(true));
  expect_words(first_warning(result), {"instrument height of set-up S1"});
}

TEST(CommonErrors, OneWrongReadingIsNotTakenForACommonError) {
  auto n = simulate({}, 13);
  for (Observation& o : n.survey.observations)
    if (o.set_up == 1 && o.kind == ObservationKind::slope_distance && o.to == "M12") o.value += 0.03;
  const NetworkResult result = adjust_network(n.survey, free_network(true));
  ASSERT_FALSE(result.snooping.empty());
  const ResultRow& removed = result.rows[static_cast<size_t>(result.snooping[0].row)];
  EXPECT_EQ(removed.to, "M12");
  EXPECT_EQ(removed.kind, "slope_distance");
  for (const Finding& f : result.findings) EXPECT_EQ(f.text.find("explains the misfit"), std::string::npos) << f.text;
}

TEST(CommonErrors, SoundNetworksRaiseFewFalseAlarms) {
  int alarms = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const NetworkResult result = adjust_network(simulate({}, seed).survey, free_network(false));
    for (const Finding& f : result.findings) alarms += f.text.find("explains the misfit") != std::string::npos;
  }
  // 12 hypotheses at 0.1 % in each of 200 networks: 2.4 expected at most; Poisson, 99.9 %.
  EXPECT_LE(alarms, 8);
}

/// Five blunders mask each other: the robust start takes out whoever looks bad beside them, and the innocent come back.
TEST(RobustStart, TakesSuspectsOutAtOnceAndGivesTheInnocentBack) {
  auto n = simulate({}, 7);
  Random random(7, "x");
  std::set<size_t> wrong;
  for (int k = 0; k < 5; ++k) {
    const auto i = static_cast<size_t>(random.uniform() * static_cast<double>(n.survey.observations.size()));
    Observation& o = n.survey.observations[i];
    o.value += (o.kind == ObservationKind::slope_distance ? 0.05 : 0.004) * (0.5 + random.uniform());
    wrong.insert(i);
  }
  const auto removed = [](const NetworkResult& r) {
    std::set<size_t> rows;
    for (size_t i = 0; i < r.rows.size(); ++i)
      if (r.rows[i].removed) rows.insert(i);
    return rows;
  };
  const auto given_back = [](const NetworkResult& r) {
    return std::count_if(r.snooping.begin(), r.snooping.end(), [](const SnoopingAction& a) { return a.restored; });
  };
  AdjustOptions options = free_network(true);
  options.largest_removed_share = 0.15;
  const NetworkResult one_by_one = adjust_network(n.survey, options);
  EXPECT_EQ(removed(one_by_one), wrong);
  EXPECT_EQ(given_back(one_by_one), 0);
  options.robust_start = true;
  const NetworkResult at_once = adjust_network(n.survey, options);
  EXPECT_EQ(removed(at_once), wrong);
  EXPECT_GT(given_back(at_once), 0);
}

TEST(NetworkDoctor, NamesTheWorstSuspectFirst) {
  auto n = simulate({}, 14);
  for (Observation& o : n.survey.observations)
    if (o.set_up == 2 && o.kind == ObservationKind::zenith_angle && o.to == "M20") o.value += 5e-4;
  const NetworkResult result = adjust_network(n.survey, free_network(false));
  for (const Finding& f : result.findings) {
    if (f.text.find("suspect: ") != 0) continue;
    expect_words(f.text, {"zenith angle S3 -> M20"});
    return;
  }
  FAIL() << "no suspect is named";
}

}  // namespace
}  // namespace plumbline::survey

// Errors that cannot be told apart, or that nobody can mend, are named and nothing is taken off or out for them.
#include <algorithm>
#include <cmath>

#include "geometry/random.hpp"
#include "on_control.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_rival_causes {

using test::OnControl;

void expect_words(const std::string& text, std::initializer_list<const char*> words) {
  for (const char* word : words) EXPECT_NE(text.find(word), std::string::npos) << word << " in: " << text;
}

/// The pole of S2 noted 0.1 m too long is the pole of S1 noted too short: mended the first way all details lay 100 mm
/// too low, in a sound network.
TEST(RivalCauses, OfTwoSetUpsWithAPoleNobodyKnowsWhichIsWrong) {
  for (const int wrong : {0, 1}) {
    OnControl field(90);
    for (Observation& o : field.network.survey.observations) {
      o.target_height = field.is_known(o.to) ? 0 : 1.7;
      if (!field.is_known(o.to) && o.kind != ObservationKind::direction) {
        const Eigen::Vector3d d =
            field.network.truth[o.to[1] * 5 - '0' * 5 + o.to[2] - '0'] - field.network.truth[20 + o.set_up];
        const Eigen::Vector3d up = d + Eigen::Vector3d(0, 0, 1.7);
        o.value += o.kind == ObservationKind::slope_distance
                       ? up.norm() - d.norm()
                       : std::atan2(up.head<2>().norm(), up.z()) - std::atan2(d.head<2>().norm(), d.z());
        if (o.set_up == wrong) o.target_height = 1.8;
      }
    }
    // As a large network is judged, too: by its last equations, where each rival would be an adjustment.
    for (const int largest_whole : {AdjustOptions().largest_whole, 1}) {
      const NetworkResult r = field.adjust(true, largest_whole);
      EXPECT_NE(r.validity, Validity::sound) << r.verdict;
      expect_words(r.common_error,
                   {"the target height of", "of set-up S1", "of set-up S2", "the readings do not tell which"});
      EXPECT_EQ(r.errors_taken_off, 0);
      EXPECT_TRUE(r.snooping.empty());
    }
  }
}

/// Both distances to a mark on an edge 60 mm too long: the two sound directions went, and it lay 63 mm off, "sound".
TEST(RivalCauses, AnEdgeIsNamedAndNothingIsTakenOut) {
  OnControl field(91);
  for (Observation& o : field.network.survey.observations)
    if (o.kind == ObservationKind::slope_distance && o.to == "M12") o.value += 0.06;
  const NetworkResult r = field.adjust(true);
  EXPECT_NE(r.validity, Validity::sound) << r.verdict;
  expect_words(r.common_error, {"all 2 distances to M12 look too long by", "edge"});
  EXPECT_TRUE(r.snooping.empty());
}

/// One error that nobody can mend does not keep a blunder of another target in.
TEST(RivalCauses, BesideAnEdgeBlundersOfOtherTargetsGo) {
  OnControl field(91);
  for (Observation& o : field.network.survey.observations) {
    if (o.kind == ObservationKind::slope_distance && o.to == "M12") o.value += 0.06;
    if (o.kind == ObservationKind::direction && o.to == "M31" && o.set_up == 1) o.value += 0.01;
  }
  const NetworkResult r = field.adjust(true);
  EXPECT_NE(r.validity, Validity::sound) << r.verdict;
  expect_words(r.common_error, {"distances to M12 look too long by"});
  for (const SnoopingAction& a : r.snooping) EXPECT_NE(r.rows[a.row].to, "M12");
  EXPECT_TRUE(std::any_of(r.snooping.begin(), r.snooping.end(),
                          [&](const SnoopingAction& a) { return r.rows[a.row].to == "M31"; }));
}

/// An axis that leans was an index of all zenith angles, a tripod that sinks one of either set-up; both were taken off.
TEST(RivalCauses, TiltAndASinkingTripodAreNamedAndNotTakenOff) {
  for (const bool tilt : {true, false}) {
    OnControl field(92);
    field.know_stations();
    for (Observation& o : field.network.survey.observations) {
      if (o.set_up != 1 || o.kind != ObservationKind::zenith_angle) continue;
      const Eigen::Vector3d d = field.network.truth[(o.to[1] - '0') * 5 + o.to[2] - '0'] - field.network.truth[21];
      const double h = d.head<2>().norm();
      o.value += tilt ? 2e-4 * d.x() / h : -0.006 * (o.pointing - 20) / 20 * h / d.squaredNorm();
    }
    const NetworkResult r = field.adjust(true);
    EXPECT_NE(r.validity, Validity::sound) << r.verdict;
    expect_words(r.common_error, {tilt ? "the vertical axis of set-up S2 looks tilted by 1"
                                       : "the instrument of set-up "
                                         "S2 looks as if it had sunk by"});
    EXPECT_EQ(r.errors_taken_off, 0);
  }
}

/// Two zenith angles of a mark whose distances are of a few centimetres, one of them wrong: whichever goes, the rest
/// agrees.
TEST(RivalCauses, OfTwoReadingsThatControlEachOtherAloneNobodyKnowsWhichIsWrong) {
  for (const int wrong : {0, 1}) {
    OnControl field(93);
    for (Observation& o : field.network.survey.observations) {
      if (o.to != "M12") continue;
      if (o.kind == ObservationKind::zenith_angle && o.set_up == wrong) o.value += 0.002;
      if (o.kind == ObservationKind::slope_distance) o.sigma = 0.05;
    }
    const NetworkResult r = field.adjust(true);
    EXPECT_EQ(r.validity, Validity::doubtful) << r.verdict;
    expect_words(r.verdict, {"1 of ", "readings is wrong, and nothing tells which", "zenith angle S1 -> M12",
                             "zenith angle S2 -> M12", "measure M12 once more"});
    EXPECT_EQ(r.snooping.size(), 1u);
  }
}

/// Three sights control each other: the wrong one is known, and nothing is doubted.
TEST(RivalCauses, OfThreeReadingsTheWrongOneIsKnown) {
  test::SimulationSettings settings;
  settings.set_ups = 3, settings.columns = 5, settings.rows = 4;
  int doubtful = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    test::SimulatedNetwork network = simulate(settings, seed);
    for (Observation& o : network.survey.observations)
      if (o.kind == ObservationKind::zenith_angle && o.to == "M12" && o.set_up == static_cast<int>(seed % 3))
        o.value += 0.002;
    AdjustOptions options;
    options.curvature = Switch::off, options.remove_blunders = true, options.datum = DatumMode::inner;
    const NetworkResult r = adjust_network(network.survey, options);
    doubtful += r.validity != Validity::sound;
    EXPECT_EQ(r.snooping.size(), 1u) << seed << ": " << r.verdict;
  }
  EXPECT_LE(doubtful, 1);
}

/// Readings noisier than stated: of a hundred motions and edges one was large by chance, and was named as the cause.
TEST(RivalCauses, NoiseIsNoMotion) {
  int named = 0, doubtful = 0;
  for (std::uint64_t seed = 100; seed < 130; ++seed) {
    OnControl field(seed);
    Random random(seed);
    for (Observation& o : field.network.survey.observations)
      o.value += random.normal() * (o.kind == ObservationKind::slope_distance ? 0.002 : 1.5e-5);
    const NetworkResult r = field.adjust(false);
    doubtful += r.validity != Validity::sound;
    for (const char* const words : {"looks tilted", "looks as if it had", "an edge beside it"})
      named += r.common_error.find(words) != std::string::npos;
  }
  EXPECT_GE(doubtful, 20);
  EXPECT_LE(named, 1);
}

}  // namespace test_rival_causes
}  // namespace plumbline::survey

// The anchors of a facade by all rounds: control stays common, what was worked on starts anew, what nobody measured
// stays unmeasured.
#include <gtest/gtest.h>

#include "loop/state/plan_artifact.hpp"
#include "loop/state/rounds_estimate.hpp"
#include "loop/state/state_file.hpp"
#include "random_facade.hpp"

namespace plumbline::loop {
namespace test_rounds_estimate {

using test::random_facade;

constexpr CombineOptions kNoDrift{0, 1e-3, 1e-6};

/// A floor of two panels whose anchors are known to 0.5 mm each, and control to 0.9 mm in height.
Facade measured(std::uint64_t seed) {
  Facade facade = random_facade({1, 2}, seed, 0.0005, 0.0005, 0);
  facade.own = facade.covariance;
  for (Eigen::Index i = 2; i < facade.covariance.rows(); i += 3)
    for (Eigen::Index j = 2; j < facade.covariance.cols(); j += 3) facade.covariance(i, j) += 0.0009 * 0.0009;
  return facade;
}

std::unique_ptr<LoopItemT> bracket_item(const std::string& id, ItemStatus status) {
  auto item = std::make_unique<LoopItemT>();
  item->id = id, item->kind = "bracket", item->status = status;
  item->setting.setZero(), item->pending.setZero(), item->expected.setZero();
  return item;
}

TEST(RoundsEstimate, WhatCampaignsShareIsNotAveragedAway) {
  LoopStateT state;
  Facade facade;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    facade = measured(seed);
    RoundsEstimate rounds = combine_rounds(facade, &state, kNoDrift);
    EXPECT_TRUE(rounds.words.empty());
    EXPECT_EQ(rounds.repetition, "");
    state.estimate = std::move(rounds.estimate);
  }
  EXPECT_NEAR(facade.covariance(0, 0), 0.0005 * 0.0005 / 4, 1e-15);
  EXPECT_NEAR(facade.covariance(2, 2), 0.0005 * 0.0005 / 4 + 0.0009 * 0.0009, 1e-15);
  EXPECT_NEAR(facade.covariance(2, 5), 0.0009 * 0.0009, 1e-15);
  EXPECT_EQ(facade.brackets[0].campaigns, 4);
  // The difference of two campaigns, without control.
  EXPECT_NEAR(facade.brackets[0].difference_sigma.z(), std::sqrt(2.0) * 0.0005, 1e-9);
  // The mean of four.
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) sum += measured(seed).brackets[0].deviation.x() / 4;
  EXPECT_NEAR(facade.brackets[0].deviation.x(), sum, 1e-12);
}

TEST(RoundsEstimate, WhatWasWorkedOnStartsAnew) {
  LoopStateT state;
  Facade first = measured(1), second = measured(2);
  state.estimate = combine_rounds(first, &state, kNoDrift).estimate;
  state.items.push_back(bracket_item(first.brackets[0].id, ItemStatus::executed));
  state.items.push_back(bracket_item(first.brackets[1].id, ItemStatus::verified));
  state.items.push_back(bracket_item(first.brackets[2].id, ItemStatus::planned));
  state.items.back()->expected.setConstant(kUnknown);  // somebody failed at it, or a person accepted it
  const Facade alone = second;
  combine_rounds(second, &state, kNoDrift);
  EXPECT_EQ(second.brackets[0].campaigns, 1);
  EXPECT_EQ(second.brackets[1].campaigns, 2);
  EXPECT_EQ(second.brackets[2].campaigns, 1);
  EXPECT_LT((second.brackets[0].deviation - alone.brackets[0].deviation).norm(), 1e-12);
  EXPECT_GT((second.brackets[1].deviation - alone.brackets[1].deviation).norm(), 1e-6);
}

TEST(RoundsEstimate, AnAnchorThatThisCampaignDidNotMeasureStaysUnmeasuredAndKeepsItsEstimate) {
  LoopStateT state;
  Facade first = measured(1), second = measured(2), third = measured(3);
  state.estimate = combine_rounds(first, &state, kNoDrift).estimate;
  second.brackets[0].deviation.setConstant(kUnknown);
  state.estimate = combine_rounds(second, &state, kNoDrift).estimate;
  EXPECT_FALSE(second.brackets[0].measured());
  EXPECT_TRUE(second.brackets[0].basis.empty());
  combine_rounds(third, &state, kNoDrift);
  EXPECT_EQ(third.brackets[0].campaigns, 2);
  EXPECT_EQ(third.brackets[1].campaigns, 3);
}

/// Floor by floor: the estimate does not grow with the building.
TEST(RoundsEstimate, BeyondTheMostWhatThisCampaignDidNotMeasureStartsAnew) {
  LoopStateT state;
  Facade first = measured(1), second = measured(2), third = measured(3);
  const std::size_t most = first.brackets.size();
  state.estimate = combine_rounds(first, &state, kNoDrift, most).estimate;
  second.brackets[0].id = "another";
  RoundsEstimate rounds = combine_rounds(second, &state, kNoDrift, most);
  ASSERT_TRUE(rounds.estimate);
  EXPECT_EQ(rounds.estimate->ids.size(), most);
  ASSERT_EQ(rounds.words.size(), 1u);
  EXPECT_EQ(rounds.words[0].rfind("1 anchors of campaigns before", 0), 0u) << rounds.words[0];
  state.estimate = std::move(rounds.estimate);
  combine_rounds(third, &state, kNoDrift, most);
  EXPECT_EQ(third.brackets[0].campaigns, 1);
  EXPECT_EQ(third.brackets[1].campaigns, 3);
}

/// Run twice with the same words a round gives the same bytes: the basis is the campaign's own.
TEST(RoundsEstimate, TheBasisIsThatOfTheCampaignAndTheStateFileKeepsTheEstimate) {
  LoopStateT state;
  Facade first = measured(1), second = measured(2);
  const std::string basis = basis_of_bracket(second, 0);
  state.estimate = combine_rounds(first, &state).estimate;
  const LoopStateT read = read_state_json(state_json(state), "state.json");
  ASSERT_TRUE(read.estimate);
  EXPECT_EQ(read.estimate->own, state.estimate->own);
  EXPECT_EQ(read.estimate->campaigns, state.estimate->campaigns);
  Facade once = second, again = second;
  combine_rounds(once, &read), combine_rounds(again, &state);
  EXPECT_EQ(once.brackets[0].basis, basis);
  EXPECT_EQ(once.brackets[0].deviation, again.brackets[0].deviation);
}

TEST(RoundsEstimate, WithoutWhatCampaignsShareNothingIsCombinedAndTooManyAnchorsAreSaid) {
  LoopStateT state;
  Facade unknown = measured(1), many = measured(1);
  unknown.own.resize(0, 0);
  EXPECT_FALSE(combine_rounds(unknown, &state).estimate);
  const RoundsEstimate rounds = combine_rounds(many, &state, {}, 5);
  EXPECT_FALSE(rounds.estimate);
  ASSERT_EQ(rounds.words.size(), 1u);
  EXPECT_NE(rounds.words[0].find("campaigns are combined up to 5"), std::string::npos);
}

/// A folder that holds readings of a campaign before: it counts alone, and what those readings see was not measured.
TEST(RoundsEstimate, WhatIsReadFromACampaignBeforeWasNotMeasuredSince) {
  LoopStateT state;
  Facade first = measured(1), second = measured(2), again = measured(2);
  state.estimate = combine_rounds(first, &state, kNoDrift).estimate;
  for (const Bracket& bracket : first.brackets) {
    state.items.push_back(bracket_item(bracket.id, ItemStatus::verified));
    state.items.back()->basis = bracket.basis;
  }
  const std::set<std::string> repeated = {first.brackets[0].id};
  const std::string own = basis_of_bracket(second, 0), other = basis_of_bracket(second, 1);
  const RoundsEstimate rounds = combine_rounds(second, &state, kNoDrift, 500, repeated);
  EXPECT_EQ(second.brackets[0].campaigns, 1);
  EXPECT_EQ(second.brackets[1].campaigns, 1);
  EXPECT_EQ(second.brackets[0].basis, first.brackets[0].basis);
  EXPECT_EQ(second.brackets[1].basis, other);
  // The estimate knows it by its own name: planned once more it is the same campaign, not one that repeats it.
  state.estimate = std::make_unique<AnchorEstimateT>(*rounds.estimate);
  EXPECT_EQ(state.estimate->campaigns[0], own + " ");
  const RoundsEstimate once_more = combine_rounds(again, &state, kNoDrift, 500, repeated);
  EXPECT_EQ(once_more.estimate->campaigns, rounds.estimate->campaigns);
}

/// All agree far better than they can: exported again with fewer digits, or by an instrument that is better than its
/// profile. Which of the two nobody can tell, so it counts alone and judges.
TEST(RoundsEstimate, ACampaignThatAgreesTooWellCountsAloneAndIsNoDoubt) {
  LoopStateT state;
  Facade first = measured(1), again = measured(1), other = measured(2), mixed = measured(2);
  state.estimate = combine_rounds(first, &state, kNoDrift).estimate;
  for (Bracket& bracket : again.brackets) bracket.deviation = 1e-4 * (1e4 * bracket.deviation).array().round().matrix();
  const RoundsEstimate alike = combine_rounds(again, &state, kNoDrift);
  EXPECT_EQ(alike.repetition, "");
  ASSERT_EQ(alike.words.size(), 1u);
  EXPECT_EQ(alike.words[0].find("this campaign agrees with those before far better than it can"), 0u);
  EXPECT_EQ(alike.estimate->campaigns, combine_rounds(again, nullptr, kNoDrift).estimate->campaigns);
  // One anchor was measured anew, and the places of all others are those of before.
  Facade tied = measured(1);
  tied.own.array() += 1e-9, tied.covariance.array() += 1e-9;
  Facade part = tied;
  part.brackets[0].deviation.x() += 0.0003;
  LoopStateT of_tied;
  of_tied.estimate = combine_rounds(tied, &of_tied, kNoDrift).estimate;
  EXPECT_NE(combine_rounds(part, &of_tied, kNoDrift).repetition.find("anchors are those of a campaign before, to a"),
            std::string::npos);
  EXPECT_EQ(combine_rounds(other, &state, kNoDrift).repetition, "");
  // Of which readings these are is known: what they do not see counts.
  EXPECT_EQ(combine_rounds(mixed, &state, kNoDrift, 500, {first.brackets[0].id}).repetition, "");
}

}  // namespace test_rounds_estimate
}  // namespace plumbline::loop

// What fails a test proves nothing; what only fits less well than it should is less certain, by a factor that is known.
#include "building/judgement/trust.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "building/ifc/doubt_words.hpp"

namespace plumbline::judgement {
namespace trust_test {

/// One failed test of a block whose observations are "images" and "control".
Trust after(BlockTestKind kind, const char* test, double variance_factor) {
  flatbuffers::FlatBufferBuilder made;
  const auto groups =
      made.CreateVector(std::vector{CreateBlockGroupDirect(made, "images"), CreateBlockGroupDirect(made, "control")});
  const auto tests = made.CreateVector(
      std::vector{CreateBlockTestDirect(made, test, kind, variance_factor, 1.0, false, "it does not fit"),
                  CreateBlockTestDirect(made, "images", BlockTestKind::observations, 9.0, 10.0, true)});
  const auto start = made.StartTable();
  made.AddOffset(Block::VT_GROUPS, groups), made.AddOffset(Block::VT_TESTS, tests);
  made.Finish(flatbuffers::Offset<Block>(made.EndTable(start)));
  return trust_of(flatbuffers::GetRoot<Block>(made.GetBufferPointer()), nullptr);
}

TEST(Trust, AModelThatFitsLessWellMakesEverythingLessCertainAndAGroupThatContradictsProvesNothing) {
  EXPECT_TRUE(trust_of(nullptr, nullptr).doubts.empty());
  EXPECT_EQ(trust_of(nullptr, nullptr).factor, 1);
  const Trust model = after(BlockTestKind::principal_points, "any name", 6.25),
              group = after(BlockTestKind::observations, "control", 6.25);
  EXPECT_TRUE(model.doubts.empty());
  EXPECT_EQ(model.factor, 6.25);
  ASSERT_EQ(model.misfits.size(), 1u);
  EXPECT_EQ(model.misfits[0].factor, 2.5);
  EXPECT_EQ(model.misfits[0].mend, "block.with.image_principal_point_sigma=0.5");
  EXPECT_EQ(ifc::in_words(model.misfits[0]),
            "the image block: it does not fit; all standard deviations are 2.5 times as large for it. To mend it, run "
            "again with \"block.with.image_principal_point_sigma=0.5\" (px; 0.1 to 1 for lenses that are focused or "
            "stabilised between images).");
  EXPECT_TRUE(group.misfits.empty());
  EXPECT_EQ(group.doubts.size(), 1u);
}

TEST(Trust, ATestThatFailsByNobodyKnowsHowMuchIsADoubt) {
  const Trust trust = after(BlockTestKind::principal_points, "any name", std::nan(""));
  EXPECT_TRUE(trust.misfits.empty());
  ASSERT_EQ(trust.doubts.size(), 1u);
  EXPECT_EQ(trust.doubts[0].grade, DoubtGrade::doubt);
  EXPECT_EQ(ifc::in_words(trust.doubts[0]), "the image block: it does not fit");
}

/// Once no word said how such a survey can be used, and nothing ever passed with it.
TEST(Trust, AListOfCoordinatesIsADoubtThatSaysHowItEnds) {
  const auto of = [](const char* validity, bool without_readings, double freedom) {
    flatbuffers::FlatBufferBuilder made;
    SurveyNetworkT network;
    network.statistics = std::make_unique<StatisticsT>();
    network.statistics->degrees_of_freedom = static_cast<int>(freedom), network.statistics->sigma0 = 3;
    network.tests = std::make_unique<NetworkTestsT>();
    network.validity = validity, network.verdict = "not tested", network.without_readings = without_readings;
    made.Finish(SurveyNetwork::Pack(made, &network));
    return trust_of(nullptr, flatbuffers::GetRoot<SurveyNetwork>(made.GetBufferPointer()));
  };
  EXPECT_TRUE(of("sound", true, 0).doubts.empty());
  ASSERT_EQ(of("doubtful", true, 0).doubts.size(), 1u);
  EXPECT_EQ(of("doubtful", true, 0).doubts[0].mend, "network.with.coordinates=tested");
  ASSERT_EQ(of("doubtful", false, 0).doubts.size(), 1u);
  EXPECT_EQ(of("doubtful", false, 0).doubts[0].mend, "") << "readings that nothing controls have to be measured again";
  const Trust contradicted = of("doubtful", true, 4);
  EXPECT_TRUE(contradicted.doubts.empty());
  EXPECT_EQ(contradicted.factor, 9);
}

/// Fitted to the anchors themselves: once every anchor of a building that stood 30 mm out passed, "ready to install".
TEST(Trust, AFrameThatIsFittedToTheAnchorsIsADoubtUntilSomebodySaysWhatElseShowsIt) {
  const auto about = [](bool fitted, double sigma) {
    flatbuffers::FlatBufferBuilder made;
    TransformT transform;
    transform.origin = "fitted to 24 anchors", transform.fitted_to_design = fitted, transform.datum_sigma = sigma;
    made.Finish(Transform::Pack(made, &transform));
    const auto* packed = flatbuffers::GetRoot<Transform>(made.GetBufferPointer());
    return std::pair{doubt_of_datum(*packed), about_best_fit(*packed)};
  };
  const double nan = std::nan("");
  const auto [doubt, silent] = about(true, nan);
  ASSERT_TRUE(doubt);
  EXPECT_EQ(doubt->part, MeasurementPart::datum);
  EXPECT_EQ(doubt->grade, DoubtGrade::doubt);
  EXPECT_NE(ifc::in_words(*doubt).find("run again with \"frames.with.datum_sigma=SIGMA\""), std::string::npos);
  EXPECT_EQ(silent, "");
  EXPECT_FALSE(about(true, 0.0).first);
  EXPECT_NE(about(true, 0.0).second.find("as agreed (datum_sigma): where the whole stands is not judged"),
            std::string::npos);
  EXPECT_NE(about(true, 0.003).second.find("known to 3.0 mm"), std::string::npos);
  EXPECT_FALSE(about(false, nan).first);
  EXPECT_EQ(about(false, nan).second, "");
}

}  // namespace trust_test
}  // namespace plumbline::judgement

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

}  // namespace trust_test
}  // namespace plumbline::judgement

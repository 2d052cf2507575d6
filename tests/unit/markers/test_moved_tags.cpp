// Tags that were moved while photographs were taken, or of which two carry one number.
#include <gmock/gmock.h>

#include <functional>
#include <map>
#include <random>
#include <regex>

#include "photo/markers/marker_block.hpp"
#include "scene.hpp"
#include "test_support.hpp"

namespace plumbline::markers {
namespace test_moved_tags {

using testing::HasSubstr;

/// A scene in which `moved` tags stand elsewhere from photograph `from` on.
Scene scene_with_a_change(unsigned seed, int photographs, const std::map<int, Eigen::Vector3d>& moved,
                          const std::function<bool(int)>& changed) {
  Scene s = scene(0.2, seed, photographs);
  std::mt19937_64 random(seed + 1);
  std::normal_distribution<double> noise(0, 0.2);
  for (MarkerView& view : s.block.views) {
    const auto by = moved.find(view.marker);
    if (by == moved.end() || !changed(view.image)) continue;
    RigidTransform tag = s.tags[view.marker];
    tag.translation += by->second;
    for (size_t q = 0; q < 4; ++q)
      view.corners[q] = *project(true_camera(), s.images[view.image] * (tag * corner(0.12, q))) +
                        Eigen::Vector2d(noise(random), noise(random));
  }
  return s;
}

std::string all_of(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

/// 13 of 14 photographs of it were left out as blunders, and all that was said was that one shows it.
TEST(MarkerBlock, NamesATagThatWasMovedMeanwhileAndTheFirstPhotographAfterIt) {
  for (const double by : {0.02, 0.004}) {
    const Scene s = scene_with_a_change(5, 14, {{4, {by, 0, 0}}}, [](int image) { return image >= 8; });
    const MarkerResult result = adjust_marker_block(s.block, {});
    const std::string told = all_of(result.warnings);
    std::smatch moved;
    ASSERT_TRUE(std::regex_search(told, moved, std::regex(R"(tag 4 was moved by ([\d.]+) mm)"))) << told;
    EXPECT_NEAR(std::stod(moved[1]), 1e3 * by, 0.1e3 * by) << "the block's scale is that of tags with noise";
    EXPECT_THAT(all_of(result.warnings), HasSubstr("before image8.jpg (by the order of the names); 6 photographs"))
        << by;
    EXPECT_LT(error_of(s, result), 1e-3) << "it stands where it was before, as in most of the photographs";
    EXPECT_EQ(result.markers.size(), 12u);
  }
}

TEST(MarkerBlock, NamesANumberThatTwoTagsCarry) {
  const Scene twice = scene_with_a_change(7, 14, {{2, {0.15, 0.1, 0}}}, [](int image) { return image % 3 == 0; });
  const std::string told = all_of(adjust_marker_block(twice.block, {}).warnings);
  EXPECT_THAT(told, HasSubstr("tag 2 stands at two places 1"));
  EXPECT_THAT(told, HasSubstr("two tags carry that number"));
}

TEST(MarkerBlock, SaysNothingOfTheKindOfTagsThatStay) {
  for (unsigned seed = 50; seed < 70; ++seed) {
    Scene s = scene(0.2, seed, 14);
    for (size_t v = seed % 7; v < s.block.views.size(); v += 23) s.block.views[v].corners[0].x() += 15;  // blunders
    const std::string told = all_of(adjust_marker_block(s.block, {}).warnings);
    EXPECT_EQ(told.find("was moved"), std::string::npos) << seed << "\n" << told;
    EXPECT_EQ(told.find("two places"), std::string::npos) << seed << "\n" << told;
  }
}

/// Six tags that somebody put elsewhere between the photographs.
TEST(MarkerBlock, TagsThatStandElsewhereFromPhotographToPhotographAreSuspected) {
  Scene s = scene(0.1, 6);
  for (size_t v = 0; v < s.block.views.size(); ++v) {  // other numbers in every photograph
    MarkerView& view = s.block.views[v];
    view.marker = (view.marker * 5 + 7 * view.image) % 12;
  }
  try {
    const MarkerResult result = adjust_marker_block(s.block, {});
    EXPECT_THAT(result.warnings, testing::Contains(HasSubstr("stand elsewhere from photograph to photograph")));
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(),
                testing::AllOf(HasSubstr("10 photographs do not make one block: the tags stand elsewhere"),
                               HasSubstr(" m apart in image"), testing::Not(HasSubstr("observation "))));
  }
}

}  // namespace test_moved_tags
}  // namespace plumbline::markers

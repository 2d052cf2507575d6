// Tags whose places are known approximately, and layouts that are wrong.
#include <fmt/core.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <regex>

#include "geometry/median.hpp"
#include "photo/markers/rearranged_tags.hpp"
#include "scene.hpp"

namespace plumbline::markers {
namespace test_layouts {

using testing::HasSubstr;

template <typename Work>
std::string message_of(Work&& work) {
  try {
    work();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(MarkerBlock, LayoutOrientsEveryImageInItsFrame) {
  Scene s = scene(0.1, 5);
  for (size_t m = 0; m < s.tags.size(); ++m) s.block.markers[m].world_from_tag = s.tags[m];
  s.block.cameras[0].camera = true_camera();
  s.block.cameras[0].held = true;
  s.block.images.resize(1);
  std::erase_if(s.block.views, [](const MarkerView& v) { return v.image != 0; });
  const MarkerResult result = adjust_marker_block(s.block, {});
  ASSERT_TRUE(result.images[0].oriented);
  EXPECT_LT((result.images[0].centre - s.images[0].inverse().translation).norm(), 0.05);
}

TEST(MarkerBlock, ATagThatWasMovedDoesNotPullTheFrame) {
  Scene s = scene(0.1, 5);
  for (size_t m = 0; m < s.tags.size(); ++m) s.block.markers[m].world_from_tag = s.tags[m];
  s.block.cameras[0].camera = true_camera();
  s.block.cameras[0].held = true;
  const auto pulled_by = [&](const MarkerResult& result) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const auto& marker : result.markers)
      mean += (marker.world_from_tag.translation - s.tags[marker.marker].translation) / 12;
    return mean.norm();
  };
  MarkerBlock moved = s.block;
  moved.markers[4].world_from_tag->translation += Eigen::Vector3d(0.3, -0.4, 0);
  moved.markers[7].world_from_tag->translation.y() -= 0.2;
  const MarkerResult result = adjust_marker_block(moved, {});
  EXPECT_EQ(result.markers.size(), 12u);
  EXPECT_LT(pulled_by(result), 0.002);
  EXPECT_THAT(result.warnings, testing::Contains(HasSubstr("tag 4 is 0.50 m from its place in the layout")));
  EXPECT_THAT(result.warnings, testing::Contains(HasSubstr("tag 7 is 0.20 m from its place in the layout")));
  EXPECT_THAT(result.warnings, testing::Contains(HasSubstr("Its place in the layout takes no part")));
  // Of two, nothing says which was moved.
  MarkerBlock two = only(s, {1, 2}).block;
  two.markers[1].world_from_tag->translation.x() -= 0.5;
  const MarkerResult open = adjust_marker_block(two, {});
  EXPECT_THAT(open.warnings, testing::Contains(HasSubstr("from its place in the layout")));
  EXPECT_THAT(open.warnings, testing::Not(testing::Contains(HasSubstr("takes no part"))));
}

/// Layouts have tags in the right place and turned: by another convention of the frame, or copied from a neighbour.
TEST(MarkerBlock, ATagThatTheLayoutTurnsIsNamedAndDoesNotPullTheFrame) {
  Scene s = scene(0.1, 5);
  for (size_t m = 0; m < s.tags.size(); ++m) s.block.markers[m].world_from_tag = s.tags[m];
  s.block.cameras[0].camera = true_camera();
  s.block.cameras[0].held = true;
  const auto turned = [&](std::vector<std::pair<size_t, Eigen::AngleAxisd>> turns) {
    MarkerBlock block = s.block;
    for (const auto& [m, turn] : turns)
      block.markers[m].world_from_tag->rotation = block.markers[m].world_from_tag->rotation * Eigen::Quaterniond(turn);
    return block;
  };
  const auto x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
  const MarkerResult result =
      adjust_marker_block(turned({{1, {M_PI / 2, z}}, {4, {M_PI, z}}, {7, {0.3, y}}, {9, {M_PI, y}}}), {});
  for (const char* words :
       {"tag 1 is turned by 90 degrees about its normal", "tag 4 is turned by 180 degrees about its normal",
        "tag 7 is tilted by 17 degrees", "tag 9 is tilted by 180 degrees"})
    EXPECT_THAT(result.warnings, testing::Contains(HasSubstr(words)));
  EXPECT_EQ(result.warnings.size(), 4u);
  for (const auto& marker : result.markers) {
    const RigidTransform& truth = s.tags[marker.marker];
    EXPECT_LT((marker.world_from_tag.translation - truth.translation).norm(), 0.003) << marker.marker;
    EXPECT_LT(marker.world_from_tag.rotation.angularDistance(truth.rotation), 0.01) << marker.marker;
  }
  EXPECT_EQ(result.markers.size(), 12u);
  for (const auto& image : result.images)
    EXPECT_LT((image.centre - s.images[image.image].inverse().translation).norm(), 0.01);
  // A photograph of that tag alone is oriented by where the others have the tag.
  MarkerBlock alone = turned({{1, {M_PI / 2, z}}});
  std::erase_if(alone.views, [](const MarkerView& v) { return v.image == 0 && v.marker != 1; });
  const MarkerResult single = adjust_marker_block(alone, {});
  ASSERT_TRUE(single.images[0].oriented);
  EXPECT_LT((single.images[0].centre - s.images[0].inverse().translation).norm(), 0.05);
  // All of them: nothing says what is right.
  std::vector<std::pair<size_t, Eigen::AngleAxisd>> all;
  for (size_t m = 0; m < 12; ++m) all.push_back({m, {M_PI / 2, z}});
  EXPECT_THAT(message_of([&] { adjust_marker_block(turned(all), {}); }),
              HasSubstr("the layout turns 12 of 12 tags otherwise than the photographs show them: expected"));
  // What paper and screws do is within the layout's standard deviations.
  EXPECT_THAT(adjust_marker_block(turned({{3, {0.05, x}}, {6, {0.04, z}}}), {}).warnings, testing::IsEmpty());
}

/// What the layout tilts a tag by is shared between it and its neighbours where these are all that contradict it.
TEST(MarkerBlock, ATiltThatTwoNeighboursContradictIsNamed) {
  Scene s = scene(0.1, 5);
  for (size_t m = 0; m < s.tags.size(); ++m) s.block.markers[m].world_from_tag = s.tags[m];
  s.block.cameras[0].camera = true_camera();
  s.block.cameras[0].held = true;
  std::erase_if(s.block.views, [](const MarkerView& v) { return (v.marker >= 6 && v.marker <= 8) != (v.image <= 2); });
  EXPECT_THAT(adjust_marker_block(s.block, {}).warnings, testing::Not(testing::Contains(HasSubstr("the layout"))));
  s.block.markers[6].world_from_tag->rotation =
      s.tags[6].rotation * Eigen::Quaterniond(Eigen::AngleAxisd(8 * M_PI / 180, Eigen::Vector3d::UnitY()));
  const MarkerResult result = adjust_marker_block(s.block, {});
  EXPECT_THAT(result.warnings, testing::Contains(HasSubstr("tag 6 is tilted by 8 degrees")));
  EXPECT_THAT(result.warnings, testing::Not(testing::Contains(HasSubstr("tag 7 is tilted by"))));
  for (size_t i = 0; i < 3; ++i)
    EXPECT_LT((result.images[i].centre - s.images[i].inverse().translation).norm(), 0.06) << i;
  // Of two, nothing says which is tilted, and both keep their places.
  std::erase_if(s.block.views, [](const MarkerView& v) { return v.marker == 8; });
  EXPECT_THAT(adjust_marker_block(s.block, {}).warnings, testing::Not(testing::Contains(HasSubstr("takes no part"))));
}

TEST(MarkerBlock, NamesTagsThatAreExchangedInTheLayout) {
  Scene s = scene(0.1, 5);
  for (size_t m = 0; m < s.tags.size(); ++m) s.block.markers[m].world_from_tag = s.tags[m];
  s.block.cameras[0].camera = true_camera();
  s.block.cameras[0].held = true;
  EXPECT_THAT(adjust_marker_block(s.block, {}).warnings, testing::Not(testing::Contains(HasSubstr("layout"))));
  Scene exchanged = s;
  std::swap(exchanged.block.markers[2].world_from_tag, exchanged.block.markers[9].world_from_tag);
  EXPECT_THAT(adjust_marker_block(exchanged.block, {}).warnings,
              testing::Contains(HasSubstr("tags 2 and 9 are exchanged")));
  Scene neighbours = s;
  std::swap(neighbours.block.markers[0].world_from_tag, neighbours.block.markers[1].world_from_tag);
  EXPECT_THAT(adjust_marker_block(neighbours.block, {}).warnings,
              testing::Contains(HasSubstr("tags 0 and 1 are exchanged")));
}

/// How far apart two tags are in truth, in the photographs that show both, whatever numbers they have there.
std::map<std::pair<int, int>, std::vector<double>> true_distances(const Scene& s, const std::vector<int>& whose) {
  std::map<std::pair<int, int>, std::vector<double>> result;
  for (size_t v = 0; v < s.block.views.size(); ++v)
    for (size_t w = 0; w < s.block.views.size(); ++w) {
      const auto &a = s.block.views[v], &b = s.block.views[w];
      if (a.image == b.image && a.marker < b.marker)
        result[{a.marker, b.marker}].push_back((s.tags[whose[v]].translation - s.tags[whose[w]].translation).norm());
    }
  return result;
}

/// The same tags with other numbers in every photograph: pairs, example and figures are those of the truth.
TEST(RearrangedTags, AreToldWithTheDistancesThatChanged) {
  Scene s = scene(0.1, 6);
  EXPECT_EQ(rearranged_tags(s.block), "") << "nobody moved them";
  std::vector<int> whose;
  for (MarkerView& view : s.block.views) {
    whose.push_back(view.marker);
    view.marker = (view.marker * 5 + 7 * view.image) % 12;
  }
  int pairs = 0, moved = 0;
  double furthest = 0, least = 0, most = 0;
  for (const auto& [pair, all] : true_distances(s, whose)) {
    if (all.size() < 2) continue;
    ++pairs;
    const auto [low, high] = std::minmax_element(all.begin(), all.end());
    const double allowed = 0.25 * upper_median(all) + 0.12;
    if (*high - *low <= allowed) continue;
    ++moved;
    if ((*high - *low) / allowed > furthest) furthest = (*high - *low) / allowed, least = *low, most = *high;
  }
  ASSERT_GT(2 * moved, pairs);
  const std::string words = rearranged_tags(s.block);
  EXPECT_THAT(words, HasSubstr(fmt::format(
                         "; so do {} of {} pairs that are seen together more than once (tags 0, 1, 2,", moved, pairs)));
  std::smatch found;
  ASSERT_TRUE(std::regex_search(
      words, found,
      std::regex(R"(tags (\d+) and (\d+) are ([\d.]+) m apart in image(\d)\.jpg and ([\d.]+) m in image(\d)\.jpg)")))
      << words;
  EXPECT_NEAR(std::stod(found[3]), least, 0.05 * most) << words;
  EXPECT_NEAR(std::stod(found[5]), most, 0.05 * most) << words;
  EXPECT_NE(found[4], found[6]) << words;
}

/// Hung once more, half of the pairs are as far apart as before, or nearly so.
TEST(RearrangedTags, TwoArrangementsAreToldApartWhereTheSecondBegins) {
  Scene s = scene(0.1, 8);
  for (MarkerView& view : s.block.views)
    if (view.image >= 5) view.marker = (view.marker * 5 + 7) % 12;
  const std::string words = rearranged_tags(s.block);
  EXPECT_THAT(words, HasSubstr("the tags stand elsewhere from image5.jpg on: ")) << words;
  EXPECT_THAT(words, HasSubstr("A folder for each arrangement")) << words;
}

/// One tag that all pairs which moved have in common is named, and not the arrangement.
TEST(RearrangedTags, OneThatWasMovedIsNotAll) {
  Scene s = scene(0.1, 6);
  for (MarkerView& view : s.block.views)
    if (view.image % 2 == 1 && (view.marker == 0 || view.marker == 11)) view.marker = 11 - view.marker;
  EXPECT_EQ(rearranged_tags(s.block).find("tag 11 stands elsewhere from photograph to photograph"), 0u);
  EXPECT_EQ(rearranged_tags(only(s, {0, 5}).block), "") << "of one pair there is nothing to compare";
}

}  // namespace test_layouts
}  // namespace plumbline::markers

// A photograph from AprilRobotics' own tests, with the corners that they publish for it; photographs of a field of the
// FIRST Robotics Competition, whose tags are 1 to 16.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>

#include "photo/detect/tag_detector.hpp"
#include "photo/detect/tag_pyramid.hpp"
#include "photo/images/grey_image.hpp"
#include "test_support.hpp"

namespace plumbline {
namespace test_photograph {

struct Published {
  int id = 0;
  std::vector<Eigen::Vector2d> corners;  // first pixel's centre at (0.5, 0.5) [px]
};

std::vector<Published> read_published(const std::filesystem::path& path) {
  std::vector<Published> tags;
  std::ifstream stream(path);
  const std::regex pair(R"(\(([0-9.]+) ([0-9.]+)\))");
  for (std::string line; std::getline(stream, line);) {
    Published tag;
    tag.id = std::stoi(line);
    for (std::sregex_iterator it(line.begin(), line.end(), pair), end; it != end; ++it)
      tag.corners.emplace_back(std::stod((*it)[1]), std::stod((*it)[2]));
    tags.push_back(tag);
  }
  return tags;
}

/// Largest distance between corresponding corners, over all tags: every published tag must be there, its corners in the
/// published order.
double largest_difference(const std::vector<detect::DetectedTag>& found, const std::vector<Published>& published) {
  double largest = 0;
  for (const Published& tag : published) {
    double best = 1e9;
    for (const auto& candidate : found) {
      double difference = candidate.id == tag.id ? 0 : 1e9;
      for (std::size_t i = 0; i < 4; ++i)
        difference = std::max(difference, (candidate.corners[i] + Eigen::Vector2d(0.5, 0.5) - tag.corners[i]).norm());
      best = std::min(best, difference);
    }
    largest = std::max(largest, best);
  }
  return largest;
}

class Photograph : public testing::Test {
 protected:
  const std::string name = "images/apriltag/33369213973_9d9bb4cc96_c";
  std::vector<detect::DetectedTag> detect_with(detect::Refinement refinement) {
    detect::DetectorOptions options;
    options.refinement = refinement;
    return detect::TagDetector(options).detect(read_grey_image(test::data_file(name + ".jpg")));
  }
};

TEST_F(Photograph, HoldsThePublishedTags) {
  PLUMBLINE_REQUIRE_DATA(name + ".txt");
  const auto published = read_published(test::data_file(name + ".txt"));
  ASSERT_EQ(published.size(), 12u);
  const auto found = detect_with(detect::Refinement::apriltag);
  EXPECT_EQ(found.size(), 12u);
  // Published by another version of the library with other settings: it agrees with itself to a pixel, no better.
  EXPECT_LT(largest_difference(found, published), 1.0);
}

TEST_F(Photograph, RefinementMovesCornersByLessThanThePublishedOnesScatter) {
  PLUMBLINE_REQUIRE_DATA(name + ".txt");
  const auto published = read_published(test::data_file(name + ".txt"));
  const auto found = detect_with(detect::Refinement::edges);
  EXPECT_LT(largest_difference(found, published), 1.2);
  int refined = 0;
  for (const auto& tag : found) refined += tag.refined;
  EXPECT_GE(refined, 6);  // the others' cells are below 3.5 px wide, or foreshortened to 1.5 px
}

/// Ids of one photograph of the field.
std::vector<int> ids_on_the_field(const std::string& name, const std::string& family = "tag36h11") {
  const detect::TagPyramid detector({detect::square_family(family)}, {});
  std::vector<int> ids;
  for (const auto& tag : detector.detect(read_grey_image(test::data_file("images/field2024/" + name))).tags)
    ids.push_back(tag.id);
  return ids;
}

TEST(Field, ATagWhoseWhiteIsOverexposedIsRead) {
  PLUMBLINE_REQUIRE_DATA("images/field2024/GeneralField4.jpg");
  const std::vector<int> ids = ids_on_the_field("GeneralField4.jpg");
  EXPECT_EQ(std::count(ids.begin(), ids.end(), 6), 1);
}

TEST(Field, OverexposedWhiteIsNoTagOfAnotherFamily) {
  PLUMBLINE_REQUIRE_DATA("images/field2024");
  int photographs = 0;
  for (const auto& entry : std::filesystem::directory_iterator(test::data_file("images/field2024"))) {
    if (entry.path().extension() != ".jpg") continue;
    const std::string name = entry.path().filename().string();
    ++photographs;
    for (const int id : ids_on_the_field(name)) EXPECT_TRUE(id >= 1 && id <= 16) << name << ": " << id;
    for (const char* other : {"tag25h9", "tag16h5"})
      EXPECT_TRUE(ids_on_the_field(name, other).empty()) << name << other;
  }
  EXPECT_EQ(photographs, 15);
}

}  // namespace test_photograph
}  // namespace plumbline

// The detector for large images: its search in reduced levels, its decoding, and the window of rows it works in.
#include <gmock/gmock.h>

#include <algorithm>
#include <random>

#include "photo/detect/level_search.hpp"
#include "photo/detect/tag_pyramid.hpp"
#include "tag_rendering.hpp"

namespace plumbline::detect {
namespace test_pyramid {

using testing::IsEmpty;
using testing::SizeIs;

/// A white image to paint on.
GreyImage white(int width, int height) {
  return {width, height,
          std::vector<std::uint8_t>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 200)};
}

void paint(GreyImage& on, const GreyImage& part, int left, int top) {
  for (int y = 0; y < part.height; ++y)
    for (int x = 0; x < part.width; ++x) on.pixels[(top + y) * on.width + left + x] = part.pixels[y * part.width + x];
}

/// A tag rendered small and enlarged by whole pixels: cheap at any size. Its border begins at (left + margin, top +
/// margin).
GreyImage enlarged_tag(int id, int cell) {
  test::TagScene scene;
  scene.id = id;
  scene.width = scene.height = 14;
  scene.blur = 0;
  scene.black = 30, scene.white = 200;
  scene.corners = {{{2.5, 10.5}, {10.5, 10.5}, {10.5, 2.5}, {2.5, 2.5}}};
  const GreyImage small = render(scene);
  GreyImage large = white(14 * cell, 14 * cell);
  for (int y = 0; y < large.height; ++y)
    for (int x = 0; x < large.width; ++x) large.pixels[y * large.width + x] = small.pixels[y / cell * 14 + x / cell];
  return large;
}

struct Searched {
  PyramidResult result;
  int parts_read = 0;
};

Searched detect_in(const GreyImage& image, const PyramidOptions& options = {}, const std::string& family = "tag36h11") {
  Searched run;
  const auto rows = rows_of(image);
  const TagPyramid detector({square_family(family)}, options);
  run.result = detector.detect(*rows, [&](int left, int top, int width, int height) {
    ++run.parts_read;
    return part_of(image, left, top, width, height);
  });
  return run;
}

std::vector<LevelQuad> quads_in(const GreyImage& image) {
  LevelSearch search(image.width, image.height, image.height, {});
  Outlines found;
  for (int y = 0; y < image.height; ++y) {
    search.add_row(&image.pixels[y * image.width]);
    search.follow(search.known_rows() - 30, found);
  }
  search.follow(image.height, found);
  for (const auto& first : found.unfinished) search.follow_again(first, found);
  return found.quads;
}

TEST(LevelSearch, FindsASquareOfTwelvePixelsAndItsCorners) {
  for (const double angle : {0.0, 0.2, 0.5, 0.785}) {
    GreyImage image = white(61, 47);
    const Eigen::Vector2d centre(30.3, 22.6), along(std::cos(angle), std::sin(angle)), across(-along.y(), along.x());
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        const Eigen::Vector2d d = Eigen::Vector2d(x, y) - centre;
        if (std::abs(d.dot(along)) < 6 && std::abs(d.dot(across)) < 6) image.pixels[y * 61 + x] = 40;
      }
    const auto quads = quads_in(image);
    ASSERT_THAT(quads, SizeIs(1)) << angle;
    for (const double i : {-6.0, 6.0})
      for (const double j : {-6.0, 6.0}) {
        // Corners count from the corner of the first pixel here.
        const Eigen::Vector2d corner = centre + i * along + j * across + Eigen::Vector2d(0.5, 0.5);
        double nearest = 1e9;
        for (const auto& c : quads[0].corners) nearest = std::min(nearest, (c - corner).norm());
        EXPECT_LT(nearest, 0.9) << angle;
      }
  }
}

TEST(LevelSearch, TakesNeitherDiscsNorSquaresWithoutContrast) {
  GreyImage image = white(200, 100);
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 200; ++x) {
      std::uint8_t& pixel = image.pixels[y * 200 + x];
      if (std::hypot(x - 50, y - 50) < 20) pixel = 40;          // a disc
      if (x > 100 && x < 130 && y > 30 && y < 60) pixel = 190;  // hardly darker
    }
  EXPECT_THAT(quads_in(image), IsEmpty());
}

/// Two squares that touch at a corner, as on a chessboard, are two.
TEST(LevelSearch, ParsTwoSquaresThatTouchAtACorner) {
  GreyImage image = white(80, 80);
  for (int y = 20; y < 60; ++y)
    for (int x = 20; x < 60; ++x)
      if ((x < 40) == (y < 40)) image.pixels[y * 80 + x] = 40;
  EXPECT_THAT(quads_in(image), SizeIs(2));
}

TEST(TagPyramid, MeasuresTheSameCornersAsTheOtherDetectors) {
  test::TagScene scene;
  scene.width = scene.height = 160;
  scene.noise = 1;
  scene.corners = test::square_corners({80.3, 79.6}, 90, 0.4, 0.5);
  const GreyImage image = render(scene);
  for (const double smallest : {12.0, 24.0}) {
    PyramidOptions options;
    options.smallest_tag = smallest;
    const auto found = detect_in(image, options).result.tags;
    ASSERT_THAT(found, SizeIs(1));
    TagDetector reference{DetectorOptions{}};
    const auto same = reference.detect(image);
    ASSERT_THAT(same, SizeIs(1));
    EXPECT_EQ(found[0].id, same[0].id);
    EXPECT_TRUE(found[0].refined);
    for (int i = 0; i < 4; ++i) {
      EXPECT_LT((found[0].corners[i] - same[0].corners[i]).norm(), 0.01);
      EXPECT_NEAR(found[0].covariances[i](0, 0) / same[0].covariances[i](0, 0), 1, 0.1);
    }
  }
}

/// A photograph in little light, whose cells are 12 to 20 grey values from their threshold: five of 224 tags in a room
/// that libapriltag reads, as it sharpens first, were dropped for it.
TEST(TagPyramid, ReadsTagsOfLittleContrast) {
  for (const double size : {36.0, 48.0, 90.0}) {
    test::TagScene scene;
    scene.width = scene.height = 160;
    scene.noise = 1, scene.black = 20, scene.white = 58, scene.blur = 0.8;
    scene.corners = test::square_corners({80.3, 79.6}, size, 0.2, 0.3);
    const auto found = detect_in(render(scene)).result.tags;
    ASSERT_THAT(found, SizeIs(1)) << size;
    EXPECT_EQ(found[0].id, scene.id);
    EXPECT_LT(found[0].decision_margin, 25) << "the case shows nothing";
  }
}

TEST(TagPyramid, FindsTagsOfEverySizeInClutterThoughOnlyEverySecondPixelIsSearched) {
  GreyImage image = white(1400, 1000);
  std::mt19937 random(5);
  for (auto& pixel : image.pixels) pixel = static_cast<std::uint8_t>(170 + random() % 9);
  for (int y = 0; y < 1000; ++y)  // brick
    for (int x = 0; x < 1400; ++x)
      if (y % 20 > 3 && (x + y / 20 % 2 * 30) % 60 > 3)
        image.pixels[y * 1400 + x] = static_cast<std::uint8_t>(80 + random() % 9);
  int id = 0, left = 20;
  for (const int size : {24, 28, 36, 50, 80, 130, 260}) {
    test::TagScene scene;
    scene.id = id++;
    scene.width = scene.height = static_cast<int>(1.9 * size);
    scene.noise = 2;
    const double middle = 0.5 * scene.width;
    // A white edge of a cell, as it is printed, then brick.
    scene.corners = test::square_corners({middle, middle}, size, 0.3 * id);
    const GreyImage tag = render(scene);
    const double edge = size * 10.0 / 16;
    for (int y = 0; y < tag.height; ++y)
      for (int x = 0; x < tag.width; ++x) {
        const Eigen::Vector2d d(x - middle, middle - y);
        const double a = 0.3 * id, u = d.x() * std::cos(a) + d.y() * std::sin(a),
                     v = -d.x() * std::sin(a) + d.y() * std::cos(a);
        if (std::max(std::abs(u), std::abs(v)) < edge)
          image.pixels[(50 + 3 * size / 2 + y) * 1400 + left + x] = tag.pixels[y * tag.width + x];
      }
    left += 3 * size / 2 + 20;
  }
  PyramidOptions options;
  options.smallest_tag = 24;
  const auto found = detect_in(image, options).result.tags;
  std::vector<int> ids;
  for (const auto& tag : found) ids.push_back(tag.id);
  EXPECT_THAT(ids, testing::ElementsAre(0, 1, 2, 3, 4, 5, 6));
}

/// A tag taller than the window of rows is read in a second pass, one that fits is not, and both are measured.
TEST(TagPyramid, ReadsATagThatIsTallerThanItsWindowAgain) {
  GreyImage image = white(1960, 4000);
  paint(image, enlarged_tag(3, 140), 0, 2000);  // 1120 px of 1200
  paint(image, enlarged_tag(4, 40), 500, 700);  // 320 px
  const Searched run = detect_in(image);
  ASSERT_THAT(run.result.tags, SizeIs(2));
  EXPECT_EQ(run.parts_read, 1);
  EXPECT_LT((run.result.tags[0].corners[3] - Eigen::Vector2d(3 * 140 - 0.5, 2000 + 3 * 140 - 0.5)).norm(), 0.1);
  EXPECT_LT((run.result.tags[1].corners[3] - Eigen::Vector2d(500 + 3 * 40 - 0.5, 700 + 3 * 40 - 0.5)).norm(), 0.1);
}

TEST(TagPyramid, ReadsFamiliesThatAreBrightInsideAndOpenCvsDictionaries) {
  for (const std::string family : {"tagStandard41h12", "tag16h5", "tag25h9", "tagCircle21h7"}) {
    test::TagScene scene;
    scene.family = family;
    scene.width = scene.height = 220;
    scene.corners = test::square_corners({110, 110}, 80, 0.3);
    const auto found = detect_in(render(scene), {}, family).result.tags;
    ASSERT_THAT(found, SizeIs(1)) << family;
    EXPECT_EQ(found[0].id, 7);
    for (int i = 0; i < 4; ++i) EXPECT_LT((found[0].corners[i] - scene.corners[i]).norm(), 0.1) << family;
  }
  // The same drawing by OpenCV's copy of the family, which is turned by half a turn.
  EXPECT_EQ(square_family("DICT_APRILTAG_36h11").cells.size(), 36u);
  EXPECT_EQ(square_family("DICT_4X4_50").codes.size(), 50u);
  EXPECT_THROW(square_family("DICT_3X3"), std::runtime_error);
}

TEST(TagPyramid, SaysThatAPhotographIsMirroredAndCorrectsNoMoreThanItIsTold) {
  test::TagScene scene;
  scene.corners = test::square_corners({100, 100}, 96, 0);
  GreyImage image = render(scene);
  GreyImage mirror = image;
  for (int y = 0; y < mirror.height; ++y)
    std::reverse(mirror.pixels.begin() + y * mirror.width, mirror.pixels.begin() + (y + 1) * mirror.width);
  const PyramidResult seen = detect_in(mirror).result;
  EXPECT_THAT(seen.tags, IsEmpty());
  EXPECT_TRUE(seen.mirrored);

  // One cell of the code inverted: the second from the left in the first row of it.
  for (int y = 65; y < 75; ++y)
    for (int x = 77; x < 87; ++x) {
      std::uint8_t& pixel = image.pixels[y * 200 + x];
      pixel = static_cast<std::uint8_t>(230 - pixel);
    }
  const auto corrected = detect_in(image).result.tags;
  ASSERT_THAT(corrected, SizeIs(1));
  EXPECT_EQ(corrected[0].hamming, 1);
  PyramidOptions strict;
  strict.max_hamming = 0;
  EXPECT_THAT(detect_in(image, strict).result.tags, IsEmpty());
}

/// Tags of 4 x 4 cells, some of which are read as 3 x 3.
TEST(TagPyramid, LeavesOutWhatDoesNotLookLikeItsTag) {
  const SquareFamily weak = square_family("DICT_3X3_32");
  const SquareDecoder decoder(weak, 0);
  int read = 0;
  for (int id = 0; id < 30; id += 2) {
    test::TagScene scene;
    scene.family = "tag16h5";
    scene.id = id;
    scene.corners = test::square_corners({100, 100}, 72, 0);
    const GreyImage image = render(scene);
    std::vector<const std::uint8_t*> rows;
    for (int y = 0; y < image.height; ++y) rows.push_back(&image.pixels[y * image.width]);
    const auto& c = scene.corners;
    read += decoder.read({0, 200, 0, 200, rows.data()}, {c[3], c[2], c[1], c[0]}).code.has_value();
    EXPECT_THAT(detect_in(image, {}, "DICT_3X3_32").result.tags, IsEmpty()) << id;
  }
  EXPECT_GT(read, 0);
}

/// The code of a tag whose corner is just outside of the image can be read; its corners are marked as not measured.
TEST(TagPyramid, MarksATagThatTheBorderCuts) {
  test::TagScene scene;
  scene.corners = test::square_corners({41, 100}, 80, 0.1);  // the lower left corner at x = -2.8
  const auto found = detect_in(render(scene)).result.tags;
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_FALSE(found[0].refined);
  for (int i = 0; i < 4; ++i) {
    EXPECT_LT((found[0].corners[i] - scene.corners[i]).norm(), 1);
    EXPECT_GE(found[0].covariances[i](0, 0), 1);
  }
}

TEST(TagPyramid, FindsNothingInTinyEmptyOrNoisyImages) {
  EXPECT_THAT(detect_in(white(10, 10)).result.tags, IsEmpty());
  EXPECT_THAT(detect_in(white(100, 17)).result.tags, IsEmpty());
  GreyImage noise = white(801, 603);
  std::mt19937 random(3);
  for (auto& pixel : noise.pixels) pixel = static_cast<std::uint8_t>(random());
  EXPECT_THAT(detect_in(noise).result.tags, IsEmpty());
}

}  // namespace test_pyramid
}  // namespace plumbline::detect

// Which photographs are one camera's, in every case, with the words that are said of the others.
#include <gmock/gmock.h>

#include "see/markers/photograph_groups.hpp"

namespace plumbline::markers {
namespace test_photograph_groups {

using testing::ElementsAre;
using testing::HasSubstr;

struct Photograph {
  std::string path, model = "", serial = "";
  int width = 1600, height = 1200;
  double focal_length = 0.024, principal_distance = std::nan("");
};

struct Photographs {
  std::vector<ImageT> images;
  TagObservationsT observations;
  std::vector<bool> use;
  BlockInput input;

  explicit Photographs(const std::vector<Photograph>& all) {
    for (const Photograph& p : all) {
      ImageT image;
      image.path = p.path, image.model = p.model, image.serial = p.serial;
      image.focal_length = p.focal_length, image.principal_distance = p.principal_distance;
      images.push_back(image);
      observations.images.push_back(std::make_unique<ImageTagsT>());
      observations.images.back()->path = p.path;
      observations.images.back()->width = p.width, observations.images.back()->height = p.height;
      use.push_back(true);
    }
  }
  std::vector<CameraGroup> groups(const std::string& by = "by_folder") const {
    return groups_of(images, observations, use, by);
  }
  std::vector<std::string> left_out() const {
    std::vector<std::string> all;
    for (const LeftOut& each : input.left_out) all.push_back(each.path + " " + each.reason);
    return all;
  }
};

TEST(PhotographGroups, SizeModelAndFocalLengthTellCamerasApartAndSerialsWhereThereAreSeveral) {
  Photographs p({{"a.jpg", "M", "1", 1600, 1200, 0.024},
                 {"b.jpg", "M", "", 1600, 1200, 0.024},
                 {"c.jpg", "M", "", 1200, 1600, 0.024},
                 {"d.jpg", "M", "", 1600, 1200, 0.035},
                 {"e.jpg", "N", "", 1600, 1200, 0.024},
                 {"s/f.jpg", "M", "1", 1600, 1200, 0.024, 2000}});
  ASSERT_EQ(p.groups().size(), 5u);
  EXPECT_THAT(p.groups()[0].images, ElementsAre(0u, 1u)) << "a lost serial number is no other body";
  EXPECT_EQ(p.groups()[0].key.serial, "");
  EXPECT_EQ(p.groups()[4].key.folder, "s");
  EXPECT_EQ(p.groups()[4].principal_distance, 2000);
  p.images[1].serial = "2";
  ASSERT_EQ(p.groups().size(), 6u);
  EXPECT_EQ(p.groups()[1].key.serial, "2");
  p.use[1] = false;  // what takes no part tells nothing of the bodies
  EXPECT_EQ(p.groups().size(), 5u);
}

TEST(PhotographGroups, SmallGroupsBesideALargeOneAreLeftOutWithTheirReason) {
  const std::string program = ": a program turned its pixels. Use the file as the camera wrote it";
  const std::string resized =
      ": it was resized, cropped or taken by another camera, and too few are like it to calibrate that one";
  std::vector<Photograph> all{{"1", "M"},
                              {"2", "M"},
                              {"3", "M"},
                              {"t1", "M", "", 1200, 1600},
                              {"t2", "M", "", 1200, 1600},
                              {"w", "M", "", 1600, 1100},
                              {"h", "M", "", 1500, 1200},
                              {"f", "M", "", 1600, 1200, 0.0354},
                              {"n", "", "", 1600, 1200, 0}};
  Photographs p(all);
  auto groups = p.groups();
  drop_odd_groups(groups, p.observations, p.input);
  ASSERT_EQ(groups.size(), 1u);
  EXPECT_THAT(p.left_out(),
              ElementsAre("t1 has 1200 x 1600 pixels where the others have 1600 x 1200" + program,
                          "t2 has 1200 x 1600 pixels where the others have 1600 x 1200" + program,
                          "w has 1600 x 1100 pixels where the others have 1600 x 1200" + resized,
                          "h has 1500 x 1200 pixels where the others have 1600 x 1200" + resized,
                          "f was taken with another camera or focal length (M, 35 mm) than the others, and too few are "
                          "like it to calibrate it",
                          "n was taken with another camera or focal length (no EXIF) than the others, and too few are "
                          "like it to calibrate it"));
  // Three are enough for a camera of their own; without a large group nothing is odd.
  all.push_back({"t3", "M", "", 1200, 1600});
  Photographs three(all);
  groups = three.groups();
  drop_odd_groups(groups, three.observations, three.input);
  EXPECT_EQ(groups.size(), 2u);
  Photographs two({{"1", "M"}, {"2", "M"}, {"t1", "M", "", 1200, 1600}});
  groups = two.groups();
  drop_odd_groups(groups, two.observations, two.input);
  EXPECT_EQ(groups.size(), 2u);
  EXPECT_TRUE(two.input.left_out.empty());
  // Of another folder nothing is said.
  Photographs apart({{"1", "M"}, {"2", "M"}, {"3", "M"}, {"s/1", "M", "", 1200, 1600}});
  groups = apart.groups();
  drop_odd_groups(groups, apart.observations, apart.input);
  EXPECT_EQ(groups.size(), 2u);
}

TEST(PhotographGroups, SeveralSizesOfOneBodyAreSaid) {
  const auto said = [](const std::vector<Photograph>& all) { return words_of_sizes(Photographs(all).groups()); };
  const auto words = said({{"1", "M"},
                           {"2", "M"},
                           {"3", "M", "", 800, 600},
                           {"4", "M", "", 800, 600, 0.035},  // another zoom of the same size
                           {"5", "M", "", 1600, 900},
                           {"6", "M", "", 1200, 1600}});
  ASSERT_EQ(words.size(), 1u);
  EXPECT_THAT(words.front(), HasSubstr("several sizes (2 of 1600 x 1200 pixels; 2 of 800 x 600 pixels; 1 of 1600 x 900 "
                                       "pixels; 1 of 1200 x 1600 pixels): some were resized, cropped or turned"));
  // Another body or folder, and another zoom, are something else.
  EXPECT_TRUE(said({{"1", "M"}, {"2", "N", "", 800, 600}}).empty());
  EXPECT_TRUE(said({{"1", "M"}, {"s/2", "M", "", 800, 600}}).empty());
  EXPECT_TRUE(said({{"1", "M"}, {"2", "M", "", 1600, 1200, 0.035}}).empty());
}

TEST(PhotographGroups, OneCalibrationIsOfOneBody) {
  CameraT known;
  known.id = "left";
  const std::vector<Photograph> three{{"1", "M", "7"}, {"2", "M", "7"}, {"3", "M", "7"}};
  const auto with = [&](std::vector<Photograph> others) {
    others.insert(others.begin(), three.begin(), three.end());
    return Photographs(others);
  };
  Photographs few = with({{"4", "N", "", 1600, 1200, 0}, {"5", "", ""}, {"6", "M", "8"}});
  drop_other_bodies(few.groups(), known, few.observations, few.use, few.input);
  const std::string of_one =
      ") than the others (M 7, 24 mm), and the calibration 'left' is of one; cameras=one says that it is one camera "
      "all "
      "the same";
  EXPECT_THAT(few.left_out(), ElementsAre("4 was taken with another camera or focal length (N" + of_one,
                                          "6 was taken with another camera or focal length (M 8, 24 mm" + of_one));
  EXPECT_THAT(few.use, ElementsAre(true, true, true, false, true, false))
      << "without EXIF it is taken for the camera's";
  const auto refusal = [&](Photographs p) -> std::string {
    try {
      drop_other_bodies(p.groups(), known, p.observations, p.use, p.input);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  // Three of another body, or two of each: nobody can tell whose the calibration is.
  EXPECT_EQ(refusal(with({{"4", "N"}, {"5", "N"}, {"6", "N"}, {"7", "O"}})),
            "the calibration is of one camera, 'left', and by their EXIF the photographs are of 3: M, 24 mm (3 "
            "photographs); N, 24 mm (3 photographs); O, 24 mm (1 photograph). Give a folder and a calibration to each "
            "(docs/photographs.md), or no calibration at all; cameras=one says that it is one camera all the same");
  EXPECT_EQ(refusal(with({{"4", "N"}, {"5", "N"}})), "");
  EXPECT_THAT(refusal(Photographs({{"1", "M"}, {"2", "M"}, {"3", "N"}})), HasSubstr("are of 2"));
  EXPECT_EQ(refusal(Photographs({{"1", "M"}, {"2", "M"}})), "");
}

TEST(PhotographGroups, CamerasStartFromExifAndHaveNamesOfTheirOwn) {
  Photographs p({{"1", "M", "", 1600, 1200, 0.024, 3000},
                 {"2", "", "", 1600, 1200, 0},
                 {"3", "", "", 800, 600, 0},
                 {"s/4", "M", "", 1600, 1200, 0, 3000},
                 {"5", "N", "7", 1600, 1200},
                 {"6", "N", "8", 1600, 1200}});
  const auto cameras = cameras_of_groups(p.groups());
  ASSERT_EQ(cameras.size(), 6u);
  std::vector<std::string> names;
  for (const MarkerCamera& camera : cameras) names.push_back(camera.id);
  EXPECT_THAT(names, ElementsAre("M", "camera 1", "camera 2", "s", "N 7", "N 8"));
  EXPECT_EQ(cameras[0].source, "self-calibration, started from EXIF");
  EXPECT_EQ(cameras[0].camera.fx, 3000);
  EXPECT_EQ(cameras[0].camera.fy, 3000);
  EXPECT_EQ(cameras[0].camera.cx, 799.5);
  EXPECT_EQ(cameras[0].camera.cy, 599.5);
  EXPECT_DOUBLE_EQ(cameras[0].pixel_pitch, 8e-6);
  EXPECT_EQ(cameras[1].source, "self-calibration, started from the shapes of the tags");
  EXPECT_EQ(cameras[2].camera.width, 800);
  EXPECT_EQ(cameras[2].camera.height, 600);
  EXPECT_FALSE(cameras[3].pixel_pitch > 0) << "EXIF does not say the focal length";
}

}  // namespace test_photograph_groups
}  // namespace plumbline::markers

// What is said of changes of a camera and of scatter, each of their kinds.
#include <gmock/gmock.h>

#include "base/text/name_order.hpp"
#include "scene.hpp"

namespace plumbline::markers {
namespace test_camera_change_words {

using testing::HasSubstr;

TEST(Names, AreSortedByTheirNumbers) {
  EXPECT_TRUE(text::before_by_name("2.jpg", "10.jpg"));
  EXPECT_FALSE(text::before_by_name("10.jpg", "2.jpg"));
  EXPECT_TRUE(text::before_by_name("a/IMG_009.JPG", "a/IMG_0010.JPG"));
  EXPECT_TRUE(text::before_by_name("a1", "a1b"));
  EXPECT_FALSE(text::before_by_name("x", "x"));
  EXPECT_TRUE(text::before_by_name("IMG_1a.jpg", "IMG_02.jpg")) << "a number ends where its digits do";
  EXPECT_FALSE(text::before_by_name("a10_2b.jpg", "a010_1.jpg"));
}

const std::string kNoCause =
    ". None of the causes that are tried stands out; tags or a board that are bent, and photographs of which a program "
    "enlarged some, are not among them";

/// What hides in the scatter is said: silence would claim that nothing changed.
TEST(CameraChanges, WhatCannotBeToldIsSaid) {
  CameraTruth truth;
  truth.focal_length = 1000;
  truth.evidence.parameters = {0, 1};
  truth.empirical.judged = true, truth.empirical.photographs = 14, truth.empirical.factor = 1;
  truth.empirical.written = Eigen::Vector2d(2 * 2, 5 * 5).asDiagonal();
  EXPECT_NEAR(hidden_focus_change(truth), 8 * 0.002, 1e-12);
  EXPECT_THAT(warnings_of(truth), testing::IsEmpty()) << "1.6 % is not worth a warning of its own";
  truth.empirical.written(0, 0) = 5 * 5;
  EXPECT_THAT(warnings_of(truth),
              testing::ElementsAre("the photographs do not tell whether focus or zoom changed among them by less than "
                                   "about 4 %"));
  truth.empirical.factor = 4;
  ASSERT_EQ(warnings_of(truth).size(), 1u);
  EXPECT_THAT(warnings_of(truth)[0], testing::AllOf(testing::HasSubstr("scatter 4.0 times"),
                                                    testing::HasSubstr("less than about 4 % is hidden by it")));
  truth.empirical.judged = false;
  EXPECT_EQ(hidden_focus_change(truth), 0);
  EXPECT_THAT(warnings_of(truth), testing::IsEmpty()) << "calibrations say that 14 are too few";
  truth.empirical.photographs = 2, truth.empirical.factor = 1;
  EXPECT_THAT(warnings_of(truth),
              testing::ElementsAre(testing::HasSubstr("how two photographs scatter cannot be told")));
  truth.evidence.parameters.clear();
  EXPECT_THAT(warnings_of(truth), testing::IsEmpty()) << "a camera that is given";
}

/// Every cause and every split in words, each by itself.
TEST(CameraChanges, EveryChangeHasItsWords) {
  using Split = CameraChange::Split;
  using What = CameraChange::What;
  CameraEvidence evidence;
  for (const char* name : {"a1", "a2", "a3", "a4", "a5", "a6", "a7", "a8", "a9", "b"}) evidence.paths.push_back(name);
  CameraChange change;
  change.second = {3, 4, 5, 6};
  change.split_is_clear = change.what_is_clear = true;
  const auto vector = [](std::vector<double> v) -> Eigen::VectorXd {
    return Eigen::Map<Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(v.size()));
  };
  const auto said = [&](What what, std::vector<double> by, std::vector<double> sigma, bool sized) {
    change.what = what, change.by = vector(by), change.sigma = vector(sigma), evidence.object_is_known = sized;
    return in_words(change, evidence);
  };
  const std::string from = "from a4 on ", lies = from + "the principal point lies elsewhere";
  EXPECT_EQ(said(What::focus, {0.0201}, {0.0005}, true),
            from + "the principal distance is 2.01 ± 0.05 % longer: focus or zoom");
  EXPECT_EQ(said(What::focus, {-0.0201}, {0.0005}, true),
            from + "the principal distance is 2.01 ± 0.05 % shorter: focus or zoom");
  EXPECT_EQ(said(What::focus, {0.0201}, {0.0005}, false), from + "the principal distance is longer: focus or zoom");
  EXPECT_EQ(said(What::aspect, {-0.03}, {0.001}, true),
            from + "fx is 3.00 ± 0.10 % shorter against fy: pictures that a program stretched");
  EXPECT_EQ(said(What::principal_point, {12.34, -5.68}, {1.24, 0.96}, true),
            lies +
                " by 12.3 ± 1.2, -5.7 ± 1.0 px: pictures that a program cropped or moved, a stabiliser, or a board "
                "that was bent otherwise");
  EXPECT_EQ(said(What::principal_point, {12.34, -5.68}, {1.24, 0.96}, false),
            lies + ": pictures that a program cropped or moved, a stabiliser, or a board that was bent otherwise");
  change.or_mirrored = true;
  EXPECT_EQ(said(What::principal_point, {12.34, -0.68}, {1.24, 0.96}, true),
            lies +
                " by 12.3 ± 1.2, -0.7 ± 1.0 px: pictures that a program mirrored, cropped or moved, a stabiliser, or a "
                "board that was bent otherwise");
  change.or_mirrored = false, change.or_turned = true;
  EXPECT_EQ(said(What::principal_point, {12.34, -5.68}, {1.24, 0.96}, false),
            lies +
                ": pictures that a program turned by 180 degrees, cropped or moved, a stabiliser, or a board that was "
                "bent otherwise");
  change.or_turned = false;
  EXPECT_EQ(said(What::distortion, {-0.0214, 0.5}, {0.0032, 0.1}, true),
            from +
                "the distortion is another (k1 by -0.021 ± 0.003): another lens or setting of it, pictures that a "
                "program changed, or a board that was bent otherwise");
  EXPECT_EQ(said(What::undistorted, {0.1}, {0.01}, true),
            from + "the distortion is gone: pictures that a program freed of it");
  EXPECT_EQ(said(What::turned, {1, 2}, {0.5, 0.25}, true),
            lies + " by 1.0 ± 0.5, 2.0 ± 0.2 px: pictures that a program turned by 180 degrees");
  const std::string other = ": another body or lens, a zoom, or pictures that a program changed";
  // Three standard deviations, of each; the second of a pair counts as the first does.
  const std::vector<double> ones{0.01, 1, 1, 0.01, 0.01};
  EXPECT_EQ(said(What::several, {0.029, 2.9, 2.9, 0.029, 0.029}, ones, true), from + "the camera is another" + other);
  EXPECT_EQ(said(What::several, {0.031, 0, 3.1, 0, 0.031}, ones, true),
            from +
                "the camera is another (principal distance 3.10 ± 1.00 % longer, principal point elsewhere by 0.0 ± "
                "1.0, 3.1 ± 1.0 px, another distortion (k1 by +0.000 ± 0.010))" +
                other);
  EXPECT_EQ(said(What::several, {0, -3.1, 0, -0.031, 0}, ones, false),
            from + "the camera is another (principal point elsewhere, another distortion)" + other);

  const auto split = [&](Split which, int period) {
    change.split = which, change.period = period;
    const std::string all = said(What::undistorted, {0.1}, {0.01}, true);
    return all.substr(0, all.find(" the distortion"));
  };
  const std::string list = " (a4, a5, a6, a7)";
  EXPECT_EQ(split(Split::drift, 0), "from a1 to b, bit by bit,");
  EXPECT_EQ(split(Split::every, 2), "in every second photograph" + list);
  EXPECT_EQ(split(Split::every, 3), "in every third photograph" + list);
  EXPECT_EQ(split(Split::every, 4), "in every fourth photograph" + list);
  EXPECT_EQ(split(Split::some, 0), "in 4 photographs" + list);
  change.second.push_back(8);
  EXPECT_EQ(split(Split::some, 0), "in 5 photographs (a4, a5, a6, a7 and 1 more)");
  change.second = {1, 2, 3, 6};
  EXPECT_EQ(split(Split::stretches, 0), "from a2 to a4 and in a7");
  change.second = {3, 4, 5, 6, 8};
  change.split = Split::upside_down;
  EXPECT_EQ(
      said(What::turned, {1, 2}, {0.5, 0.25}, true),
      "in the 5 photographs that are held upside down against the others (a4, a5, a6, a7 and 1 more) the principal "
      "point lies elsewhere by 1.0 ± 0.5, 2.0 ± 0.2 px: pictures that a program turned by 180 degrees, or a "
      "board or tags that are not as the model has them");
  for (const auto which :
       {Split::from_on, Split::drift, Split::every, Split::some, Split::upside_down, Split::stretches}) {
    change.split = which;
    EXPECT_EQ(divides(change), which != Split::drift);
  }

  // What is not told apart is not named.
  change.split = Split::from_on, change.split_is_clear = false;
  EXPECT_EQ(
      said(What::focus, {0.02}, {0.001}, false),
      "in part of the photographs, which they do not tell clearly (most likely from a4 on) the principal distance "
      "is longer: focus or zoom");
  change.split_is_clear = true, change.what_is_clear = false;
  change.causes = {{What::several, 0.4}, {What::focus, 0.3}, {What::aspect, 0.051}, {What::turned, 0.049}};
  EXPECT_EQ(said(What::focus, {0.02}, {0.001}, true),
            from +
                "the camera is another; what of it changed these photographs do not tell (the principal distance or "
                "fx against fy)");
  change.causes = {
      {What::principal_point, 0.5}, {What::distortion, 0.2}, {What::undistorted, 0.1}, {What::turned, 0.1}};
  EXPECT_EQ(said(What::focus, {0.02}, {0.001}, true),
            from +
                "the camera is another; what of it changed these photographs do not tell (the principal point or the "
                "distortion or a program that took the distortion away or a program that turned the pictures)");
  change.causes.clear();
  EXPECT_EQ(said(What::focus, {0.02}, {0.001}, true),
            from + "the camera is another; what of it changed these photographs do not tell");
  change.or_place = true;
  EXPECT_EQ(said(What::focus, {0.02}, {0.001}, true),
            from +
                "the photographs tell another camera, and they were taken place after place in that order: either "
                "the camera changed, or the board or the tags are not as the model has them");
}

/// Every cause of scatter in words; from where on it is told.
TEST(CameraChanges, EveryScatterHasItsWords) {
  EmpiricalCovariance empirical;
  empirical.judged = true, empirical.photographs = 20, empirical.factor = 2.96;
  EXPECT_EQ(in_words(empirical, {}), "") << "up to 3 without a cause";
  empirical.factor = 3.04;
  const std::string first =
      "the 20 photographs scatter 3.0 times as far as their corners allow: the standard "
      "deviations of the camera are made of that scatter";
  EXPECT_EQ(in_words(empirical, {}), first + kNoCause);
  empirical.by_order = 1.29, empirical.by_place = 1.2;
  EXPECT_EQ(in_words(empirical, {}), first + kNoCause) << "up to 1.3";
  empirical.by_order = 1.44;
  EXPECT_EQ(in_words(empirical, {}), first +
                                         " (of that 1.4 times because photographs that follow one another err "
                                         "alike)" +
                                         kNoCause);
  empirical.by_place = 1.56;
  EXPECT_EQ(in_words(empirical, {}), first +
                                         " (of that 1.6 times because photographs from places near to each other "
                                         "err alike)" +
                                         kNoCause);
  empirical.by_order = empirical.by_place = 1;
  const auto of = [&](Scatter scatter) {
    const std::string all = in_words(empirical, {scatter});
    return all.substr(std::min(all.size(), first.size()));
  };
  EXPECT_EQ(of({Strengths::focus, 0.0123}),
            ". It is that of a principal distance that differs by 1.23 % rms from photograph to photograph (an "
            "autofocus, a zoom, or photographs of another camera among them)");
  EXPECT_EQ(
      of({Strengths::principal_point, 2.34}),
      ". It is that of a principal point that moves by 2.3 px rms from photograph to photograph (a stabiliser, or "
      "a lens that is loose: switch it off; or pictures of which a program turned some by 180 degrees)");
  EXPECT_EQ(of({Strengths::rows, 2.34}),
            ". It is that of rows read one after another while the camera moves, by 2.3 px rms from the first to the "
            "last (a rolling shutter: hold the camera still)");
  EXPECT_EQ(of({Strengths::rows, 2.34, true}),
            ". It is that of rows that are read one after another while the camera moves, or of a principal point that "
            "moves (a rolling shutter, a stabiliser, or pictures of which a program turned some by 180 degrees)");
  const std::string places =
      "places: photographs from one side tell another camera than those from the other (a board "
      "or tags that are not as the model has them, or a lens that is not)";
  EXPECT_EQ(of({Strengths::place, 1}), ". It is that of " + places);
  EXPECT_THAT(in_words(empirical, {{Strengths::rows, 2, true}, {Strengths::place, 1}}),
              testing::EndsWith("by 180 degrees); and of " + places));
  empirical.factor = 1.49;
  EXPECT_EQ(in_words(empirical, {{Strengths::place, 1}}), "") << "up to 1.5 with a cause";
  empirical.factor = 1.51;
  EXPECT_NE(in_words(empirical, {{Strengths::place, 1}}), "");
}

}  // namespace test_camera_change_words
}  // namespace plumbline::markers

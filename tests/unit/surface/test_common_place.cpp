// A scan beside its stated place, and panels that hang in their own ways.
#include <gtest/gtest.h>

#include <string>

#include "surface/dense/common_place.hpp"
#include "surface/dense/joint_pairs.hpp"

namespace plumbline::surface {
namespace test_common_place {

struct Facade {
  std::vector<PanelFace> faces;
  std::vector<PanelSurface> surfaces;
  std::vector<Joint> joints;
  std::vector<MeasuredJoint> found;
};

/// Three columns and two rows, all moved alike by (right, up, out), whose place is known by `sigma`; every second one
/// stands `apart` further out.
Facade moved(const Eigen::Vector3d& by, double sigma, double apart = 0, int columns = 3) {
  Facade facade;
  for (int r = 0; r < 2; ++r)
    for (int c = 0; c < columns; ++c) {
      PanelFace face{"P" + std::to_string(r) + std::to_string(c), facade_plane({1.2 * c, 0, 1.0 * r}, {0, -1, 0}), 1.18,
                     0.98};
      PanelSurface surface;
      surface.form(0) = by.z() + ((r + c) % 2 ? apart : 0);
      surface.form_random = 1e-10 * Eigen::Matrix<double, 6, 6>::Identity();
      surface.form_factor = Eigen::MatrixXd::Zero(6, 1), surface.form_factor(0, 0) = sigma;
      facade.faces.push_back(face), facade.surfaces.push_back(surface);
    }
  facade.joints = joints_of(facade.faces);
  for (const Joint& joint : facade.joints) {
    MeasuredJoint found;
    JointStation station;
    station.shift = joint.upright ? by.x() : by.y(), station.shift_sigma = sigma;
    found.stations.assign(5, station);
    facade.found.push_back(found);
  }
  return facade;
}

std::string words_of(const Facade& facade) {
  return words_of_common_places(common_places(facade.faces, facade.surfaces, facade.joints, facade.found));
}

TEST(CommonPlace, AScanBesideItsStatedPlaceIsTold) {
  const std::string words = words_of(moved({0.006, 0.005, 0.009}, 0.0005));
  EXPECT_NE(words.find("all 6 panels lie 9.0 ± 0.5 mm before their place; all 4 upright joints lie 6.0 ± 0.5 "
                       "mm to the right of their place; all 3 joints across lie 5.0 ± 0.5 mm above their place."),
            std::string::npos)
      << words;
  const std::string left = words_of(moved({-0.006, 0, 0}, 0.0005));
  EXPECT_NE(left.find("all 4 upright joints lie 6.0 ± 0.5 mm to the left of their place."), std::string::npos) << left;
  EXPECT_EQ(left.find("panels lie"), std::string::npos) << left;
}

TEST(CommonPlace, WhatIsWithinWhatIsStatedOrDiffersFromPanelToPanelIsNot) {
  EXPECT_EQ(words_of(moved({0.006, 0.005, 0.009}, 0.003)), "");
  EXPECT_EQ(words_of(moved({0.0015, 0.0015, 0.0015}, 0.0001)), "") << "too little to matter";
  EXPECT_EQ(words_of(moved({0, 0, 0.003}, 0.0001, 0.006)), "") << "panels that hang in their own ways";
}

/// A scan 0.2 % too large passed all that was asked of it, without a word: each joint is as wide as designed.
TEST(CommonPlace, AScanOfAnotherScaleIsTold) {
  const auto words_with = [](double slope, double scatter) {
    Facade facade = moved({0, 0, 0}, 0.0005, 0, 8);
    for (size_t j = 0; j < facade.joints.size(); ++j)
      for (JointStation& station : facade.found[j].stations)
        if (facade.joints[j].upright)
          station.shift = slope * facade.joints[j].plane.origin.x() + (j % 3 == 0 ? -2 : 1) * scatter;
    return words_of_common_scales(common_places(facade.faces, facade.surfaces, facade.joints, facade.found));
  };
  const std::string larger = words_with(0.002, 0.0003);
  EXPECT_NE(larger.find("14 upright joints lie 2.0"), std::string::npos) << larger;
  EXPECT_NE(larger.find(" mm further to the right with each metre. Either"), std::string::npos) << larger;
  EXPECT_NE(words_with(-0.002, 0).find("further to the left"), std::string::npos);
  EXPECT_EQ(words_with(0, 0.002), "") << "panels that hang in their own ways";
  EXPECT_EQ(words_with(0.0002, 0), "") << "less than 2 mm from end to end";
}

TEST(CommonPlace, WhatWasNotMeasuredDoesNotCount) {
  Facade facade = moved({0, 0, 0.009}, 0.0005);
  for (size_t f = 0; f < 4; ++f) facade.surfaces[f] = {}, facade.surfaces[f].not_measured = "no point";
  EXPECT_EQ(words_of(facade), "") << "two are no all";
}

}  // namespace test_common_place
}  // namespace plumbline::surface

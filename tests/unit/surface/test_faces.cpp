// Faces of panels of designs with one facade, with two that look away from each other, and where nothing says which
// side is outside.
#include <gtest/gtest.h>

#include <limits>

#include "faces.hpp"

namespace plumbline::surface {
namespace test_faces {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const Eigen::Vector3d kSouth(0, -1, 0), kNorth(0, 1, 0);

std::unique_ptr<DesignElementT> panel(const std::string& name, const Eigen::Vector3d& middle,
                                      const Eigen::Vector3d& size) {
  auto element = std::make_unique<DesignElementT>();
  element->name = name, element->guid = name + "-guid", element->is_panel = true;
  element->placement = {Eigen::Quaterniond::Identity(), middle};
  element->box_low = -0.5 * size, element->box_high = 0.5 * size;
  return element;
}

void face_to(DesignElementT& element, const Eigen::Vector3d& out, bool confirmed) {
  element.facade = std::make_unique<FacadeFrameT>();
  element.facade->out = out, element.facade->up = Eigen::Vector3d::UnitZ(),
  element.facade->right = element.facade->up.cross(out);
  element.facade->confirmed = confirmed, element.facade->source = confirmed ? "own_axes" : "guess";
}

/// A building 10 m deep with a panel to the south and one to the north.
DesignT two_facades(bool confirmed) {
  DesignT design;
  design.facade_normal = Eigen::Vector3d::Constant(kNan);  // as it is of more than one facade
  design.elements.push_back(panel("S", {5, 0, 3}, {1.5, 0.04, 3}));
  design.elements.push_back(panel("N", {5, 10, 3}, {1.5, 0.04, 3}));
  face_to(*design.elements[0], kSouth, confirmed), face_to(*design.elements[1], kNorth, confirmed);
  return design;
}

/// More photographs of the south than of the north: for the north panel most look from behind.
const std::vector<Eigen::Vector3d> kAround = {{2, -6, 2}, {5, -6, 2}, {8, -6, 2}, {5, -6, 4}, {3, 16, 2}, {7, 16, 2}};

TEST(Faces, EachFacadeFacesItsOwnWay) {
  for (const auto& seen_from : {kAround, std::vector<Eigen::Vector3d>{}}) {
    const Faces faces = faces_of(two_facades(true), seen_from);
    ASSERT_EQ(faces.faces.size(), 2U);
    EXPECT_TRUE(faces.faces[0].plane.axes.col(2).isApprox(kSouth, 1e-12));
    EXPECT_TRUE(faces.faces[1].plane.axes.col(2).isApprox(kNorth, 1e-12))
        << "turned by the photographs of the other facade";
    EXPECT_NEAR(faces.faces[1].plane.origin.y(), 10.02, 1e-12) << "the face is the outer side of the panel";
    EXPECT_TRUE(faces.faces[0].plane.axes.col(0).isApprox(Eigen::Vector3d(1, 0, 0), 1e-12));
    EXPECT_TRUE(faces.faces[1].plane.axes.col(0).isApprox(Eigen::Vector3d(-1, 0, 0), 1e-12));
    for (const PanelFace& face : faces.faces) EXPECT_NEAR(face.plane.axes.determinant(), 1, 1e-12);
    EXPECT_NEAR(faces.faces[1].width, 1.5, 1e-12);
    EXPECT_NEAR(faces.faces[1].height, 3, 1e-12);
    EXPECT_TRUE(faces.left_out.empty());
  }
}

TEST(Faces, AGuessIsNotEnoughAgainstPhotographsFromBothSides) {
  const Faces faces = faces_of(two_facades(false), kAround);
  ASSERT_EQ(faces.faces.size(), 1U) << "of the south panel photographs and guess agree, of the north they do not";
  EXPECT_EQ(faces.faces[0].id, "S");
  ASSERT_EQ(faces.left_out.size(), 1U);
  EXPECT_NE(in_words(faces.left_out[0]).find("N: 4 places look at it from one side, 2 from the other"),
            std::string::npos)
      << in_words(faces.left_out[0]);
}

TEST(Faces, PhotographsSayItWhereTheDesignDoesNot) {
  DesignT design;
  design.facade_normal = Eigen::Vector3d::Constant(kNan);
  design.elements.push_back(panel("S", {5, 0, 3}, {1.5, 0.04, 3}));
  const Faces seen = faces_of(design, {{5, -6, 2}, {6, -6, 2}});
  ASSERT_EQ(seen.faces.size(), 1U);
  EXPECT_TRUE(seen.faces[0].plane.axes.col(2).isApprox(kSouth, 1e-12));
  const Faces unseen = faces_of(design, {});
  ASSERT_EQ(unseen.left_out.size(), 1U);
  EXPECT_NE(in_words(unseen.left_out[0]).find("does not say which side is outside"), std::string::npos)
      << in_words(unseen.left_out[0]);
}

TEST(Faces, AFinFacesAsItsFacadeDoes) {
  DesignT design;
  design.facade_normal = Eigen::Vector3d::Constant(kNan);
  design.elements.push_back(panel("fin", {5, 0, 3}, {0.05, 0.3, 3}));  // thin sideways
  face_to(*design.elements[0], kSouth, true);
  const Faces faces = faces_of(design, kAround);
  ASSERT_EQ(faces.faces.size(), 1U);
  EXPECT_TRUE(faces.faces[0].plane.axes.col(2).isApprox(kSouth, 1e-12));
  EXPECT_NEAR(faces.faces[0].width, 0.05, 1e-12);
}

TEST(Faces, ASoffitHasTheUpOfItsFrame) {
  DesignT design;
  design.facade_normal = Eigen::Vector3d::Constant(kNan);
  design.elements.push_back(panel("soffit", {5, 0, 3}, {1.5, 0.8, 0.02}));
  face_to(*design.elements[0], {0, 0, -1}, true);
  design.elements[0]->facade->up = {1, 0, 0};
  const Faces faces = faces_of(design, {});
  ASSERT_EQ(faces.faces.size(), 1U);
  EXPECT_TRUE(faces.faces[0].plane.axes.col(1).isApprox(Eigen::Vector3d(1, 0, 0), 1e-12));
  EXPECT_NEAR(faces.faces[0].height, 1.5, 1e-12);
}

TEST(Faces, APanelThatTheDesignMakesCurvedIsNotFlat) {
  DesignT design = two_facades(true);
  design.elements[0]->sag = {0, 0, 0.03, 0.0002, 0, 0};  // its outer side is towards smaller y
  design.elements[1]->sag = {0, 0, 0.03, 0.0002, kNan, kNan};
  const Faces faces = faces_of(design, kAround);
  ASSERT_EQ(faces.faces.size(), 1U);
  EXPECT_EQ(faces.faces[0].id, "N") << "its inner side alone is curved";
  ASSERT_EQ(faces.left_out.size(), 1U);
  EXPECT_EQ(faces.left_out[0].guid, "S-guid");
  EXPECT_NE(faces.left_out[0].reason.find("is no plane: its parts lie 30.0 mm apart"), std::string::npos)
      << faces.left_out[0].reason;
}

/// Of a rectangle about a trapezoid a part is the neighbour's.
TEST(Faces, APanelThatIsNoRectangleIsLeftOutByName) {
  DesignT design = two_facades(true);
  design.elements[0]->filled = {1, 1, 0.92, 0.92, 1, 1};
  design.elements[1]->filled = {0.3, 0.3, 0.98, 0.98, 1, 1};  // a notch
  const Faces faces = faces_of(design, kAround);
  ASSERT_EQ(faces.faces.size(), 1U);
  ASSERT_EQ(faces.left_out.size(), 1U);
  EXPECT_EQ(faces.left_out[0].guid, "S-guid");
  EXPECT_NE(faces.left_out[0].reason.find("is no rectangle, it fills 92 % of one"), std::string::npos);
}

TEST(Faces, ASideThatNobodyConfirmsIsSaid) {
  EXPECT_TRUE(faces_of(two_facades(true), {}).guessed.empty());
  EXPECT_EQ(faces_of(two_facades(false), {}).guessed.size(), 2U);
  EXPECT_TRUE(faces_of(two_facades(false), {{5, -30, 2}}).guessed.empty()) << "a scanner stood before one of them";
}

TEST(Faces, WhatConsistsOfPanelsIsNoneItself) {
  DesignT design = two_facades(true);
  design.elements.push_back(panel("wall", {5, 0, 3}, {3, 0.04, 3}));
  face_to(*design.elements[2], kSouth, true);
  design.elements[0]->parent_guid = "wall-guid";
  const Faces faces = faces_of(design, kAround);
  EXPECT_EQ(faces.faces.size(), 2U);
  EXPECT_TRUE(faces.left_out.empty());
}

/// A sheet before a core that is 6 mm wider at the left and right and 4 mm above: joints are between the sheets.
TEST(Faces, APanelIsAsWideAsItsOuterSide) {
  DesignT design = two_facades(true);
  DesignElementT& south = *design.elements[0];
  south.rectangles.assign(24, kNan);
  const double outer[4] = {-1.5, -0.744, 1.496, 0.744};  // of y: z, x
  std::copy(outer, outer + 4, south.rectangles.begin() + 8);
  const Faces faces = faces_of(design, {});
  ASSERT_EQ(faces.faces.size(), 2U);
  EXPECT_NEAR(faces.faces[0].width, 1.488, 1e-12);
  EXPECT_NEAR(faces.faces[0].height, 2.996, 1e-12);
  EXPECT_TRUE(faces.faces[0].plane.origin.isApprox(Eigen::Vector3d(5, -0.02, 2.998), 1e-9))
      << faces.faces[0].plane.origin.transpose();
  EXPECT_NEAR(faces.faces[1].width, 1.5, 1e-12) << "of the other nothing is known";
}

/// Families call all their panels alike, and somebody has to find the one that failed.
TEST(Faces, PanelsOfOneNameAreToldApart) {
  DesignT design = two_facades(true);
  for (auto& element : design.elements) element->name = "PANEL";
  const auto ids = [&] {
    std::vector<std::string> found;
    for (const PanelFace& face : faces_of(design, {}).faces) found.push_back(face.id);
    return found;
  };
  EXPECT_EQ(ids(), (std::vector<std::string>{"PANEL [S-guid]", "PANEL [N-guid]"}));
  design.elements[0]->tag = "17", design.elements[1]->tag = "17";
  EXPECT_EQ(ids(), (std::vector<std::string>{"PANEL [S-guid]", "PANEL [N-guid]"})) << "one tag for both tells nothing";
  design.elements[1]->tag = "18";
  EXPECT_EQ(ids(), (std::vector<std::string>{"PANEL [17]", "PANEL [18]"}));
  design.elements[1]->name = "OTHER";
  EXPECT_EQ(ids(), (std::vector<std::string>{"PANEL", "OTHER"}));
}

TEST(Faces, ThePlaneOfPointsNeedsSomeoneWhoLooksAtIt) {
  PointsT points;
  for (const Eigen::Vector3d& place : {Eigen::Vector3d(0, 0, 0), {2, 0, 0}, {2, 0, 3}, {0, 0.001, 3}}) {
    points.points.push_back(std::make_unique<PointT>());
    points.points.back()->position = place;
  }
  for (const auto& from : {std::vector<Eigen::Vector3d>{}, {{1, -5, 1}, {1, 5, 1}}}) try {
      face_through(points, from, 0.05);
      ADD_FAILURE() << "which side is outside is a guess";
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find("'seen_from'"), std::string::npos) << error.what();
    }
  const PanelFace face = face_through(points, {{1, -5, 1}}, 0.05).faces[0];
  EXPECT_LT(face.plane.axes(1, 2), -0.99);
  EXPECT_NEAR(face.width, 2 + 2 * 0.05, 1e-3) << "as far as the points, and a margin on both sides";
  EXPECT_NEAR(face.height, 3 + 2 * 0.05, 1e-3);
  EXPECT_LT((face.plane.origin - Eigen::Vector3d(1, 0, 1.5)).norm(), 1e-2);
  EXPECT_GT(face_through(points, {{1, 5, 1}}, 0.05).faces[0].plane.axes(1, 2), 0.99);
}

}  // namespace test_faces
}  // namespace plumbline::surface

// Networks without approximate coordinates: whatever can be determined is found, what has two solutions is refused.
#include <cmath>
#include <numbers>

#include "adjust_network.hpp"
#include "formats/gama.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace {

AdjustOptions plain() {
  AdjustOptions options;
  options.curvature = Switch::off;
  return options;
}

std::string network(const std::string& content) {
  return "<gama-local><network axes-xy=\"en\"><parameters sigma-apr=\"1\" sigma-act=\"apriori\"/>"
         "<points-observations distance-stdev=\"5\" direction-stdev=\"10\" angle-stdev=\"10\" "
         "zenith-angle-stdev=\"10\">" +
         content + "</points-observations></network></gama-local>\n";
}

NetworkResult adjust(const std::string& content) {
  return adjust_network(read_gama_xml(network(content), "t.gkf"), plain());
}

std::string refusal(const std::string& content) {
  try {
    adjust(content);
  } catch (const NetworkError& error) {
    return error.what();
  }
  return "";
}

/// C and D north or south of AB: five distances cannot tell.
std::string quadrilateral(const std::string& c) {
  return "<point id='A' x='0' y='100' fix='xy'/><point id='B' x='100' y='100' fix='xy'/><point id='C' " + c +
         " adj='xy'/><point id='D' adj='xy'/><obs><distance from='A' to='C' val='100'/><distance from='A' to='D' "
         "val='141.421'/><distance from='B' to='C' val='141.421'/><distance from='B' to='D' val='100'/><distance "
         "from='C' to='D' val='100'/></obs>";
}

TEST(Approximate, TwoMirroredNetworksAreRefusedUntilOnePointDecides) {
  const std::string text = refusal(quadrilateral(""));
  for (const char* words : {"2 different networks equally well", "point C is at E", "N 0.00", "N 200.00",
                            "one of these as approximate coordinates of C,"})
    EXPECT_NE(text.find(words), std::string::npos) << words << " in: " << text;
  EXPECT_NEAR(adjust(quadrilateral("x='0.2' y='-0.3'")).point("D").position.y(), 0, 0.01);
  EXPECT_NEAR(adjust(quadrilateral("x='0.5' y='200.4'")).point("D").position.y(), 200, 0.01);
}

TEST(Approximate, FreeTrilaterationAsksForThreePoints) {
  const auto points = [](const char* a, const char* b, const char* c) {
    return std::string("<point id='A' ") + a + " adj='XY'/><point id='B' " + b + " adj='XY'/><point id='C' " + c +
           " adj='XY'/><point id='D' adj='XY'/><obs><distance from='A' to='B' val='100'/><distance from='A' to='C' "
           "val='100'/><distance from='A' to='D' val='141.421'/><distance from='B' to='C' val='141.421'/><distance "
           "from='B' to='D' val='100'/><distance from='C' to='D' val='100'/></obs>";
  };
  EXPECT_NE(refusal(points("", "", "")).find("of three points"), std::string::npos) << refusal(points("", "", ""));
  const NetworkResult r = adjust(points("x='1' y='2'", "x='99' y='1'", "x='-1' y='-98'"));
  EXPECT_LT(r.point("D").position.y(), -90);
}

/// Four spheres about points of one height: above or below; a fifth decides.
TEST(Approximate, SlopeDistancesPlaceAPointInSpace) {
  const std::string four =
      "<point id='1' x='300' y='0' z='0' fix='xyz'/><point id='2' x='0' y='300' z='0' fix='xyz'/><point id='3' "
      "x='-300' y='0' z='0' fix='xyz'/><point id='4' x='0' y='-300' z='0' fix='xyz'/><point id='5' x='0' y='0' z='100' "
      "fix='xyz'/><point id='P' adj='xyz'/><obs><s-distance from='1' to='P' val='500'/><s-distance from='2' to='P' "
      "val='500'/><s-distance from='3' to='P' val='500'/><s-distance from='4' to='P' val='500'/>";
  const std::string text = refusal(four + "</obs>");
  EXPECT_NE(text.find("H 400.00"), std::string::npos) << text;
  EXPECT_NE(text.find("H -400.00"), std::string::npos) << text;
  const NetworkResult r = adjust(four + "<s-distance from='5' to='P' val='500'/></obs>");
  EXPECT_LT((r.point("P").position - Eigen::Vector3d(0, 0, -400)).norm(), 1e-6);
}

/// Between two points without a view of each other: each of S1 and S2 lies on two circles, and only the angles between
/// them tell which of the four combinations is meant.
TEST(Approximate, AnglesDecideBetweenCombinationsOfPlaces) {
  const NetworkResult r = adjust(
      "<point id='A' x='-200' y='100' z='0' fix='xyz'/><point id='B' x='200' y='-100' z='0' fix='xyz'/><point id='S1' "
      "adj='xyz'/><point id='S2' adj='xyz'/><obs><angle from='S1' bs='S2' fs='A' val='100'/><angle from='S2' bs='B' "
      "fs='S1' val='300'/><s-distance from='A' to='S1' val='223.606798'/><s-distance from='S1' to='S2' "
      "val='200'/><s-distance from='B' to='S2' val='223.606798'/><s-distance from='A' to='S2' val='300'/><z-angle "
      "from='A' to='S1' val='70.4833'/><z-angle from='B' to='S2' val='70.4833'/></obs>");
  EXPECT_LT((r.point("S1").position - Eigen::Vector3d(0, 100, 100)).norm(), 1e-3);
  EXPECT_LT((r.point("S2").position - Eigen::Vector3d(0, -100, 100)).norm(), 1e-3);
}

/// Two directions to known points and one distance: the circle of the angle meets that of the distance twice.
TEST(Approximate, TwoDirectionsAndADistancePlaceAStation) {
  const std::string start =
      "<point id='A' x='0' y='50' fix='xy'/><point id='B' x='40' y='50' fix='xy'/><point id='S' adj='xy'/><obs "
      "from='S'><direction to='A' val='0'/><direction to='B' val='50'/><distance to='A' val='50'/>";
  EXPECT_NE(refusal(start + "</obs>").find("equally well"), std::string::npos) << refusal(start + "</obs>");
  const double b = std::hypot(40 - 30, 50 - 10);
  const NetworkResult r = adjust(
      "<point id='A' x='0' y='50' fix='xy'/><point id='B' x='40' y='50' fix='xy'/><point id='S' adj='xy'/><obs "
      "from='S'><direction to='A' val='0'/><direction to='B' val='" +
      std::to_string((std::atan2(10, 40) - std::atan2(-30, 40)) * 200 / std::numbers::pi) +
      "'/><distance to='A' val='50'/></obs><obs><distance from='B' to='S' val='" + std::to_string(b) + "'/></obs>");
  EXPECT_LT((r.point("S").position.head<2>() - Eigen::Vector2d(30, 10)).norm(), 1e-3);
}

}  // namespace
}  // namespace plumbline::survey

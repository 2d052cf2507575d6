// OpenDroneMap's gcp_list.txt as it comes from other machines.
#include <gmock/gmock.h>

#include "control/points/gcp_list.hpp"
#include "control/points/image_points.hpp"
#include "control/points/projection_unit.hpp"

namespace plumbline::control {
namespace test_gcp_list {

using testing::AllOf;
using testing::HasSubstr;

std::string failure(const std::string& text) {
  try {
    gcp_lines(text, "g.txt");
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

/// Once "DSC" was the image and "0001.jpg" the point.
TEST(GcpList, NamesWithBlanksAreReadBetweenTabsAndRefusedBetweenBlanks) {
  const auto lines = gcp_lines("EPSG:32632\n1\t2\t3\t4.5\t5.5\tDSC 0001.jpg\tNorth corner\n1 2 3 4 5 b.jpg P2\n", "g");
  ASSERT_EQ(lines->size(), 2u);
  EXPECT_EQ(lines->at(0).image, "DSC 0001.jpg");
  EXPECT_EQ(lines->at(0).name, "North corner");
  EXPECT_EQ(lines->at(1).image, "b.jpg");
  EXPECT_EQ(gcp_lines("EPSG:32632\n1\t2\t3\t4\t5\tDSC 1.jpg\n", "g")->at(0).name, "gcp1");
  EXPECT_EQ(gcp_lines("EPSG:32632\n1\t\t2\t3 4\t5\ta.jpg\tP1 note\n", "g")->at(0).name, "P1") << "tabs as blanks";
  EXPECT_THAT(failure("EPSG:32632\n1 2 3 4 5 DSC 0001.jpg P1\n"),
              AllOf(HasSubstr("g.txt:2: found '0001.jpg' after the image 'DSC'"), HasSubstr("tabs")));
}

TEST(GcpList, OtherUnitsThanMetresAreRefused) {
  for (const char* code : {"EPSG:2263", "epsg:2229", "EPSG:6539", "+init=epsg:2263 +no_defs", "EPSG:2263+6360"})
    EXPECT_EQ(other_unit_than_metres(code), "feet or another unit that is not the metre") << code;
  for (const char* code : {"EPSG:4326", "EPSG:6318", "EPSG:4979", "WGS84", "+proj=longlat +datum=WGS84"})
    EXPECT_EQ(other_unit_than_metres(code), "degrees") << code;
  // Neighbours of those in feet: New York, Utah, and the zones of UTM.
  for (const char* code :
       {"EPSG:32632", "EPSG:32118", "EPSG:6538", "EPSG:2221", "EPSG:3857", "EPSG:25832", "EPSG:27700", "EPSG:2056",
        "EPSG:31370", "EPSG:26918", "WGS84 UTM 16N", "LOCAL", "+proj=utm +zone=32 +units=m", "+proj=tmerc +to_meter=1"})
    EXPECT_EQ(other_unit_than_metres(code), "") << code;
  EXPECT_EQ(other_unit_than_metres("+proj=lcc +units=us-ft +no_defs"), "US survey feet");
  EXPECT_EQ(other_unit_than_metres("+proj=lcc +units=ft"), "feet");
  EXPECT_EQ(other_unit_than_metres("+proj=lcc +units=km"), "the unit 'km'");
  EXPECT_EQ(other_unit_than_metres("+proj=lcc +to_meter=0.3048"), "units of 0.3048 m");
  EXPECT_THAT(
      failure("# site\nEPSG:2263\n980000 200000 30 5 6 a.jpg P\n"),
      AllOf(HasSubstr("g.txt:2: found the projection 'EPSG:2263'"), HasSubstr("feet"), HasSubstr("metres first")));
}

/// Once eight sound points on EPSG:3857 gave heights of 1.5 times their own, with an rms of 0.3 px and no word.
TEST(GcpList, MapsThatDrawLengthsOtherwiseThanHeightsAreRefused) {
  EXPECT_THAT(failure("EPSG:3857\n1000000 6200000 300 5 6 a.jpg P\n"),
              AllOf(HasSubstr("g.txt: the map 'WGS 84 / Pseudo-Mercator' draws lengths at the points 1.508"),
                    HasSubstr("times as long as they are")));
  EXPECT_THAT(failure("EPSG:32632\n5400000.2 500000.1 100.3 10.5 20.5 a.jpg P1\n"),
              HasSubstr("columns are east, north"));
  for (const char* head : {"+proj=utm +zone=32 +datum=WGS84 +units=m +no_defs", "WGS84 UTM 32N"})
    EXPECT_THAT(failure(std::string(head) + "\n5400000.2 500000.1 100.3 10.5 20.5 a.jpg P1\n"),
                HasSubstr("columns are east, north"))
        << head;
  EXPECT_THAT(failure("+proj=merc +a=6378137 +b=6378137 +units=m\n1000000 6200000 300 5 6 a.jpg P\n"),
              HasSubstr("times as long as they are"));
  for (const char* sound :
       {"EPSG:32632\n500000 5400000 100 5 6 a.jpg P\n", "EPSG:2154\n652000 6862000 35 5 6 a.jpg P\n",
        "EPSG:2056\n2600000 1200000 550 5 6 a.jpg P\n", "EPSG:27700\n530000 180000 20 5 6 a.jpg P\n",
        "+proj=utm +zone=32 +datum=WGS84 +units=m +no_defs\n500000 5400000 100 5 6 a.jpg P\n",
        "WGS84 UTM 16N\n500000 5400000 100 5 6 a.jpg P\n", "LOCAL\n1 2 3 4 5 a.jpg P\n"})
    EXPECT_EQ(failure(sound), "") << sound;
}

TEST(GcpList, ImpossibleValuesAndProjectionsAsWktAreNamed) {
  EXPECT_THAT(failure("EPSG:32632\n1 2 3 4 5 a.jpg P\n1 1e308 3 4 5 b.jpg P\n"),
              HasSubstr("g.txt:3: found the value 1e308"));
  EXPECT_THAT(failure("EPSG:32632\n1 2 nan 4 5 a.jpg P\n"), HasSubstr("g.txt:2: found '1 2 nan"));
  EXPECT_THAT(failure("PROJCS[\"WGS 84 / UTM zone 32N\",GEOGCS[\"WGS 84\"]]\n1 2 3 4 5 a.jpg P\n"),
              AllOf(HasSubstr("g.txt:1: found a projection as WKT ('PROJCS')"), HasSubstr("EPSG:32632")));
}

TEST(GcpList, CommentsLineEndsAndEncodingsOfOtherMachines) {
  const auto expect_two = [](const std::string& text, const char* what) {
    const auto lines = gcp_lines(text, "g");
    ASSERT_TRUE(lines) << what;
    ASSERT_EQ(lines->size(), 2u) << what;
    EXPECT_EQ(lines->at(1).image, "b.jpg") << what;
  };
  const std::string text = "  # ours\nEPSG:32632\n\t# x y z\n1 2 3 4 5 a.jpg P\n  # more\n1 2 3 4 5 b.jpg P\n";
  expect_two(text, "indented comments");
  std::string macintosh = text, wide = "\xFF\xFE";
  for (char& c : macintosh) c = c == '\n' ? '\r' : c;
  expect_two(macintosh, "CR only");
  for (const char c : text) wide += {c, '\0'};
  expect_two(wide, "UTF-16");
  expect_two("\xEF\xBB\xBF" + text, "byte order mark");
  EXPECT_EQ(parse_image_points(wide, "g", true).at(1).pixel.x(), 3.5);
}

}  // namespace test_gcp_list
}  // namespace plumbline::control

// Tables of known points as programs, offices and spreadsheets write them.
#include <gmock/gmock.h>

#include "control/points/control_files.hpp"
#include "control/points/image_points.hpp"

namespace plumbline {
namespace test_control_table {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

template <typename Work>
std::string message_of(Work&& work) {
  try {
    work();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

std::vector<control::ControlPoint> points_of(const std::string& text, const std::string& file) {
  return control::parse_control(text, file).points;
}

TEST(ControlFiles, ReadCsvAndGcpLists) {
  const auto control = points_of("name,x,y,z,sigma,role\nA,1,2,3,0.002,control\nB,4,5,6,0.003,check\n", "c.csv");
  ASSERT_EQ(control.size(), 2u);
  EXPECT_TRUE(control[1].check);
  EXPECT_DOUBLE_EQ(control[0].sigma.z(), 0.002);
  const std::string list =
      "EPSG:32632\n500000.1 5000000.2 100.3 10.5 20.5 a.jpg P1\n500000.1 5000000.2 100.3 11.5 21.5 b.jpg P1\n";
  const auto gcp = points_of(list, "gcp_list.txt");
  ASSERT_EQ(gcp.size(), 1u);
  const auto measured = control::parse_image_points(list, "gcp_list.txt", true);
  ASSERT_EQ(measured.size(), 2u);
  EXPECT_DOUBLE_EQ(measured[1].pixel.x(), 11.0);
  EXPECT_THAT(control::gcp_list(gcp, measured, "EPSG:32632"),
              HasSubstr("500000.100000 5000000.200000 100.300000 10.0000 20.0000 a.jpg P1"));
  EXPECT_THAT(message_of([] { points_of("EPSG:4326\n8.1 48.2 100 1 2 a.jpg\n", "g.txt"); }), HasSubstr("degrees"));
  EXPECT_THAT(message_of([] { points_of("name,x,y,z\nA,1,2,x\n", "c.csv"); }), HasSubstr("c.csv:2"));
  EXPECT_THAT(message_of([] { points_of("name,x,y,z\nA,1,2,3\n,1,2,3\n", "c.csv"); }),
              HasSubstr("c.csv:3: found no name"));
}

TEST(ControlFiles, ThousandsAreNotTakenForDecimals) {
  EXPECT_THAT(message_of([] { points_of("id;E;N;H;sigma_mm\nK1;1,000;2,000;100;1\nK2;1,060;2,005;101;1\n", "c.csv"); }),
              HasSubstr("'1,000' beside whole numbers: ',' may separate decimals or thousands"));
  EXPECT_THAT(message_of([] { points_of("id;E;N;H\nK1;1.000;2.000;100\n", "c.csv"); }), HasSubstr("thousands"));
  EXPECT_DOUBLE_EQ(points_of("id;E;N;H\nK1;1,000;2,000;100,5\n", "c.csv")[0].position.x(), 1);
  const auto untold = control::parse_control("id;E;N;H\nK1;1,000;2,000;3,000\n", "c.csv");
  ASSERT_EQ(untold.warnings.size(), 1u);
  EXPECT_THAT(untold.warnings[0], HasSubstr("not as thousands: nothing in the table tells"));
}

/// A grid of the building that begins at 0, and an origin of 100 and 200: nobody who separates cells by ',' groups by
/// '.'.
TEST(ControlFiles, ALocalGridIsNoTableOfThousands) {
  for (const char* const text :
       {"id,e,n,h\nA,0,0,0\nB,12.345,0,0\n", "id,e,n,h\nP1,100,200,10.512\nP2,110.234,205.111,10.498\n",
        "id;e;n;h\nA;0;0;0\nB;12,345;0;0\n"}) {
    const auto table = control::parse_control(text, "c.csv");
    EXPECT_EQ(table.points.size(), 2u) << text;
  }
  EXPECT_THAT(control::parse_control("id,e,n,h\nB,12.345,1.000,2.000\n", "c.csv").warnings, testing::IsEmpty());
}

/// A map of the USA counts in survey feet: read in feet of 0.3048 m its points lay 3.9 m elsewhere.
TEST(ControlFiles, FeetThatMayBeSurveyFeetAreTold) {
  const auto notes = [](const std::string& text) { return control::parse_control(text, "c.csv").notes; };
  EXPECT_THAT(notes("id,E_ft,N_ft\nK1,6416621.6725,2004913.1254\n"),
              testing::Contains(HasSubstr("in US survey feet, as maps of the USA have them, the points lie 3.9 m")));
  EXPECT_THAT(notes("id,E_ft,N_ft\nK1,100.5,200.5\n"), testing::Each(testing::Not(HasSubstr("survey"))));
}

TEST(ControlFiles, TellHowTheAxesWereTaken) {
  const auto axes = [](const std::string& text) { return control::parse_control(text, "c.csv").axes; };
  EXPECT_EQ(axes("name,east,north,height\nA,1,2,3\n"), "");
  EXPECT_EQ(axes("EPSG:32632\n1 2 3 4 5 a.jpg\n"), "");
  EXPECT_THAT(axes("name,x,y,z\nA,1,2,3\n"), HasSubstr("X = east and Y = north"));
  EXPECT_THAT(axes("A,1,2,3\n"), HasSubstr("no header"));
}

TEST(ControlFiles, HeadersInOtherLanguagesAndTablesThatAreOthers) {
  for (const char* header :
       {"Punktnr;Rechtswert;Hochwert;H\xC3\xB6he", "Matricule;Est;Nord;Altitude", "Punto;Este;Norte;Cota"}) {
    const std::string text = std::string(header) + "\nA;102,5;203,25;12,125\nB;1;2;3\n";
    const auto points = points_of(text, "c.csv");
    ASSERT_EQ(points.size(), 2u) << header;
    EXPECT_EQ(points[0].position, Eigen::Vector3d(102.5, 203.25, 12.125)) << header;
    EXPECT_EQ(control::parse_control(text, "c.csv").axes, "") << header;
  }
  EXPECT_EQ(points_of("Punktnr;Y;X;H\nA;1;2;3\n", "c.csv").at(0).position, Eigen::Vector3d(1, 2, 3));
  EXPECT_THAT(message_of([] { points_of("Punktnr;X;Y;Z\nA;1;2;3\n", "c.csv"); }),
              HasSubstr("c.csv:1: found X, Y and Z among German names"));
  // A zone in front of the easting, and geocentric coordinates: without a header nothing tells.
  EXPECT_THAT(message_of([] { points_of("1770,56,386930.017,7327717.501\n", "z.csv"); }),
              HasSubstr("z.csv:1: found the height 7327717.501"));
  EXPECT_EQ(points_of("name,x,y,z\nSTR1,-4467103.2,2683039.5,-3666948.8\n", "z.csv").size(), 1u);
}

TEST(ControlFiles, TakeTablesWithoutHeaderAndTellWhatTheyCannotTake) {
  // As Find-GCP and lcmrl/COLMAP_GroundControlPoints have them.
  const auto semicolons = points_of("5;65.7885;287.7204;2.0694;\n6;66.3062;288.4897;1.1083;\n", "a.txt");
  ASSERT_EQ(semicolons.size(), 2u);
  EXPECT_EQ(semicolons[1].name, "6");
  EXPECT_NEAR(semicolons[1].position.y(), 288.4897, 1e-12);
  const auto with_sigma = points_of("P1 450000.5 5400000.25 300 0.002\n", "b.txt");
  EXPECT_NEAR(with_sigma.at(0).sigma.z(), 0.002, 1e-12);
  const auto seen = control::parse_image_points("a.jpg,P1,10.5,20\n", "o.csv", false);
  EXPECT_NEAR(seen.at(0).pixel.x(), 10.5, 1e-12);
  EXPECT_THAT(message_of([] { points_of("P1,1,2\n", "c.csv"); }), HasSubstr("c.csv:1: found 3 columns"));
  EXPECT_NEAR(points_of("name,x_ft,y_ft,z_ft\nA,1,2,3\n", "c.csv").at(0).position.z(), 3 * 0.3048, 1e-12);
  EXPECT_THAT(message_of([] { points_of("name,x_km,y_km,z_km\nA,1,2,3\n", "c.csv"); }), HasSubstr("is in 'km'"));
  EXPECT_THAT(message_of([] { points_of("name,x,y,z,sigma\nA,1,2,3,-1\n", "c.csv"); }),
              HasSubstr("c.csv:2: point 'A' has a negative standard deviation"));
  EXPECT_THAT(
      message_of([] { control::parse_image_points("image,point,x,y,sigma\na.jpg,A,1,2,-1\n", "o.csv", false); }),
      HasSubstr("o.csv:2: point 'A' has a negative standard deviation"));
  EXPECT_THAT(message_of([] { points_of("name,x,y,z,role\nA,1,2,3,chek\n", "c.csv"); }),
              HasSubstr("c.csv:2: 'role' is 'chek'"));
  EXPECT_THAT(message_of([] { points_of("name,x,y,z,sx\nA,1,2,3,1\n", "c.csv"); }),
              HasSubstr("for some of x, y and z only"));
}

/// Once dropped without a word, and the accuracy that the pipeline assumes took their place.
TEST(ControlFiles, StandardDeviationsAreReadByWhateverNameOrRefused) {
  for (const char* header : {"id,east_m,north_m,height_m,sigma_east_mm,sigma_north_mm,sigma_height_mm",
                             "id,E,N,H,sigma_E_mm,sigma_N_mm,sigma_H_mm", "id,E,N,H,sE_mm,sN_mm,sH_mm",
                             "id,x,y,z,std_x [mm],std_y [mm],std_z [mm]"}) {
    const auto points = points_of(std::string(header) + "\nA,1,2,3,2,4,6\n", "c.csv");
    EXPECT_NEAR((points.at(0).sigma - Eigen::Vector3d(0.002, 0.004, 0.006)).norm(), 0, 1e-12) << header;
  }
  EXPECT_THAT(message_of([] { points_of("id,E,N,H,sigma_h_mm\nA,1,2,3,5\n", "c.csv"); }),
              HasSubstr("for some of x, y and z only"));
  EXPECT_THAT(message_of([] { points_of("id,E,N,H,stdPlan,stdHeight\nA,1,2,3,5,6\n", "c.csv"); }),
              HasSubstr("the column 'stdplan' looks like an accuracy"));
  EXPECT_EQ(points_of("id,E,N,H,code,date\nA,1,2,3,bolt,2026\n", "c.csv").size(), 1u);
}

TEST(ControlFiles, GcpListsOfOpenDroneMapKeepOnePlaceAPoint) {
  const std::string list = "# made by hand\nWGS84 UTM 16N \n1 2 3 10 20 a.jpg g1\n1 2 3 11 21 b.jpg g1\n";
  EXPECT_EQ(points_of(list, "g.txt").size(), 1u);
  EXPECT_EQ(control::parse_image_points(list, "g.txt", false).size(), 2u);
  EXPECT_THAT(message_of([&] { points_of(list + "1 2 4 12 22 c.jpg g1\n", "g.txt"); }),
              HasSubstr("g.txt:5: point g1 has other coordinates here than in line 3"));
  EXPECT_THAT(message_of([] { points_of("epsg:4979\n8 48 1 2 3 a.jpg\n", "g.txt"); }), HasSubstr("in degrees"));
}

/// A column `sigma`, `sigma [mm]` or `sigma_mm` was dropped in campaigns, and 1 mm assumed in its place.
TEST(ControlFiles, OneStandardDeviationForAllAxesIsReadByAnyName) {
  for (const char* column : {"sigma_mm", "sigma [mm]", "Sigma (mm)", "accuracy_mm", "sd_mm", "std [mm]",
                             "Genauigkeit [mm]", "Accuracy_X/Y/Z_(mm)"})
    EXPECT_NEAR(points_of("id,E,N,H," + std::string(column) + "\nA,1,2,3,4\n", "c.csv").at(0).sigma.y(), 0.004, 1e-12)
        << column;
  const auto both = points_of("id,E,N,H,Accuracy_X/Y_(m),Accuracy_Z_(m)\nA,1,2,3,0.01,0.02\n", "c.csv");
  EXPECT_EQ(both.at(0).sigma, Eigen::Vector3d(0.01, 0.01, 0.02));
  EXPECT_THAT(message_of([] { points_of("id,E,N,H,std,RMS\nA,1,2,3,5,6\n", "c.csv"); }),
              HasSubstr("looks like an accuracy"));
}

/// Two for two millimetres would make every verdict worthless.
TEST(ControlFiles, StandardDeviationsOfMetresAreDoubted) {
  const auto coarse = control::parse_control("id,E,N,H,sE,sN,sH\nA,1,2,3,2,2,4\n", "c.csv");
  EXPECT_THAT(coarse.warnings, ElementsAre(HasSubstr("are taken in metres")));
  EXPECT_THAT(control::parse_control("id,E,N,H,sE,sN,sH\nA,1,2,3,.002,.002,.004\n", "c.csv").warnings, IsEmpty());
  EXPECT_THAT(control::parse_control("id,E,N,H,sigma_m\nA,1,2,3,2\n", "c.csv").warnings, IsEmpty());
  EXPECT_THAT(message_of([] { points_of("id,E_ft,N_ft,H_ft,sigma\nA,1,2,3,0.01\n", "c.csv"); }),
              HasSubstr("'sigma' has no unit"));
}

/// Gauss-Krueger coordinates with Y, the east, in front: E 5 400 100 in one entrance, 3 400 200 in the other.
TEST(ControlFiles, AxesAreThoseThatTheValuesCanOnlyBe) {
  const Eigen::Vector3d gauss_krueger(3400200.5, 5400100.25, 300);
  EXPECT_EQ(points_of("name,y,x,h\nA,3400200.5,5400100.25,300\n", "c.csv").at(0).position, gauss_krueger);
  EXPECT_EQ(points_of("Punkt;X;Y;H\nA;5400100,25;3400200,5;300\n", "c.csv").at(0).position, gauss_krueger);
  EXPECT_EQ(points_of("A 5400100.25 3400200.5 300\n", "c.csv").at(0).position, gauss_krueger);
  EXPECT_EQ(points_of("A 3400200.5 5400100.25 300\n", "c.csv").at(0).position, gauss_krueger);
  EXPECT_THAT(message_of([] { points_of("name,x,y,h\nA,5400100.25,3400200.5,300\n", "c.csv"); }),
              HasSubstr("as X has them where it is the northing"));
  const auto sigmas = points_of("name,y,x,h,sx,sy,sh\nA,3400200.5,5400100.25,300,0.001,0.002,0.003\n", "c.csv");
  EXPECT_EQ(sigmas.at(0).sigma, Eigen::Vector3d(0.002, 0.001, 0.003)) << "sx is of X, the north";
  control::ControlOptions north;
  north.axes = control::Axes::x_north;
  EXPECT_EQ(control::parse_control("name,x,y,h\nA,1,2,3\n", "c.csv", north).points.at(0).position,
            Eigen::Vector3d(2, 1, 3));
  EXPECT_THAT(message_of([&] { control::parse_control("name,e,n,h\nA,1,2,3\n", "c.csv", north); }),
              HasSubstr("says itself which coordinate is east"));
  // Potsdam, in the International Terrestrial Reference Frame: X is no northing.
  EXPECT_THAT(control::parse_control("name,x,y,z\nPOTS,3800689.6,882077.4,5028791.3\n", "c.csv").axes,
              HasSubstr("geocentric"));
}

TEST(ControlFiles, SpreadsheetsLeaveEmptyCellsRowsAndShortenedNumbers) {
  const auto points = points_of(
      "\xEF\xBB\xBFPunktnr;Ost;Nord;H\xC3\xB6he;sigma [mm];;\r\n;;;;;;\r\nA;102,5;203,25;12,125;3;;\r\n;;;;;;\r\n",
      "c.csv");
  ASSERT_EQ(points.size(), 1u);
  EXPECT_EQ(points[0].position, Eigen::Vector3d(102.5, 203.25, 12.125));
  EXPECT_DOUBLE_EQ(points[0].sigma.x(), 0.003);
  for (const char* table : {"Name;E;N;H\nA;345678,12;5,41E+06;12,1\n", "A;345678,12;5,41E+06;12,1\n"})
    EXPECT_THAT(message_of([&] { points_of(table, "c.csv"); }), HasSubstr("shortened")) << table;
  EXPECT_EQ(points_of("Name;E;N;H\nA;345678,12;5,412345678E+06;12,1\n", "c.csv").at(0).position.y(), 5412345.678);
  EXPECT_THAT(message_of([] { points_of("id,E,N,H\nA,1,5,2,5\n", "c.csv"); }),
              HasSubstr("found 5 cells under a header of 4"));
}

TEST(ControlFiles, PointsOfThePlanOrOfAHeightOnly) {
  const auto table =
      control::parse_control("id,E,N,H,sE_mm,sN_mm,sH_mm\nA,1,2,,5,6,\nB,,,3,,,2\nC,4,5,6,1,1,1\n", "c.csv");
  ASSERT_EQ(table.points.size(), 3u);
  EXPECT_TRUE(std::isnan(table.points[0].position.z()));
  EXPECT_DOUBLE_EQ(table.points[0].sigma.y(), 0.006);
  EXPECT_TRUE(table.points[1].position.head<2>().array().isNaN().all());
  EXPECT_DOUBLE_EQ(table.points[1].sigma.z(), 0.002);
  EXPECT_TRUE(table.points[2].is_whole());
  EXPECT_EQ(points_of("id,H,sigma_mm\nBM,101.25,1\n", "c.csv").at(0).position.z(), 101.25);
  EXPECT_EQ(points_of("id,E,N\nP,1,2\n", "c.csv").at(0).position.y(), 2);
  EXPECT_THAT(message_of([&] { control::require_whole(table, "c.csv", "this node"); }),
              HasSubstr("point 'A' has no height, and this node takes"));
  EXPECT_THAT(message_of([] { points_of("id,E,N,H\nA,1,,3\n", "c.csv"); }),
              HasSubstr("c.csv:2: point 'A' has one coordinate"));
  EXPECT_THAT(message_of([] { points_of("id,E,H\nA,1,3\n", "c.csv"); }), HasSubstr("the column 'N' is missing"));
  EXPECT_THAT(message_of([] { points_of("id,E,N,H\nA,,,\n", "c.csv"); }), HasSubstr("has no coordinates"));
  EXPECT_THAT(message_of([] { points_of("id,E,N,H,sE,sN,sH\nA,1,2,3,.1,,.1\n", "c.csv"); }),
              HasSubstr("lacks a standard deviation"));
}

TEST(ControlFiles, CovariancesKeepTheirCorrelations) {
  const auto points = points_of("id,E,N,H,cov_ee_mm2,cov_en_mm2,cov_nn_mm2,cov_hh_mm2\nA,1,2,3,4,3,9,1\n", "c.csv");
  EXPECT_NEAR((points.at(0).sigma - Eigen::Vector3d(0.002, 0.003, 0.001)).norm(), 0, 1e-15);
  EXPECT_NEAR(points[0].correlation(0), 0.5, 1e-12);
  EXPECT_THAT(message_of([] { points_of("id,E,N,H,cov_ee,cov_en,cov_nn,cov_hh\nA,1,2,3,4,7,9,1\n", "c.csv"); }),
              HasSubstr("not positive definite"));
}

/// Every column is used, named, or refused.
TEST(ControlFiles, NameWhatTheyDoNotUse) {
  const auto table = control::parse_control("id,E,N,H,code,date\nA,1,2,3,bolt,2026\n", "c.csv");
  EXPECT_THAT(table.notes, ElementsAre(testing::AllOf(HasSubstr("'code'"), HasSubstr("'date'"))));
  EXPECT_THAT(message_of([] { points_of("nr,name,E,N,H\n1,A,1,2,3\n", "c.csv"); }),
              HasSubstr("two columns say the same: 'nr' and 'name'"));
  EXPECT_THAT(message_of([] { points_of("id,lat,lon,H\nA,48,8,3\n", "c.csv"); }),
              HasSubstr("latitudes and longitudes"));
  EXPECT_THAT(message_of([] { points_of("P1,4500123.1,5400321.2,312.5,101\n", "c.csv"); }),
              HasSubstr("a standard deviation [m] or a code"));
  EXPECT_THAT(control::parse_control("G1,1,2,3,bolt\nG2,4,5,6,\n", "c.csv").notes,
              ElementsAre(HasSubstr("text behind the numbers")));
}

}  // namespace test_control_table
}  // namespace plumbline

// read.gcp: OpenDroneMap's gcp_list.txt and openMVS's table, as they come from other machines.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>

#include "artifacts/file.hpp"
#include "artifacts/points.hpp"
#include "control/points/openmvs_gcp.hpp"
#include "node_harness.hpp"

namespace plumbline {
namespace test_gcp_node {

using test::NodeFailed;
using test::NodeHarness;
using testing::HasSubstr;

constexpr const char* header = "gcp_label,image_file_name,x,y,x_map,y_map,elev,x_map_acc,y_map_acc,elev_acc";
const std::string table = std::string(header) +
                          "\n"
                          "A,IMG_1.JPG,1000.25,500.5,512345.123,5412678.5,431.25,0.004,0.005,0.009\n"
                          "B,IMG_1.JPG,20,30,512350,5412680,432,0.004,0.005,0.009\n"
                          "A,IMG_2.JPG,900,400,512345.123,5412678.5,431.25,0.004,0.005,0.009\n";

class ReadGcp : public testing::Test {
 protected:
  NodeHarness node{"read.gcp"};
  test::TemporaryFolder folder;

  void give(const std::string& text) {
    const auto path = folder.path() / "gcp.txt";
    std::ofstream(path, std::ios::binary) << text;
    node.set("file", path.string());
  }
  std::string failure(const std::string& text) {
    give(text);
    try {
      node.run();
    } catch (const NodeFailed& error) {
      return error.what();
    }
    return "";
  }
  std::string csv(const std::string& port) const {
    const auto content = node.output<File>(port).content;
    return {content.begin(), content.end()};
  }
};

TEST_F(ReadGcp, TakesOpenMvsTableWithItsAccuracies) {
  give(table);
  node.run();
  const PointsT points = node.output<Points>("points");
  ASSERT_EQ(points.points.size(), 2u);
  EXPECT_EQ(points.points[0]->id, "A");
  EXPECT_EQ(points.points[0]->position, Eigen::Vector3d(512345.123, 5412678.5, 431.25));
  EXPECT_EQ(points.points[0]->sigma, Eigen::Vector3d(0.004, 0.005, 0.009));
  EXPECT_EQ(csv("measured"),
            "image,point,x,y\nIMG_1.JPG,A,1000.2500,500.5000\nIMG_1.JPG,B,20.0000,30.0000\n"
            "IMG_2.JPG,A,900.0000,400.0000\n");
  EXPECT_THAT(csv("control"), HasSubstr("A,512345.123000,5412678.500000,431.250000,0.004000,0.005000,0.009000\n"));
}

/// A spreadsheet's mark in front, Windows line ends, semicolons and decimal commas, columns in another order.
TEST_F(ReadGcp, TakesItAsASpreadsheetSavesIt) {
  give(
      "\xEF\xBB\xBFimage_file_name;gcp_label;x;y;x_map;y_map;elev\r\n"
      "IMG 1.JPG;Süd;1000,25;500,5;512345,123;5412678,5;431,25\r\n");
  node.run();
  const PointsT points = node.output<Points>("points");
  ASSERT_EQ(points.points.size(), 1u);
  EXPECT_EQ(points.points[0]->id, "Süd");
  EXPECT_EQ(points.points[0]->position, Eigen::Vector3d(512345.123, 5412678.5, 431.25));
  EXPECT_TRUE(std::isnan(points.points[0]->sigma.x()));
  EXPECT_EQ(csv("measured"), "image,point,x,y\nIMG 1.JPG,Süd,1000.2500,500.5000\n");
  EXPECT_THAT(csv("control"), HasSubstr("name,E,N,H\nSüd,"));
}

/// gcp_list.txt counts from the corner of the top-left pixel, our pixels from its centre.
TEST_F(ReadGcp, TakesGcpListsAndTheirHalfPixel) {
  give("EPSG:32632\r\n# east north height column row image name\r\n512345.1\t5412678.5 431.25 100.5 50.5 a.jpg P1\r\n");
  node.run();
  EXPECT_EQ(csv("measured"), "image,point,x,y\na.jpg,P1,100.0000,50.0000\n");
  node.set("pixel_origin", "centre");
  node.run();
  EXPECT_EQ(csv("measured"), "image,point,x,y\na.jpg,P1,100.5000,50.5000\n");
}

TEST_F(ReadGcp, NamesFileLineAndMend) {
  const std::string row = "A,IMG_1.JPG,1,2,3,4,5,0.1,0.1,0.1\n";
  EXPECT_THAT(failure(header), HasSubstr("there is no row of a point"));
  EXPECT_THAT(failure(""), HasSubstr("Expected is OpenDroneMap's gcp_list.txt"));
  EXPECT_THAT(failure(table + "A,IMG_3.JPG,1,2,512345.2,5412678.5,431.25,,,\n"),
              testing::AllOf(HasSubstr("gcp.txt:5: point A has other coordinates here than in line 2")));
  EXPECT_THAT(failure(table + "B,IMG_1.JPG,1,2,512350,5412680,432,,,\n"),
              HasSubstr("gcp.txt:5: point B is measured in IMG_1.JPG a second time"));
  EXPECT_THAT(failure(table + "C,IMG_1.JPG,1,2,3\n"), HasSubstr("gcp.txt:5: the cell 'y_map' is missing"));
  EXPECT_THAT(failure(table + "C,IMG_1.JPG,1,2,x,4,5,,,\n"), HasSubstr("gcp.txt:5: 'x_map' is 'x', expected a number"));
  EXPECT_THAT(failure(table + "C,IMG_1.JPG,1,2,3,4,5,-1,,\n"), HasSubstr("gcp.txt:5: 'x_map_acc' is negative"));
  EXPECT_THAT(failure("gcp_label,image_file_name,x_map\nA,b,3\n"), HasSubstr("the column 'x' is missing"));
  EXPECT_THAT(failure("EPSG:4326\n8.1 49.2 100 5 6 a.jpg P\n"), HasSubstr("in degrees"));
}

}  // namespace test_gcp_node
}  // namespace plumbline

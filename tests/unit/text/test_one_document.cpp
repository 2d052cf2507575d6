// A second YAML document in a file: whatever reads YAML refuses it, because nothing of it would be read.
#include <functional>
#include <stdexcept>

#include "base/text/one_document.hpp"
#include "campaign_folder.hpp"
#include "control/points/image_points.hpp"
#include "photo/cameras/camera_files.hpp"
#include "photo/detect/board.hpp"
#include "photo/detect/tag_dictionary.hpp"
#include "photo/markers/layout_files.hpp"
#include "survey/model/instrument_profile.hpp"

namespace plumbline {
namespace test_one_document {

struct Reader {
  const char* name;
  std::string sound;
  std::function<void(const std::string&)> read;
};

std::ostream& operator<<(std::ostream& stream, const Reader& reader) { return stream << reader.name; }

class SecondDocument : public testing::TestWithParam<Reader> {};

std::string message_of(const Reader& reader, const std::string& text) {
  try {
    reader.read(text);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

TEST_P(SecondDocument, IsRefused) {
  const Reader& reader = GetParam();
  for (const std::string& whole : {reader.sound, "---\n" + reader.sound, reader.sound + "---\n"})
    EXPECT_EQ(message_of(reader, whole), "") << whole;
  const std::string found = message_of(reader, reader.sound + "---\n" + reader.sound);
  EXPECT_NE(found.find("a second YAML document begins here"), std::string::npos) << found;
  EXPECT_NE(found.find("the.file"), std::string::npos) << found;
}

TEST(OneDocument, ALineWithoutItsColonIsCalledThat) {
  for (const char* text : {"plumbline_campaign; 1\n# of the tower\nname: Tower\n", "board; charuco\n# mm\nrows: 8\n"}) {
    std::string found;
    try {
      text::load_one_document(text);
    } catch (const YAML::Exception& error) {
      found = error.msg;
    }
    EXPECT_EQ(found.find("---"), std::string::npos) << text << ": nobody wrote one: " << found;
    EXPECT_NE(found.find("without its colon"), std::string::npos) << text << found;
  }
}

INSTANTIATE_TEST_SUITE_P(
    OfEveryReader, SecondDocument,
    testing::Values(
        Reader{"campaign",
               "plumbline_campaign: 1\nimages: a.jpg\ncamera: c.yaml\nplates: p.csv\nsurvey: s.gsi\ndesign: d.ifc\n",
               [](const std::string& text) {
                 campaign::parse_campaign(text, "the.file", {"a.jpg", "c.yaml", "p.csv", "s.gsi", "d.ifc"});
               }},
        Reader{"camera_of_a_campaign",
               "plumbline_camera: 1\nid: c\nwidth: 600\nheight: 400\npixel_origin: centre\n"
               "parameters: {fx: 500, fy: 501, cx: 300, cy: 200}\n",
               [](const std::string& text) { campaign::parse_camera(text, "the.file"); }},
        Reader{"camera",
               "cam0:\n  camera_model: pinhole\n  intrinsics: [461.6, 460.3, 362.7, 248.1]\n"
               "  distortion_model: radtan\n  distortion_coeffs: [-0.28, 0.07, 0.0002, 1.7e-05]\n"
               "  resolution: [752, 480]\n",
               [](const std::string& text) { cameras::parse_camera_file(text, "the.file"); }},
        Reader{"layout",
               "aruco_bc_mInfoType: 1\naruco_bc_markers:\n"
               "  - {id: 3, corners: [[0, 1, 0], [1, 1, 0], [1, 0, 0], [0, 0, 0]]}\n",
               [](const std::string& text) { markers::parse_layout(text, "the.file"); }},
        Reader{"instrument_profile", "direction_arcsec: 1\nzenith_angle_arcsec: 1\ndistance_mm: 1\ndistance_ppm: 1\n",
               [](const std::string& text) { survey::parse_profile(text, "the.file"); }},
        Reader{"board", "type: chessboard\ncolumns: 9\nrows: 6\nsquare: 0.025\n",
               [](const std::string& text) { detect::parse_board(text, "the.file"); }},
        Reader{"tag_family", "nmarkers: 2\nmarkersize: 3\nmarker_0: \"110001010\"\nmarker_5: \"100111101\"\n",
               [](const std::string& text) { detect::parse_dictionary(text, "the.file"); }}),
    [](const auto& of_test) { return std::string(of_test.param.name); });

/// A detector's observations are JSON: nothing stands before it, and nothing may come after it.
TEST(ObservationsFile, WithASecondDocumentIsRefused) {
  const std::string one = "{\"images\": []}\n";
  EXPECT_TRUE(control::parse_image_points(one, "the.file", false).empty());
  EXPECT_THROW(control::parse_image_points(one + "---\n" + one, "the.file", false), std::runtime_error);
  EXPECT_THROW(control::parse_image_points(one + one, "the.file", false), std::runtime_error);
}

}  // namespace test_one_document
}  // namespace plumbline

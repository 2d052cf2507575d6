#include "image_header.hpp"

#include <gtest/gtest.h>

#include "campaign_folder.hpp"
#include "test_support.hpp"

namespace plumbline::campaign {
namespace {

std::string message_of(const std::filesystem::path& path) {
  try {
    read_image_header(path);
  } catch (const CampaignError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

class ImageHeaderTest : public testing::Test {
 protected:
  std::filesystem::path file(const std::string& name, const std::string& bytes) {
    std::ofstream(folder_.path() / name, std::ios::binary) << bytes;
    return folder_.path() / name;
  }
  test::TemporaryFolder folder_;
};

/// The smallest grey JPEG that says 16 × 8, with a restart marker and a stuffed byte in its data.
std::string tiny_jpeg() {
  using namespace std::string_literals;
  return "\xff\xd8"s + "\xff\xc0\x00\x0b\x08\x00\x08\x00\x10\x01\x01\x11\x00"s +
         "\xff\xda\x00\x08\x01\x01\x00\x00\x3f\x00"s + "\x12\xff\x00\x34\xff\xd0\x56"s + "\xff\xd9"s;
}

std::string tiny_png() {
  using namespace std::string_literals;
  return "\x89PNG\r\n\x1a\n"s + "\x00\x00\x00\x0dIHDR\x00\x00\x00\x05\x00\x00\x00\x07\x08\x00\x00\x00\x00...."s +
         "\x00\x00\x00\x00IEND...."s;
}

TEST_F(ImageHeaderTest, ReadsSizes) {
  const ImageHeader jpeg = read_image_header(file("a.jpg", tiny_jpeg()));
  EXPECT_EQ(jpeg.width, 16);
  EXPECT_EQ(jpeg.height, 8);
  EXPECT_TRUE(std::isnan(jpeg.focal_length));
  const ImageHeader png = read_image_header(file("a.png", tiny_png()));
  EXPECT_EQ(png.width, 5);
  EXPECT_EQ(png.height, 7);
}

TEST_F(ImageHeaderTest, EveryTruncationIsFound) {
  for (const std::string& whole : {tiny_jpeg(), tiny_png()}) {
    for (std::size_t n = 8; n < whole.size(); ++n) {
      EXPECT_NE(message_of(file("cut", whole.substr(0, n))).find("truncated"), std::string::npos) << n;
    }
  }
}

TEST_F(ImageHeaderTest, BytesAfterTheEndDoNotMatter) {
  EXPECT_EQ(read_image_header(file("a.jpg", tiny_jpeg() + "makers append thumbnails")).width, 16);
}

TEST_F(ImageHeaderTest, ErrorsNameTheFile) {
  EXPECT_NE(message_of(folder_.path() / "none.jpg").find("none.jpg: the image cannot be opened"), std::string::npos);
  EXPECT_NE(message_of(file("e.jpg", "")).find("e.jpg: the image is empty"), std::string::npos);
  EXPECT_NE(message_of(file("t.jpg", "some text that is no image")).find("this is no JPEG, PNG or TIFF"),
            std::string::npos);
  EXPECT_NE(message_of(file("x.tif", std::string("II*\0\xff\xff\xff\xff", 8))).find("x.tif"), std::string::npos);
}

}  // namespace
}  // namespace plumbline::campaign

// What a photograph's file says of itself: size, EXIF, and whether it is whole.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <fstream>
#include <thread>
#include <vector>

#include "photo/images/photograph_header.hpp"
#include "test_support.hpp"

namespace plumbline {
namespace test_photograph_header {

std::string message_of(const std::filesystem::path& path) {
  try {
    read_photograph_header(path, ReadTo::end_of_file);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

class PhotographHeaderTest : public testing::Test {
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

TEST_F(PhotographHeaderTest, ReadsSizes) {
  const PhotographHeader jpeg = read_photograph_header(file("a.jpg", tiny_jpeg()));
  EXPECT_EQ(jpeg.width, 16);
  EXPECT_EQ(jpeg.height, 8);
  EXPECT_TRUE(std::isnan(jpeg.focal_length));
  const PhotographHeader png = read_photograph_header(file("a.png", tiny_png()));
  EXPECT_EQ(png.width, 5);
  EXPECT_EQ(png.height, 7);
}

/// Nothing said that photographs were compressed to a quality of 20, which moves every corner.
TEST_F(PhotographHeaderTest, QualityOfAJpegIsThatOfItsTableOfBrightness) {
  using namespace std::string_literals;
  const auto quality = [&](const std::string& tables) {
    const std::string jpeg = tiny_jpeg();
    return read_photograph_header(file("q.jpg", jpeg.substr(0, 2) + tables + jpeg.substr(2))).jpeg_quality;
  };
  // Values of 144 on the average are 2.5 times those of the standard: 20; of 29 half: 75.
  EXPECT_EQ(quality("\xff\xdb\x00\x43\x00"s + std::string(64, '\x90')), 20);
  EXPECT_EQ(quality("\xff\xdb\x00\x43\x00"s + std::string(64, '\x1d')), 75);
  EXPECT_EQ(quality("\xff\xdb\x00\x43\x00"s + std::string(64, '\x01')), 99);
  // Half as coarse again as the standard, and a second table of brightness, which is that of another scan.
  EXPECT_EQ(quality("\xff\xdb\x00\x43\x00"s + std::string(64, '\x50')), 36);
  EXPECT_EQ(
      quality("\xff\xdb\x00\x43\x00"s + std::string(64, '\x50') + "\xff\xdb\x00\x43\x00"s + std::string(64, '\x01')),
      36);
  // That of colours comes first and does not count; of two bytes a value.
  std::string words;
  for (int k = 0; k < 64; ++k) words += "\x00\x90"s;
  EXPECT_EQ(quality("\xff\xdb\x00\xc4\x01"s + std::string(64, '\xff') + "\x10"s + words), 20);
  EXPECT_EQ(quality("\xff\xdb\x00\x23\x00"s + std::string(32, '\x90')), 0) << "damaged";
  EXPECT_EQ(quality(""), 0);
}

TEST_F(PhotographHeaderTest, EveryTruncationIsFound) {
  for (const std::string& whole : {tiny_jpeg(), tiny_png()}) {
    for (std::size_t n = 8; n < whole.size(); ++n) {
      EXPECT_NE(message_of(file("cut", whole.substr(0, n))).find("truncated"), std::string::npos) << n;
    }
  }
}

TEST_F(PhotographHeaderTest, BytesAfterTheEndDoNotMatter) {
  EXPECT_EQ(read_photograph_header(file("a.jpg", tiny_jpeg() + "makers append thumbnails"), ReadTo::end_of_file).width,
            16);
}

TEST_F(PhotographHeaderTest, ErrorsSayWhatIsWrong) {
  EXPECT_NE(message_of(folder_.path() / "none.jpg").find("the image cannot be opened"), std::string::npos);
  EXPECT_NE(message_of(file("e.jpg", "")).find("the image is empty"), std::string::npos);
  EXPECT_NE(message_of(file("t.jpg", "some text that is no image")).find("this is no JPEG, PNG or TIFF"),
            std::string::npos);
  EXPECT_NE(message_of(file("x.tif", std::string("II*\0\xff\xff\xff\xff", 8))).find("the TIFF is truncated"),
            std::string::npos);
}

/// Little-endian TIFF structure: make, model, orientation, and in a directory of its own date, focal length, 35 mm
/// equivalent, serial; with the tags that a TIFF of 16 × 8 pixels has beside them.
std::string exif_structure(bool with_image) {
  using namespace std::string_literals;
  const auto two = [](unsigned v) { return std::string{static_cast<char>(v & 255), static_cast<char>(v >> 8)}; };
  const auto four = [&](unsigned v) { return two(v & 65535) + two(v >> 16); };
  const auto entry = [&](unsigned tag, unsigned type, unsigned count, const std::string& value) {
    return two(tag) + two(type) + four(count) + value;
  };
  const unsigned entries = with_image ? 8 : 4;
  const unsigned behind = 8 + 2 + entries * 12 + 4, photo = behind + 8 + 12, values = photo + 2 + 4 * 12 + 4;
  std::string block = "II*\0"s + four(8) + two(entries);
  if (with_image) block += entry(0x0100, 4, 1, four(16)) + entry(0x0101, 4, 1, four(8));
  block += entry(0x010f, 2, 7, four(behind)) + entry(0x0110, 2, 12, four(behind + 8));
  if (with_image) block += entry(0x0111, 4, 1, four(8));
  block += entry(0x0112, 3, 1, two(6) + two(0));
  if (with_image) block += entry(0x0117, 4, 1, four(128));
  block += entry(0x8769, 4, 1, four(photo)) + four(0);
  block += "Plumbo\0\0"s + "Plumbo X100\0"s;
  block += two(4) + entry(0x9003, 2, 20, four(values)) + entry(0x920a, 5, 1, four(values + 20)) +
           entry(0xa405, 3, 1, two(24) + two(0)) + entry(0xa431, 2, 4, "A-7\0"s) + four(0);
  return block + "2026:05:04 09:02:00\0"s + four(2400) + four(100);
}

std::string exif_block() {
  using namespace std::string_literals;
  return "Exif\0\0"s + exif_structure(false);
}

std::string jpeg_with_exif() {
  using namespace std::string_literals;
  const std::string jpeg = tiny_jpeg(), block = exif_block();
  const auto length = static_cast<unsigned>(block.size() + 2);
  return jpeg.substr(0, 2) + "\xff\xe1"s + static_cast<char>(length >> 8) + static_cast<char>(length & 255) + block +
         jpeg.substr(2);
}

/// Its directory stands in front, so half a TIFF was taken for a whole one until somebody read its pixels.
TEST_F(PhotographHeaderTest, ATiffThatLacksItsPixelsIsTruncated) {
  using namespace std::string_literals;
  const std::string tiff = "II*\0\x08\0\0\0\x04\0"s + "\0\x01\x04\0\x01\0\0\0\x10\0\0\0"s +
                           "\x01\x01\x04\0\x01\0\0\0\x08\0\0\0"s + "\x11\x01\x04\0\x01\0\0\0\x3e\0\0\0"s +
                           "\x17\x01\x04\0\x01\0\0\0\x80\0\0\0"s + std::string(4 + 128, '\0');
  EXPECT_EQ(message_of(file("whole.tif", tiff)), "nothing was thrown");
  for (const std::size_t n : {tiff.size() - 1, tiff.size() - 128, std::size_t{30}})
    EXPECT_NE(message_of(file("cut.tif", tiff.substr(0, n))).find("the TIFF is truncated"), std::string::npos) << n;
}

TEST_F(PhotographHeaderTest, ReadsExif) {
  for (const auto& path : {file("a.jpg", jpeg_with_exif()), file("a.tif", exif_structure(true))}) {
    const PhotographHeader header = read_photograph_header(path);
    EXPECT_EQ(header.width, 16) << path;
    EXPECT_EQ(header.model, "Plumbo X100") << "the make is not said twice";
    EXPECT_EQ(header.serial, "A-7");
    EXPECT_EQ(header.taken_at, "2026:05:04 09:02:00");
    EXPECT_NEAR(header.focal_length, 0.024, 1e-9) << path;
    EXPECT_EQ(header.orientation, 6);
    EXPECT_NEAR(header.principal_distance, 24 / 43.2666 * std::hypot(16, 8), 1e-9);
  }
}

/// A damaged EXIF is a pity, the pixels are not: whatever of it can be read is, and nothing is read beyond it.
TEST_F(PhotographHeaderTest, DamagedExifDoesNotSpoilTheSize) {
  const std::string whole = jpeg_with_exif();
  const std::size_t begin = whole.find("Exif"), end = begin + exif_block().size();
  for (std::size_t at = begin; at < end; ++at)
    for (const char value : {'\0', '\x7f', '\xff'}) {
      std::string damaged = whole;
      damaged[at] = value;
      EXPECT_EQ(read_photograph_header(file("a.jpg", damaged)).width, 16) << at;
    }
}

/// Eight threads blamed sound photographs in every second run.
TEST_F(PhotographHeaderTest, ThreadsDoNotDisturbEachOther) {
  const auto path = file("a.jpg", jpeg_with_exif());
  std::atomic<int> wrong = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 8; ++t)
    threads.emplace_back([&] {
      for (int i = 0; i < 200; ++i) try {
          const PhotographHeader header = read_photograph_header(path);
          wrong += header.model != "Plumbo X100" || header.orientation != 6;
        } catch (const std::exception&) {
          ++wrong;
        }
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace test_photograph_header
}  // namespace plumbline

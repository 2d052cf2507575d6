// Reading image files: JPEG, PNG, TIFF, and what is said of damaged ones.
#include <gmock/gmock.h>
#include <jpeglib.h>
#include <png.h>
#include <tiffio.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>

#include "photo/images/grey_image.hpp"
#include "photo/images/grey_rows.hpp"
#include "photo/images/motion_blur.hpp"
#include "photo/images/photograph_header.hpp"
#include "photo/images/visibility.hpp"
#include "test_support.hpp"

namespace plumbline {
namespace test_grey_image {

using testing::AllOf;
using testing::HasSubstr;

constexpr int kWidth = 37, kHeight = 21;

/// A smooth ramp, so that JPEG's loss stays below three grey values.
std::vector<std::uint8_t> ramp(int channels) {
  std::vector<std::uint8_t> pixels;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < channels; ++c) pixels.push_back(static_cast<std::uint8_t>(40 + 3 * x + 2 * y));
  return pixels;
}

void write_jpeg(const std::filesystem::path& path, J_COLOR_SPACE space = JCS_RGB, int channels = 3) {
  jpeg_compress_struct cinfo{};
  jpeg_error_mgr errors{};
  cinfo.err = jpeg_std_error(&errors);
  jpeg_create_compress(&cinfo);
  std::FILE* file = std::fopen(path.c_str(), "wb");
  jpeg_stdio_dest(&cinfo, file);
  cinfo.image_width = kWidth, cinfo.image_height = kHeight, cinfo.input_components = channels,
  cinfo.in_color_space = space;
  jpeg_set_defaults(&cinfo);
  jpeg_set_quality(&cinfo, 98, TRUE);
  jpeg_start_compress(&cinfo, TRUE);
  auto pixels = ramp(channels);
  for (int y = 0; y < kHeight; ++y) {
    JSAMPROW row = pixels.data() + y * kWidth * channels;
    jpeg_write_scanlines(&cinfo, &row, 1);
  }
  jpeg_finish_compress(&cinfo);
  jpeg_destroy_compress(&cinfo);
  std::fclose(file);
}

void write_png(const std::filesystem::path& path) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = kWidth, image.height = kHeight, image.format = PNG_FORMAT_RGB;
  ASSERT_TRUE(png_image_write_to_file(&image, path.c_str(), 0, ramp(3).data(), 0, nullptr));
}

void write_tiff(const std::filesystem::path& path, int orientation) {
  TIFF* tiff = TIFFOpen(path.c_str(), "w");
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, kWidth);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, kHeight);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, TIFFTAG_ORIENTATION, orientation);
  TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 4);
  auto pixels = ramp(1);
  for (int y = 0; y < kHeight; ++y)
    TIFFWriteScanline(tiff, pixels.data() + y * kWidth, static_cast<std::uint32_t>(y), 0);
  TIFFClose(tiff);
}

void expect_ramp(const GreyImage& image, int tolerance) {
  ASSERT_EQ(image.width, kWidth);
  ASSERT_EQ(image.height, kHeight);
  const auto expected = ramp(1);
  for (std::size_t i = 0; i < expected.size(); ++i)
    ASSERT_NEAR(image.pixels[i], expected[i], tolerance) << "pixel " << i;
}

std::string message_of(const std::filesystem::path& path) {
  try {
    read_grey_image(path);
  } catch (const ImageFileError& error) {
    return error.what();
  }
  return "";
}

std::filesystem::path cut(const std::filesystem::path& path, double share) {
  const std::string bytes = test::read_file(path);
  const std::filesystem::path out = path.string() + ".cut";
  std::ofstream(out, std::ios::binary) << bytes.substr(
      0, static_cast<std::size_t>(share * static_cast<double>(bytes.size())));
  return out;
}

TEST(GreyImage, ReadsJpegPngAndTiffByContent) {
  const test::TemporaryFolder folder;
  write_jpeg(folder.path() / "a.bin");
  expect_ramp(read_grey_image(folder.path() / "a.bin"), 3);
  write_png(folder.path() / "b.bin");
  expect_ramp(read_grey_image(folder.path() / "b.bin"), 0);
  write_tiff(folder.path() / "c.bin", ORIENTATION_TOPLEFT);
  expect_ramp(read_grey_image(folder.path() / "c.bin"), 0);
}

TEST(GreyImage, LeavesThePixelsWhereTheSensorHadThem) {
  const test::TemporaryFolder folder;
  write_tiff(folder.path() / "turned.tif", ORIENTATION_BOTRIGHT);
  expect_ramp(read_grey_image(folder.path() / "turned.tif"), 0);
}

TEST(GreyImage, RefusesTruncatedFilesByName) {
  const test::TemporaryFolder folder;
  write_jpeg(folder.path() / "a.jpg");
  write_png(folder.path() / "b.png");
  write_tiff(folder.path() / "c.tif", ORIENTATION_TOPLEFT);
  for (const double share : {0.3, 0.6, 0.95}) {
    EXPECT_THAT(message_of(cut(folder.path() / "a.jpg", share)),
                AllOf(HasSubstr("a.jpg.cut: "), HasSubstr("truncated JPEG")));
    EXPECT_THAT(message_of(cut(folder.path() / "b.png", share)),
                AllOf(HasSubstr("b.png.cut: "), HasSubstr("truncated PNG")));
    EXPECT_THAT(message_of(cut(folder.path() / "c.tif", share)),
                AllOf(HasSubstr("c.tif.cut: "), HasSubstr("truncated TIFF")));
  }
}

TEST(GreyImage, RefusesAJpegWithDamagedData) {
  const test::TemporaryFolder folder;
  write_jpeg(folder.path() / "a.jpg");
  std::string bytes = test::read_file(folder.path() / "a.jpg");
  // A marker in the middle of the entropy-coded data, as a bad block on a memory card leaves.
  const std::size_t scan = bytes.rfind("\xff\xda");
  bytes[(scan + bytes.size()) / 2] = '\xff';
  bytes[(scan + bytes.size()) / 2 + 1] = '\xc4';
  std::ofstream(folder.path() / "a.jpg", std::ios::binary) << bytes;
  EXPECT_THAT(message_of(folder.path() / "a.jpg"), HasSubstr("damaged"));
}

TEST(GreyImage, NamesTheColoursOfAPrintingPress) {
  const test::TemporaryFolder folder;
  write_jpeg(folder.path() / "a.jpg", JCS_CMYK, 4);
  EXPECT_THAT(message_of(folder.path() / "a.jpg"), AllOf(HasSubstr("a.jpg: "), HasSubstr("CMYK")));
}

TEST(GreyImage, RefusesWhatIsNoImage) {
  const test::TemporaryFolder folder;
  EXPECT_THAT(message_of(folder.path() / "missing.jpg"), HasSubstr("missing.jpg: no such image file"));
  EXPECT_THAT(message_of(folder.path()), HasSubstr("is not a file"));
  std::ofstream(folder.path() / "empty.jpg").flush();
  EXPECT_THAT(message_of(folder.path() / "empty.jpg"), HasSubstr("empty"));
  std::ofstream(folder.path() / "text.jpg") << "hello";
  EXPECT_THAT(message_of(folder.path() / "text.jpg"), HasSubstr("neither JPEG, PNG nor TIFF"));
  std::ofstream(folder.path() / "phone.jpg") << std::string(
      "\0\0\0\x18"
      "ftypheic\0\0\0\0mif1",
      20);
  EXPECT_THAT(message_of(folder.path() / "phone.jpg"), HasSubstr("phone.jpg: is HEIC"));
}

TEST(GreyImage, RefusesSixteenBitsOfWhichTheUpperOnesAreNotUsed) {
  const test::TemporaryFolder folder;
  for (const int factor : {16, 256}) {  // 12 bits and 16
    TIFF* tiff = TIFFOpen((folder.path() / "a.tif").c_str(), "w");
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, kWidth);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, kHeight);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 16);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    auto pixels = ramp(1);
    for (int y = 0; y < kHeight; ++y) {
      std::vector<std::uint16_t> row;
      for (int x = 0; x < kWidth; ++x) row.push_back(static_cast<std::uint16_t>(factor * pixels[y * kWidth + x]));
      TIFFWriteScanline(tiff, row.data(), static_cast<std::uint32_t>(y), 0);
    }
    TIFFClose(tiff);
    if (factor == 16)
      EXPECT_THAT(message_of(folder.path() / "a.tif"), HasSubstr("12 or 14 bits"));
    else
      expect_ramp(read_grey_image(folder.path() / "a.tif"), 1);
  }
}

/// A vertical step from `dark` to `bright`, blurred by a Gaussian.
GreyImage step(double dark, double bright, double sigma) {
  GreyImage image{200, 100, {}};
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      image.pixels.push_back(static_cast<std::uint8_t>(
          std::lround(dark + (bright - dark) * 0.5 * std::erfc(-(x - 100) / (sigma * std::sqrt(2.0))))));
  return image;
}

TEST(PhotographNames, ThoseOfFormatsThatAreNotReadAreNamed) {
  const std::string text = unread_photographs({"b/2.HEIC", "notes.txt", "a.webp", "1.jpg", "survey/day1.gsi"});
  EXPECT_THAT(text,
              testing::AllOf(testing::HasSubstr("a.webp, b/2.HEIC"), testing::HasSubstr("export them"),
                             testing::Not(testing::HasSubstr("notes")), testing::Not(testing::HasSubstr("1.jpg"))));
  EXPECT_EQ(unread_photographs({"1.jpg", "camera.yaml"}), "");
  EXPECT_THAT(unread_photographs(std::vector<std::string>(12, "x.dng")), testing::HasSubstr("and 2 more"));
}

TEST(Visibility, BlurOfAnEdgeIsFound) {
  for (const double sigma : {2.0, 5.0, 9.0}) {
    const Visibility seen = visibility(step(20, 220, sigma));
    EXPECT_NEAR(seen.edge_sigma, sigma, 0.1 * sigma);
    EXPECT_EQ(seen.darkest, 20);
    EXPECT_EQ(seen.brightest, 220);
  }
}

TEST(Visibility, SaysWhatKeepsTagsFromBeingFound) {
  EXPECT_THAT(why_nothing_is_found(step(0, 10, 1)), HasSubstr("dark"));
  EXPECT_THAT(why_nothing_is_found(step(250, 255, 1)), HasSubstr("overexposed"));
  EXPECT_THAT(why_nothing_is_found(step(120, 140, 1)), HasSubstr("contrast"));
  EXPECT_THAT(why_nothing_is_found(step(40, 200, 250)), HasSubstr("contrast")) << "light that changes is no contrast";
  EXPECT_THAT(why_nothing_is_found(step(20, 220, 8)), AllOf(HasSubstr("blur of 8 px"), HasSubstr("out of focus")));
  EXPECT_EQ(why_nothing_is_found(step(20, 220, 1)), "");
  EXPECT_EQ(why_nothing_is_found(step(100, 140, 3)), "");
}

/// Squares of 20 px, turned by `turn` [rad], averaged over `length` px along `direction`, two steps to a pixel.
GreyImage squares(double turn, double length, double direction) {
  GreyImage image{240, 200, {}};
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      double sum = 0;
      const int steps = 1 + static_cast<int>(2 * length);
      for (int k = 0; k < steps; ++k) {
        const double by = steps > 1 ? length * (k / (steps - 1.0) - 0.5) : 0;
        const double px = x + by * std::cos(direction), py = y + by * std::sin(direction);
        const double u = std::sin((std::cos(turn) * px + std::sin(turn) * py) * std::numbers::pi / 20),
                     v = std::sin((std::cos(turn) * py - std::sin(turn) * px) * std::numbers::pi / 20);
        sum += std::clamp(0.5 + 4 * u * v, 0.0, 1.0) / steps;
      }
      image.pixels.push_back(static_cast<std::uint8_t>(std::lround(20 + 200 * sum)));
    }
  return image;
}

TEST(MotionBlur, IsFoundWithItsDirection) {
  const double quarter = 0.25 * std::numbers::pi;
  const std::pair<double, const char*> directions[] = {{0, "blurred from left to right"},
                                                       {quarter, "from the top left to the bottom right"},
                                                       {2 * quarter, "up and down"},
                                                       {3 * quarter, "from the bottom left to the top right"}};
  for (const auto& [direction, words] : directions) {
    const MotionBlur blur = motion_blur(squares(direction, 12, direction));
    EXPECT_TRUE(blur.found()) << blur.most << " " << blur.least;
    EXPECT_NEAR(blur.direction, direction, 1e-9);
    EXPECT_THAT(in_words(blur), HasSubstr(words));
    EXPECT_THAT(why_nothing_is_found(squares(direction, 12, direction)), HasSubstr(words));
  }
}

TEST(MotionBlur, IsNoneOfWhatIsSharpOrBlurredAllRound) {
  for (const double turn : {0.0, 0.3, 0.8}) {
    EXPECT_EQ(in_words(motion_blur(squares(turn, 0, 0))), "");
    EXPECT_EQ(in_words(motion_blur(squares(turn, 2, 0))), "") << "less than the edges are wide";
  }
  EXPECT_EQ(in_words(motion_blur(step(20, 220, 8))), "") << "edges of one direction do not tell";
  EXPECT_EQ(in_words(motion_blur(GreyImage{16, 16, std::vector<std::uint8_t>(256)})), "");
}

TEST(GreyRows, GiveTheSamePixelsAsTheWholeImageAndAsAPart) {
  const test::TemporaryFolder folder;
  const auto jpeg = folder.path() / "a.jpg", png = folder.path() / "a.png";
  write_jpeg(jpeg);
  write_png(png);
  for (const auto& path : {jpeg, png}) {
    const GreyImage whole = read_grey_image(path);
    const auto rows = open_grey_rows(path);
    ASSERT_EQ(rows->width(), kWidth);
    ASSERT_EQ(rows->height(), kHeight);
    std::vector<std::uint8_t> row(kWidth);
    for (int y = 0; y < kHeight; ++y) {
      rows->next(row.data());
      EXPECT_TRUE(std::equal(row.begin(), row.end(), whole.pixels.begin() + y * kWidth)) << path << y;
    }
    const GreyImage part = read_grey_part(path, 30, 11, 20, 5);
    ASSERT_EQ(part.width, kWidth - 30);
    ASSERT_EQ(part.height, 5);
    for (int y = 0; y < part.height; ++y)
      for (int x = 0; x < part.width; ++x)
        EXPECT_EQ(part.pixels[y * part.width + x], whole.pixels[(11 + y) * kWidth + 30 + x]);
    EXPECT_THROW(read_grey_part(path, 40, 0, 5, 5), ImageFileError);
  }
}

TEST(GreyRows, NameAFileThatEndsEarlyOrIsMissing) {
  const test::TemporaryFolder folder;
  write_jpeg(folder.path() / "a.jpg");
  const std::string bytes = test::read_file(folder.path() / "a.jpg");
  std::ofstream(folder.path() / "cut.jpg", std::ios::binary) << bytes.substr(0, bytes.size() - 200);
  const auto failure = [](auto&& call) -> std::string {
    try {
      call();
    } catch (const ImageFileError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(failure([&] {
                const auto rows = open_grey_rows(folder.path() / "cut.jpg");
                std::vector<std::uint8_t> row(kWidth);
                for (int y = 0; y < kHeight; ++y) rows->next(row.data());
              }),
              AllOf(HasSubstr("cut.jpg"), HasSubstr("truncated JPEG")));
  EXPECT_THAT(failure([&] { open_grey_rows(folder.path() / "none.jpg"); }), HasSubstr("no such image file"));
  EXPECT_THAT(failure([&] { open_grey_rows(folder.path()); }), HasSubstr("is not a file"));
}

}  // namespace test_grey_image
}  // namespace plumbline

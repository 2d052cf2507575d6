#include "photo/images/grey_rows.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "photo/images/grey_image_decoders.hpp"

namespace plumbline {
namespace {

/// Rows of an image that is somebody else's, or its own.
class HeldRows : public GreyRows {
 public:
  explicit HeldRows(const GreyImage& image) : image_(image) {
    width_ = image.width;
    height_ = image.height;
  }
  explicit HeldRows(std::unique_ptr<GreyImage> image) : HeldRows(*image) { own_ = std::move(image); }
  void next(std::uint8_t* row) override {
    const auto width = static_cast<std::size_t>(width_);
    std::copy_n(image_.pixels.begin() + static_cast<std::ptrdiff_t>(row_++ * width), width, row);
  }
  void skip(int count) override { row_ += static_cast<std::size_t>(count); }

 private:
  const GreyImage& image_;
  std::unique_ptr<GreyImage> own_;
  std::size_t row_ = 0;
};

/// Rows whose errors name the file.
class NamedRows : public GreyRows {
 public:
  NamedRows(std::unique_ptr<GreyRows> rows, std::string path) : rows_(std::move(rows)), path_(std::move(path)) {
    width_ = rows_->width();
    height_ = rows_->height();
  }
  void next(std::uint8_t* row) override {
    named([&] { rows_->next(row); });
  }
  void skip(int count) override {
    named([&] { rows_->skip(count); });
  }

 private:
  template <class Call>
  void named(Call&& call) {
    try {
      call();
    } catch (const ImageFileError& error) {
      throw ImageFileError(path_ + ": " + error.what());
    }
  }
  std::unique_ptr<GreyRows> rows_;
  std::string path_;
};

}  // namespace

std::unique_ptr<GreyRows> open_grey_rows(const std::filesystem::path& path) {
  if (!image_decoders::is_jpeg(path))
    return std::make_unique<HeldRows>(std::make_unique<GreyImage>(read_grey_image(path)));
  try {
    return std::make_unique<NamedRows>(image_decoders::open_jpeg(path), path.string());
  } catch (const ImageFileError& error) {
    throw ImageFileError(path.string() + ": " + error.what());
  }
}

std::unique_ptr<GreyRows> rows_of(const GreyImage& image) { return std::make_unique<HeldRows>(image); }

GreyImage part_of(const GreyImage& image, int left, int top, int width, int height) {
  const int first = std::max(left, 0), last = std::min(left + width, image.width);
  const int begin = std::max(top, 0), end = std::min(top + height, image.height);
  GreyImage part{std::max(0, last - first), std::max(0, end - begin), {}};
  for (int y = begin; y < end; ++y) {
    const auto row = image.pixels.begin() + static_cast<std::ptrdiff_t>(y) * image.width;
    part.pixels.insert(part.pixels.end(), row + first, row + std::max(first, last));
  }
  return part;
}

GreyImage read_grey_part(const std::filesystem::path& path, int left, int top, int width, int height) {
  const auto rows = open_grey_rows(path);
  const int first = std::max(left, 0), last = std::min(left + width, rows->width());
  const int begin = std::max(top, 0), end = std::min(top + height, rows->height());
  if (first >= last || begin >= end)
    throw ImageFileError(path.string() + ": the part that begins at (" + std::to_string(left) + ", " +
                         std::to_string(top) + ") is outside of the image of " + std::to_string(rows->width()) + " x " +
                         std::to_string(rows->height()) + " pixels");
  GreyImage part{last - first, end - begin, {}};
  part.pixels.reserve(static_cast<std::size_t>(part.width) * part.height);
  std::vector<std::uint8_t> row(static_cast<std::size_t>(rows->width()));
  rows->skip(begin);
  for (int y = begin; y < end; ++y) {
    rows->next(row.data());
    part.pixels.insert(part.pixels.end(), row.begin() + first, row.begin() + last);
  }
  return part;
}

}  // namespace plumbline

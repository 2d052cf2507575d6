// A photograph row by row, and a part of one: for images that are too large to be held.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "photo/images/grey_image.hpp"

namespace plumbline {

/// The rows of a photograph from the top down. Baseline JPEG files are decoded as they are read and never held whole; a
/// progressive JPEG keeps its coefficients, PNG and TIFF the whole image.
class GreyRows {
 public:
  virtual ~GreyRows() = default;
  int width() const { return width_; }    ///< [px]
  int height() const { return height_; }  ///< [px]

  /// Writes the next row, width() grey values as read_grey_image() has them; to be called height() times at most.
  /// Throws ImageFileError for a file that is damaged or ends early.
  virtual void next(std::uint8_t* row) = 0;
  /// Passes over `count` rows.
  virtual void skip(int count) = 0;

 protected:
  int width_ = 0, height_ = 0;
};

/// Opens a JPEG, PNG or TIFF file. Throws ImageFileError.
std::unique_ptr<GreyRows> open_grey_rows(const std::filesystem::path& path);

/// The rows of an image in memory, which has to stay there.
std::unique_ptr<GreyRows> rows_of(const GreyImage& image);

/// The part of an image in memory, cut off where it leaves it.
GreyImage part_of(const GreyImage& image, int left, int top, int width, int height);

/// The part of a photograph that begins in column `left` and row `top`, cut off where it leaves the image; rows above
/// are skipped without being turned into pixels. Throws ImageFileError, and for a part that is wholly outside.
GreyImage read_grey_part(const std::filesystem::path& path, int left, int top, int width, int height);

}  // namespace plumbline

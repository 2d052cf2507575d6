// Codes of square tags and their decoding from the grey values of an image, for the families of libapriltag and for
// dictionaries of ArUco markers alike.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "photo/detect/tag_dictionary.hpp"

namespace plumbline::detect {

/// A family of square tags. Cells are counted from the upper left corner of the square that is looked for (the border's
/// outer edge), `modules` cells a side; cells of the code may lie outside of it.
struct SquareFamily {
  std::string name;
  int modules = 0;
  bool bright_inside = false;  ///< the square is brighter than its surroundings (tagStandard, tagCircle, tagCustom)
  std::vector<std::array<int, 2>> cells;  ///< column and row of every bit, the highest bit first
  std::vector<std::uint64_t> codes;
  std::vector<int> ids;      ///< of `codes`
  int border = 1;            ///< cells of the black border, see TagDictionary
  int correctable_bits = 0;  ///< wrong bits that can be corrected without doubt, from the codes' smallest distance
};

/// "b2" at the end of a name: with a border of two cells. Throws std::runtime_error for a name that libapriltag does
/// not know.
SquareFamily apriltag_square_family(const std::string& name);
/// Throws std::runtime_error for markers of more than 8 × 8 cells.
SquareFamily dictionary_square_family(const TagDictionary& dictionary);

/// Either of the two by its name.
SquareFamily square_family(const std::string& name);

/// The part of an image that is held, in the image's own coordinates.
struct PixelRows {
  int left = 0, right = 0, first = 0, end = 0;  ///< columns left ... right - 1, rows first ... end - 1
  const std::uint8_t* const* rows = nullptr;    ///< by row of the image, from column `left` on
  bool holds(double x, double y) const { return x >= left && y >= first && x <= right - 1 && y <= end - 1; }
  /// Bilinear; needs holds(x, y).
  float at(double x, double y) const {
    const int i = std::min(static_cast<int>(x), right - 2), j = std::min(static_cast<int>(y), end - 2);
    const float u = static_cast<float>(x - i), v = static_cast<float>(y - j);
    const std::uint8_t *a = rows[j] + (i - left), *b = rows[j + 1] + (i - left);
    const float upper = static_cast<float>(a[0]) + u * static_cast<float>(a[1] - a[0]);
    const float lower = static_cast<float>(b[0]) + u * static_cast<float>(b[1] - b[0]);
    return upper + v * (lower - upper);
  }
};

/// Plane projectivity from cells (0 … modules, from the upper left corner) to the image; `corners` clockwise from the
/// upper left.
Eigen::Matrix3d image_from_cells(const std::array<Eigen::Vector2d, 4>& corners, int modules);

/// Probability that cells of chance are read as a code, in one of four turns and with up to `corrected` wrong bits.
double chance_of_code(std::size_t codes, std::size_t bits, int corrected);

struct ReadCode {
  int id = 0, hamming = 0;
  double decision_margin = 0;  ///< mean distance of the cells from the threshold, the smaller of black and white
  std::array<Eigen::Vector2d, 4> corners;  ///< bottom left, bottom right, top right, top left of the upright tag [px]
};

struct CodeReading {
  std::optional<ReadCode> code;
  bool mirrored = false;  ///< no code, but one of the family, without an error, seen in a mirror
};

class SquareDecoder {
 public:
  SquareDecoder(const SquareFamily& family, int max_hamming);
  const SquareFamily& family() const { return family_; }
  /// Probability that cells of chance are read as a code.
  double chance() const;

  /// `corners` clockwise as seen [px, centre of the first pixel (0, 0)], right to a fifth of a cell.
  CodeReading read(const PixelRows& image, const std::array<Eigen::Vector2d, 4>& corners) const;

 private:
  std::optional<std::array<int, 2>> find(std::uint64_t code) const;  // index and distance
  void read_cells(const std::vector<double>& above, const std::array<Eigen::Vector2d, 4>& corners,
                  CodeReading& result) const;

  SquareFamily family_;
  int max_hamming_;
  std::array<std::vector<std::size_t>, 4> turned_;  // by quarter turn, for each bit the bit that is seen in its place
  std::vector<std::size_t> mirrored_;
  std::unordered_map<std::uint64_t, int> exact_;
};

}  // namespace plumbline::detect

// The drawing of a tag, cell by cell.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace plumbline::test {

struct TagCells {
  int total = 0, border = 0;  ///< cells each way: with the white around it, and at the outside of the black border
  std::vector<std::uint8_t> white;  ///< row by row from the top, above 127 is white
  /// Outside of the drawing it is white. Cells from the centre, y up.
  bool at(double x, double y) const {
    const int i = static_cast<int>(std::floor(x + 0.5 * total)), j = static_cast<int>(std::floor(0.5 * total - y));
    if (i < 0 || j < 0 || i >= total || j >= total) return true;
    return white[j * total + i] > 127;
  }
};

TagCells cells_of(const std::string& family, int id);

}  // namespace plumbline::test

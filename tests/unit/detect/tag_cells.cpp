// Of every family that the detectors know, as libapriltag draws it.
#include "tag_cells.hpp"

#include <apriltag/apriltag.h>
#include <apriltag/common/image_u8.h>

#include "photo/detect/tag_family.hpp"

namespace plumbline::test {

TagCells cells_of(const std::string& name, int id) {
  const auto family = detect::make_tag_family(name);
  image_u8_t* picture = apriltag_to_image(family.get(), id);
  TagCells cells{static_cast<int>(family->total_width), static_cast<int>(family->width_at_border), {}};
  for (int y = 0; y < cells.total; ++y)
    for (int x = 0; x < cells.total; ++x) cells.white.push_back(picture->buf[y * picture->stride + x]);
  image_u8_destroy(picture);
  return cells;
}

}  // namespace plumbline::test

// For the installed kit of detectors: the one tag that it draws, so that it takes no detector's library.
#include <stdexcept>

#include "tag_cells.hpp"

namespace plumbline::test {

TagCells cells_of(const std::string& family, int id) {
  if (family != "tag36h11" || id != 7) throw std::runtime_error("only tag 7 of tag36h11 is drawn here");
  TagCells cells{10, 8, {}};
  for (const char* row : {"##########", "#........#", "#....#...#", "#....##..#", "#..#.#...#", "#.#.###..#",
                          "#....###.#", "#..#.#...#", "#........#", "##########"})
    for (const char* c = row; *c; ++c) cells.white.push_back(*c == '#' ? 255 : 0);
  return cells;
}

}  // namespace plumbline::test

// Which column of staked points is what.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline::loop {

/// A tool's own order unless the head of the table says otherwise.
struct StakedColumns {
  std::size_t name = 0, east = 1, north = 2, height = 3, date = std::string::npos;
  std::size_t most() const { return std::max({name, east, north, height}); }
};

/// Takes the head's word for the order of the columns if it names all three: those that say that they were staked, then
/// those that say nothing else. Throws std::runtime_error for a unit that is not metres, for a head that names where
/// points were to be and not where they are, for one that names some of the coordinates, because the tool's own order
/// may contradict it, and for two columns that say the same. Columns that are not read are named in `ignored`.
void read_head(const std::vector<std::string_view>& cells, const std::string& source, StakedColumns& columns,
               std::vector<std::string>& ignored);

/// Whether a line names easting, northing and height: a head, wherever it stands.
bool names_all_coordinates(const std::vector<std::string_view>& cells);

}  // namespace plumbline::loop

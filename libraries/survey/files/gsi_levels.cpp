// Digital levels in GSI: staff readings in words 330 to 336, the distance to the staff in word 32, the height that the
// level computes in word 83, the method of a line in a code block '410001+?......2'.
#include <cmath>
#include <utility>

#include "survey/files/gsi_reader.hpp"

namespace plumbline::survey {
namespace {

constexpr double kLongestStaff = 10;  // [m]

std::optional<StaffReading::Kind> reading_kind(int index) {
  if (index == 331 || index == 335) return StaffReading::Kind::back;
  if (index == 332 || index == 336) return StaffReading::Kind::ahead;
  if (index == 333) return StaffReading::Kind::intermediate;
  return std::nullopt;
}

}  // namespace

// True if the block is a level's. A level never writes angles; word 83 alone with a name is one of its heights once a
// staff has been read, or a line has begun.
bool GsiReader::read_level_block(const GsiBlock& block) {
  const GsiWord& head = block.words.front();
  if (head.index == 41 && head.data.find('?') != std::string_view::npos) {
    is_level_ = true;
    line_height_ = {};
    const char method = head.data.empty() ? '0' : head.data.back();
    level_.begin_line(method == '2' || method == '4' ? 2 : method == '1' || method == '3' ? 1 : 0);
    return true;
  }
  for (const GsiWord& word : block.words) {
    if (word.index < 330 || word.index > 336) continue;
    is_level_ = true;
    line_height_.has_readings = true;
    read_staff(block, word);
    return true;
  }
  if (!is_level_ || head.index != 11 || block.find(21) || block.find(81)) return false;
  const GsiWord* height = block.find(83);
  const bool result = block.find(571) || block.find(572) || block.find(573) || block.find(574) || height;
  if (!result) return false;
  level_.finish_position();
  if (const auto value = length(height))
    if (const auto id = name(&head)) {
      // Before a staff is read the height is the bench mark's, keyed in; behind a reading it was computed.
      // Of a level 5 is keyed in too, with the correction of curvature switched on.
      const bool as_keyed = height->keyed_in() || height->whole[4] == '5';
      if (as_keyed) level_.start_from(*id, *value);
      const bool keyed = as_keyed && !block.find(571) && !block.find(573);
      const Eigen::Vector3d at(kNotGiven, kNotGiven, *value);
      if (!keyed) level_.compare_height(*id, *value, line_);
      if (!keyed) builder_.compute_coordinates(*id);
      builder_.give_coordinates(*id, at, builder_.at(line_, height->column));
      if (keyed) builder_.know_coordinates(*id, at, builder_.at(line_, height->column));
      add_stored_difference(*id, *value, block);
    }
  return true;
}

// Of a line without staff readings (LS10, LS15 as points) the heights and distances from its begin are what there is.
void GsiReader::add_stored_difference(const std::string& id, double height, const GsiBlock& block) {
  const LineHeight before = std::exchange(line_height_, {id, height, 0, line_height_.has_readings});
  const auto distance = length(block.find(574));
  line_height_.distance = distance.value_or(before.distance);
  if (before.has_readings || before.id.empty() || before.id == id || !distance) return;
  Observation o;
  o.kind = ObservationKind::height_difference;
  o.from = before.id;
  o.to = id;
  o.value = height - before.height;
  if (*distance > before.distance) o.levelling_length = *distance - before.distance;
  o.source = builder_.at(line_, block.words.front().column);
  o.corrections.push_back("difference of the heights that the level wrote");
  builder_.add(std::move(o));
  builder_.warn(
      "levelling lines without staff readings: height differences are those of the heights that the level wrote (words "
      "83 and 574); where it has distributed a misclosure they close by construction and test nothing");
}

void GsiReader::read_staff(const GsiBlock& block, const GsiWord& word) {
  const auto kind = reading_kind(word.index);
  if (!kind) {
    builder_.warn("line " + std::to_string(line_) + ": staff readings of word " + std::to_string(word.index) +
                  " (measured only, or staked out) tie no points together and were passed over");
    return;
  }
  const GsiWord* id_word = block.find(11);
  if (!id_word) return reject(word, "word 11 with the staff's point before its reading");
  const auto id = name(id_word);
  const auto value = length(&word);
  if (!id || !value) return;
  if (std::abs(*value) > kLongestStaff) return reject(word, "a staff reading of at most 10 m");
  StaffReading reading;
  reading.kind = *kind;
  reading.point = *id;
  reading.value = *value;
  reading.distance = length(block.find(32)).value_or(kNotGiven);
  reading.source = builder_.at(line_, word.column);
  level_.add(std::move(reading));
}

}  // namespace plumbline::survey

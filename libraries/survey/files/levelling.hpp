// Readings of digital levels to height differences: what is common to GSI 33x, Zeiss M5 and their kin. A level stands
// between two staffs; the reading back minus the reading ahead is the height difference, whatever the level's own
// height. Orders of readings: BF, BFFB, BBFF, BFBF and the alternating FB, FBBF.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "survey/files/survey_builder.hpp"

namespace plumbline::survey {

struct StaffReading {
  enum class Kind { back, ahead, intermediate } kind = Kind::back;
  std::string point;
  double value = kNotGiven;     ///< [m]; negative on a staff held upside down
  double distance = kNotGiven;  ///< to the staff [m]
  SourcePosition source;
};

/// Collects the readings of one level position after another; each gives one height difference (back staff to staff
/// ahead, mean of its readings, levelling_length the sum of both distances) and one per intermediate sight.
class LevelRun {
 public:
  explicit LevelRun(SurveyBuilder& builder) : builder_(builder) {}
  /// A line begins; `readings` per staff of its method: 1 (BF), 2 (BFFB), 0 unknown.
  void begin_line(int readings);
  /// The file ends.
  void finish();
  void add(StaffReading reading);
  /// The instrument says that the position is complete (it writes a result), or the line ends.
  void finish_position();
  /// The last reading, or all of this position, were repeated: what was read before does not count.
  void drop_last();
  void drop_position();
  bool any() const { return any_; }
  /// A height that was keyed in for the level [m]: those behind it follow from it.
  void start_from(const std::string& point, double height);
  /// A height that the level computed from the readings before it [m], in this line of the file: where the two differ a
  /// reading was repeated, lost or edited, which is said.
  void compare_height(const std::string& point, double height, int line);

 private:
  bool complete() const;
  void emit(const std::vector<StaffReading>& back, const std::vector<StaffReading>& ahead);
  void add_to_balance(const Observation& difference, double back_minus_ahead);
  void tell_balance();

  SurveyBuilder& builder_;
  int readings_ = 0;
  bool any_ = false;
  std::vector<StaffReading> back_, ahead_, intermediate_;
  struct Balance {  // of a line: sights back minus sights ahead, summed up to a point [m]
    double sum = 0, least = 0, most = 0;
    std::string at_least, at_most;  // points
  } balance_;
  StaffReading last_back_;                 // intermediate sights after a finished position still hang on it
  std::map<std::string, double> heights_;  // [m], as the level has them, the last
};

}  // namespace plumbline::survey

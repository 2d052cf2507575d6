#include "survey/files/levelling.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/text/text.hpp"

namespace plumbline::survey {
namespace {

constexpr double kLargestDoubleReading = 0.002;  // [m] between the two height differences of one position
constexpr double kLineOfSight = 10.0;            // ["], what a level's may be off between two checks
constexpr double kToldImbalance = 0.001;         // [m] in a height difference

double mean(const std::vector<StaffReading>& readings, double StaffReading::*member) {
  double sum = 0;
  for (const StaffReading& r : readings) sum += r.*member;
  return sum / static_cast<double>(readings.size());
}

std::string lines_of(const std::vector<StaffReading>& readings) {
  std::string text;
  for (const StaffReading& r : readings) text += (text.empty() ? "" : ", ") + std::to_string(r.source.line);
  return text;
}

}  // namespace

void LevelRun::begin_line(int readings) {
  finish();
  readings_ = readings;
  last_back_ = {};
}

void LevelRun::finish() {
  finish_position();
  tell_balance();
  balance_ = {};
}

void LevelRun::add_to_balance(const Observation& difference, double back_minus_ahead) {
  if (std::isnan(back_minus_ahead)) return;
  Balance& b = balance_;
  if (b.at_least.empty()) b.at_least = b.at_most = difference.from;
  b.sum += back_minus_ahead;
  if (b.sum < b.least) b.least = b.sum, b.at_least = difference.to;
  if (b.sum > b.most) b.most = b.sum, b.at_most = difference.to;
}

/// An error of the line of sight goes with the length of a sight. Where sights back and ahead are equally long it falls
/// out; where they are not it is in the height difference, and a line forth and back closes all the same.
void LevelRun::tell_balance() {
  const double most = balance_.most - balance_.least;
  const double effect = most * kLineOfSight / 3600 * std::numbers::pi / 180;
  if (!(effect > kToldImbalance)) return;
  builder_.warn("between " + text::quoted(balance_.at_least) + " and " + text::quoted(balance_.at_most) +
                " the level's sights back and ahead differ by " + text::format_fixed(most, 0) +
                " m in all: each 10\" that its line of sight is off are " + text::format_fixed(1e3 * effect, 1) +
                " mm in their height difference, which no misclosure shows and no standard deviation here holds. "
                "Level with equal sights, or check the line of sight and correct for it");
}

void LevelRun::start_from(const std::string& point, double height) { heights_.insert_or_assign(point, height); }

void LevelRun::compare_height(const std::string& point, double height, int line) {
  constexpr double kAgree = 0.0015;  // [m]: rounding of both, and a correction of curvature
  const auto& read = builder_.survey.observations;
  const auto before = read.empty() ? heights_.end() : heights_.find(read.back().from);
  const double from = before == heights_.end() ? kNotGiven : before->second;
  heights_[point] = height;
  if (read.empty() || read.back().kind != ObservationKind::height_difference || read.back().to != point) return;
  const double misfit = height - from - read.back().value;
  if (!(std::abs(misfit) > kAgree)) return;  // NaN: the height it came from is not in the file
  builder_.warn("line " + std::to_string(line) + ": the level's own height of '" + point + "' is " +
                text::format_fixed(1e3 * misfit, 1) + " mm off what its readings give from '" + read.back().from +
                "': look for a reading that was repeated, lost or edited");
}

bool LevelRun::complete() const {
  const auto needed = static_cast<std::size_t>(std::max(1, readings_));
  return back_.size() >= needed && ahead_.size() >= needed;
}

void LevelRun::add(StaffReading reading) {
  any_ = true;
  if (reading.kind == StaffReading::Kind::intermediate) {
    if (readings_ > 0 && complete()) finish_position();
    const StaffReading& back = back_.empty() ? last_back_ : back_.front();
    if (back.point.empty()) {
      builder_.warn("line " + std::to_string(reading.source.line) +
                    ": an intermediate sight without a reading back before it was passed over");
      return;
    }
    emit({back}, {reading});
    return;
  }
  // A new staff where this one has been read, or more readings than the method has: another position of the level.
  const bool is_back = reading.kind == StaffReading::Kind::back;
  std::vector<StaffReading>& side = is_back ? back_ : ahead_;
  const bool other_staff = !side.empty() && side.front().point != reading.point;
  if (other_staff || (readings_ > 0 && complete())) finish_position();
  (is_back ? back_ : ahead_).push_back(std::move(reading));
}

void LevelRun::drop_last() {
  std::vector<StaffReading>& side =
      ahead_.empty() || (!back_.empty() && back_.back().source.line > ahead_.back().source.line) ? back_ : ahead_;
  if (!side.empty()) side.pop_back();
}

void LevelRun::drop_position() {
  back_.clear();
  ahead_.clear();
}

void LevelRun::finish_position() {
  if (!back_.empty()) last_back_ = back_.front();
  if (!back_.empty() && !ahead_.empty())
    emit(back_, ahead_);
  else if (!back_.empty() || !ahead_.empty())
    builder_.warn("line " + lines_of(back_.empty() ? ahead_ : back_) +
                  ": a staff reading without its counterpart back or ahead was passed over");
  drop_position();
}

void LevelRun::emit(const std::vector<StaffReading>& back, const std::vector<StaffReading>& ahead) {
  if (back.front().point == ahead.front().point) {
    builder_.warn("line " + lines_of(ahead) + ": back and ahead are the same point " +
                  text::quoted(back.front().point) + "; passed over");
    return;
  }
  Observation o;
  o.kind = ObservationKind::height_difference;
  o.from = back.front().point;
  o.to = ahead.front().point;
  o.value = mean(back, &StaffReading::value) - mean(ahead, &StaffReading::value);
  const double length_back = mean(back, &StaffReading::distance), length_ahead = mean(ahead, &StaffReading::distance);
  if (const double length = length_back + length_ahead; length > 0) o.levelling_length = length;
  if (ahead.front().kind == StaffReading::Kind::ahead) add_to_balance(o, length_back - length_ahead);
  o.source = ahead.front().source;
  if (back.size() > 1 && ahead.size() > 1) {
    o.corrections.push_back("mean of " + std::to_string(std::min(back.size(), ahead.size())) + " double readings");
    const double first = back.front().value - ahead.front().value, second = back.back().value - ahead.back().value;
    if (std::abs(first - second) > kLargestDoubleReading)
      builder_.warn("lines " + lines_of(back) + ", " + lines_of(ahead) + ": the two height differences " + o.from +
                    " -> " + o.to + " differ by " + text::format_fixed(std::abs(first - second) * 1e3, 2) +
                    " mm: look at these readings");
  }
  builder_.add(std::move(o));
}

}  // namespace plumbline::survey

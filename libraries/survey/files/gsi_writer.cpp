#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <unordered_map>

#include "base/text/text.hpp"
#include "survey/files/gsi.hpp"
#include "survey/files/pointings.hpp"
#include "survey/files/survey_builder.hpp"

namespace plumbline::survey {
namespace {

constexpr std::size_t kDataWidth = 16;

class GsiWriter {
 public:
  GsiWriter(const SurveyObservations& survey, const GsiWriteOptions& options) : survey_(survey), options_(options) {
    if (options.distance_unit != 0 && options.distance_unit != 6 && options.distance_unit != 8)
      throw std::runtime_error("GSI writer: found distance unit " + std::to_string(options.distance_unit) +
                               ", expected 0 (1 mm), 6 (0.1 mm) or 8 (0.01 mm)");
  }

  std::string write();

 private:
  void write_point(const Point& point);
  void write_set_up(const SetUp& set_up);
  void write_pointing(const Pointing& pointing);

  void begin(const char* index, const std::string& data);
  void word(const std::string& head, const std::string& data, char sign = '+');
  void angle(const char* index, double value);
  void length(const char* index, double value, const char* mode);
  void distance(const char* index, double value);
  /// Units of the last digit of a length in one metre.
  double scale() const { return options_.distance_unit == 0 ? 1e3 : options_.distance_unit == 6 ? 1e4 : 1e5; }
  std::string name(const std::string& id);
  const Point* point(const std::string& id) const {
    const auto found = points_.find(id);
    return found == points_.end() ? nullptr : found->second;
  }

  const SurveyObservations& survey_;
  const GsiWriteOptions& options_;
  std::string out_;
  int block_ = 0;
  double written_height_ = kNotGiven;  // the instrument height that holds for a reader
  std::unordered_map<std::string, const Point*> points_;
  std::map<std::string, std::string> names_;  // as read back -> as given
};

[[noreturn]] void cannot(const std::string& what) { throw std::runtime_error("GSI writer: cannot hold " + what); }

std::string filled(const std::string& data, const std::string& what) {
  if (data.size() > kDataWidth) cannot(what + " '" + data + "': it has more than 16 characters");
  return std::string(kDataWidth - data.size(), '0') + data;
}

void GsiWriter::word(const std::string& head, const std::string& data, char sign) {
  out_ += head + sign + filled(data, "word " + head) + ' ';
}

void GsiWriter::begin(const char* index, const std::string& data) {
  block_ = block_ % 9999 + 1;
  const std::string number = std::to_string(block_);
  out_ += '*';
  word(index + std::string(4 - number.size(), '0') + number, data);
}

void GsiWriter::angle(const char* index, double value) {
  const double units = std::round(wrap_to_circle(value) * (200.0 / std::numbers::pi) * 1e5);
  // Rounding may reach the full circle, which instruments write as zero.
  word(std::string(index) + ".322", text::format_fixed(units >= 400e5 ? 0.0 : units, 0));
}

void GsiWriter::length(const char* index, double value, const char* mode) {
  const double units = std::round(value * scale());
  if (!(std::abs(units) < 1e15)) cannot("the length " + text::format_shortest(value) + " m");
  word(std::string(index) + mode + std::to_string(options_.distance_unit), text::format_fixed(std::abs(units), 0),
       units < 0 ? '-' : '+');
}

// A distance of zero means "not measured".
void GsiWriter::distance(const char* index, double value) {
  if (std::round(value * scale()) == 0)
    cannot("the distance " + text::format_shortest(value) + " m: it rounds to zero");
  length(index, value, "..0");
}

// A name in GSI's data field: zeros in front are filling there, so that two names may become one.
std::string GsiWriter::name(const std::string& id) {
  const auto bytes = text::encode_windows_1252(id);
  if (!bytes || bytes->empty() || bytes->find_first_of("\r\n\t") != std::string::npos || text::trim(id) != id)
    cannot("the name " + text::quoted(id) +
           ": it is empty, has blanks at its ends, or characters that are not in "
           "Windows-1252; rename the point");
  const std::size_t first = bytes->find_first_not_of('0');
  const auto [known, is_new] = names_.try_emplace(first == std::string::npos ? "0" : bytes->substr(first), id);
  if (known->second != id)
    cannot("both '" + known->second + "' and '" + id + "': zeros in front of a name are lost; rename one of them");
  return filled(*bytes, "the name");
}

void GsiWriter::write_point(const Point& point) {
  if (point.coordinates.array().isNaN().all()) return;
  begin("11", name(point.id));
  const char* index[] = {"81", "82", "83"};
  for (int axis = 0; axis < 3; ++axis)
    if (!std::isnan(point.coordinates[axis])) length(index[axis], point.coordinates[axis], "..1");
  out_ += "\r\n";
}

void GsiWriter::write_set_up(const SetUp& set_up) {
  const Point* station = point(set_up.station);
  // Without a height of its own the reader would let the one before hold.
  written_height_ = std::isnan(set_up.instrument_height) ? 0.0 : set_up.instrument_height;
  if (options_.station_start == GsiStationStart::station_coordinates && station &&
      !station->coordinates.array().isNaN().any()) {
    begin("11", name(set_up.station));
    const char* index[] = {"84", "85", "86"};
    for (int axis = 0; axis < 3; ++axis) length(index[axis], station->coordinates[axis], "..1");
    length("88", written_height_, "..1");
  } else {
    begin("41", filled("21", ""));
    word("42....", name(set_up.station));
    const double millimetres = std::round(written_height_ * scale()) / (scale() / 1e3);
    word("43....", text::format_shortest(std::abs(millimetres)), millimetres < 0 ? '-' : '+');
  }
  out_ += "\r\n";
}

void GsiWriter::write_pointing(const Pointing& pointing) {
  const Observation& any = *pointing.first;
  begin("11", name(any.to));
  if (pointing.direction) angle("21", pointing.direction->value);
  if (pointing.zenith_angle) angle("22", pointing.zenith_angle->value);
  if (pointing.slope_distance) distance("31", pointing.slope_distance->value);
  if (pointing.horizontal_distance) distance("32", pointing.horizontal_distance->value);
  if (pointing.height_difference) length("33", pointing.height_difference->value, "..0");
  if (pointing.slope_distance || pointing.horizontal_distance) word("51..1.", "00000000+0000000");
  length("87", std::isnan(any.target_height) ? 0.0 : any.target_height, "..1");
  const double own = any.instrument_height;
  const double height = std::isnan(own) ? survey_.set_ups[any.set_up].instrument_height : own;
  const double wanted = std::isnan(height) ? 0.0 : height;
  if (wanted != written_height_) length("88", wanted, "..1");
  written_height_ = wanted;
  out_ += "\r\n";
}

std::string GsiWriter::write() {
  for (const Point& p : survey_.points) points_.emplace(p.id, &p);
  for (const Point& p : survey_.points) write_point(p);
  const std::vector<Pointing> all = pointings_of(survey_, "GSI writer");
  int started = -1;
  for (const Pointing& pointing : all) {
    if (pointing.first->set_up != started) write_set_up(survey_.set_ups[pointing.first->set_up]);
    started = pointing.first->set_up;
    write_pointing(pointing);
  }
  const bool ascii = std::all_of(out_.begin(), out_.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; });
  if (!ascii && text::decode_text(out_).encoding != text::Encoding::windows_1252)
    cannot("the names: their Windows-1252 bytes would be taken for another encoding; use ASCII names");
  return std::move(out_);
}

}  // namespace

std::string write_gsi(const SurveyObservations& survey, const GsiWriteOptions& options) {
  return GsiWriter(survey, options).write();
}

}  // namespace plumbline::survey

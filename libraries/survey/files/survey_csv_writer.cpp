#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

#include "base/text/csv_table.hpp"
#include "base/text/text.hpp"
#include "survey/files/survey_csv.hpp"
#include "survey/files/survey_csv_kinds.hpp"

namespace plumbline::survey {
namespace {

const char* const kHeader[] = {"record",
                               "id",
                               "station",
                               "target",
                               "second_to",
                               "kind",
                               "value",
                               "unit",
                               "sigma",
                               "set_up",
                               "pointing",
                               "instrument_height",
                               "target_height",
                               "second_target_height",
                               "face",
                               "set",
                               "levelling_length",
                               "e",
                               "n",
                               "h",
                               "cov_ee",
                               "cov_en",
                               "cov_eh",
                               "cov_nn",
                               "cov_nh",
                               "cov_hh",
                               "role",
                               "code",
                               "description",
                               "source_file",
                               "source_line",
                               "source_column",
                               "corrections"};

[[noreturn]] void csv_cannot(const std::string& what) {
  throw std::runtime_error("CSV writer: the table has no place for " + what + "; write gama XML instead");
}

class CsvWriter {
 public:
  explicit CsvWriter(const SurveyObservations& survey) : survey_(survey) {}
  std::string write();

 private:
  void set(const char* column, const std::string& text) { row_[column] = text; }
  void number(const char* column, double value) {
    if (!std::isnan(value)) row_[column] = text::format_shortest(value);
  }
  void position(const SourcePosition& source);
  void coordinates(const Eigen::Vector3d& at);
  void covariance(const Eigen::Matrix3d& matrix);
  void end_row();
  void write_point(const Point& point);
  void write_control(const CoordinateGroup& group);
  void write_observation(const Observation& observation);
  void write_local(const LocalCoordinate& local);
  const std::string& set_up_id(int index) const;

  const SurveyObservations& survey_;
  std::map<std::string, std::string> row_;
  std::string out_;
};

void CsvWriter::end_row() {
  bool first = true;
  for (const char* column : kHeader) {
    if (!first) out_ += ',';
    first = false;
    if (const auto found = row_.find(column); found != row_.end()) out_ += text::csv_field(found->second);
  }
  out_ += '\n';
  row_.clear();
}

void CsvWriter::position(const SourcePosition& source) {
  set("source_file", source.file);
  if (source.line > 0) set("source_line", std::to_string(source.line));
  if (source.column > 0) set("source_column", std::to_string(source.column));
}

void CsvWriter::coordinates(const Eigen::Vector3d& at) {
  number("e", at[0]);
  number("n", at[1]);
  number("h", at[2]);
}

void CsvWriter::covariance(const Eigen::Matrix3d& matrix) {
  const char* names[3][3] = {{"cov_ee", "cov_en", "cov_eh"}, {"", "cov_nn", "cov_nh"}, {"", "", "cov_hh"}};
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) number(names[i][j], matrix(i, j));
}

const std::string& CsvWriter::set_up_id(int index) const { return survey_.set_ups.at(index).id; }

void CsvWriter::write_point(const Point& point) {
  set("record", "point");
  set("id", point.id);
  coordinates(point.coordinates);
  set("role", letters_of(point.roles));
  set("code", point.code);
  set("description", point.description);
  position(point.source);
  end_row();
}

void CsvWriter::write_control(const CoordinateGroup& group) {
  Eigen::Vector3d at = Eigen::Vector3d::Constant(kNotGiven);
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Constant(kNotGiven);
  for (std::size_t i = 0; i < group.components.size(); ++i) {
    const CoordinateGroup::Component& component = group.components[i];
    if (component.point != group.components.front().point) csv_cannot("a coordinate group of several points");
    const auto row = static_cast<Eigen::Index>(i);
    at[component.axis] = group.values[row];
    for (std::size_t j = 0; j < group.components.size(); ++j)
      matrix(component.axis, group.components[j].axis) = group.covariance(row, static_cast<Eigen::Index>(j));
  }
  if (group.components.empty()) return;
  set("record", group.is_control ? "control" : "coordinates");
  set("id", group.components.front().point);
  coordinates(at);
  covariance(matrix);
  position(group.source);
  end_row();
}

void CsvWriter::write_observation(const Observation& o) {
  if (o.without_centring) csv_cannot("standard deviations to which an instrument adds its centring");
  set("record", "observation");
  set("kind", std::string(name_of(o.kind)));
  const bool angle = is_angle(o.kind);
  const double scale = angle ? 200.0 / std::numbers::pi : 1.0;
  set("unit", angle ? "gon" : "m");
  number("value", o.value * scale);
  number("sigma", o.sigma * scale);
  set("station", o.from);
  set("target", o.to);
  set("second_to", o.second_to);
  if (o.set_up >= 0) set("set_up", set_up_id(o.set_up));
  if (o.pointing >= 0) set("pointing", std::to_string(o.pointing));
  number("levelling_length", o.levelling_length);
  number("instrument_height", o.instrument_height);
  number("target_height", o.target_height);
  number("second_target_height", o.second_target_height);
  set("face", std::to_string(o.face));
  set("set", std::to_string(o.set_number));
  std::string done;
  for (const std::string& correction : o.corrections) done += (done.empty() ? "" : "|") + correction;
  set("corrections", done);
  position(o.source);
  end_row();
}

void CsvWriter::write_local(const LocalCoordinate& local) {
  set("record", "local");
  set("id", local.point);
  set("set_up", set_up_id(local.set_up));
  coordinates(local.position);
  covariance(local.covariance);
  number("target_height", local.target_height);
  position(local.source);
  end_row();
}

std::string CsvWriter::write() {
  if (!survey_.covariances.empty()) csv_cannot("covariances between observations");
  if (!survey_.vectors.empty()) csv_cannot("coordinate differences with covariance");
  for (const char* column : kHeader) out_ += (out_.empty() ? "" : ",") + std::string(column);
  out_ += '\n';
  for (const Point& point : survey_.points) write_point(point);
  for (const CoordinateGroup& group : survey_.coordinates) write_control(group);
  for (const SetUp& set_up : survey_.set_ups) {
    set("record", "set_up");
    set("id", set_up.id);
    set("station", set_up.station);
    number("instrument_height", set_up.instrument_height);
    position(set_up.source);
    end_row();
  }
  for (const Observation& observation : survey_.observations) write_observation(observation);
  for (const LocalCoordinate& local : survey_.local_coordinates) write_local(local);
  return std::move(out_);
}

}  // namespace

std::string write_survey_csv(const SurveyObservations& survey) { return CsvWriter(survey).write(); }

}  // namespace plumbline::survey

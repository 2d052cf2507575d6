// Between the plain structs of survey_observations.hpp and the artifact of schemas/artifacts/survey_observations.fbs.
// For plugins: it needs the generated code.
#pragma once

#include <memory>
#include <stdexcept>

#include "artifacts/survey_observations.hpp"
#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Lower triangle, row by row.
inline std::vector<double> pack_lower(const Eigen::MatrixXd& matrix) {
  std::vector<double> values;
  for (int i = 0; i < matrix.rows(); ++i)
    for (int j = 0; j <= i; ++j) values.push_back(matrix(i, j));
  return values;
}

/// Throws std::runtime_error if `values` is not the lower triangle of a size x size matrix.
inline Eigen::MatrixXd unpack_lower(const std::vector<double>& values, int size) {
  if (static_cast<int>(values.size()) != size * (size + 1) / 2)
    throw std::runtime_error("a covariance of " + std::to_string(size) + " values has " +
                             std::to_string(values.size()) + " entries, expected " +
                             std::to_string(size * (size + 1) / 2));
  Eigen::MatrixXd matrix(size, size);
  size_t k = 0;
  for (int i = 0; i < size; ++i)
    for (int j = 0; j <= i; ++j) matrix(i, j) = matrix(j, i) = values[k++];
  return matrix;
}

namespace detail {

inline std::vector<double> to_vector(const Eigen::VectorXd& v) { return {v.data(), v.data() + v.size()}; }
inline Eigen::VectorXd to_eigen(const std::vector<double>& v) {
  return Eigen::Map<const Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(v.size()));
}

template <typename Native>
void put_source(const SourcePosition& at, Native& item) {
  item.file = at.file;
  item.line = at.line;
  item.column = at.column;
}

inline SurveyInfoT to_artifact(const NetworkInfo& i) {
  SurveyInfoT r;
  r.format = i.format;
  r.title = i.title;
  r.description = i.description;
  r.instrument = i.instrument;
  r.instrument_serial = i.instrument_serial;
  r.operator_name = i.operator_name;
  r.program = i.program;
  r.date = i.date;
  r.axes_xy = i.axes_xy;
  r.angles_right_handed = i.angles_right_handed;
  r.axes_inconsistent = i.axes_inconsistent;
  r.angles_in_degrees = i.angles_in_degrees;
  r.a_priori_sigma0 = i.a_priori_sigma0;
  r.use_a_posteriori_sigma0 = i.use_a_posteriori_sigma0;
  r.confidence_level = i.confidence_level;
  r.refraction_coefficient = i.refraction_coefficient;
  r.largest_misclosure = i.largest_misclosure;
  r.coordinate_system = i.coordinate_system;
  return r;
}

inline NetworkInfo from_artifact(const SurveyInfoT& r) {
  NetworkInfo i;
  i.format = r.format;
  i.title = r.title;
  i.description = r.description;
  i.instrument = r.instrument;
  i.instrument_serial = r.instrument_serial;
  i.operator_name = r.operator_name;
  i.program = r.program;
  i.date = r.date;
  i.axes_xy = r.axes_xy;
  i.angles_right_handed = r.angles_right_handed;
  i.axes_inconsistent = r.axes_inconsistent;
  i.angles_in_degrees = r.angles_in_degrees;
  i.a_priori_sigma0 = r.a_priori_sigma0;
  i.use_a_posteriori_sigma0 = r.use_a_posteriori_sigma0;
  i.confidence_level = r.confidence_level;
  i.refraction_coefficient = r.refraction_coefficient;
  i.largest_misclosure = r.largest_misclosure;
  i.coordinate_system = r.coordinate_system;
  return i;
}

inline SurveyPointT to_artifact(const Point& p) {
  SurveyPointT r;
  r.id = p.id;
  r.position = p.coordinates;
  for (CoordinateRole role : p.roles) r.roles += "ufcx"[static_cast<int>(role)];
  for (size_t k = 0; k < 3; ++k)
    if (p.known[k]) r.known += "ENH"[k];
  r.code = p.code;
  r.description = p.description;
  return r;
}

inline Point from_artifact(const SurveyPointT& r) {
  Point p;
  p.id = r.id;
  p.coordinates = r.position;
  if (r.roles.size() != 3) throw std::runtime_error("roles of point '" + r.id + "' are not three letters");
  for (int k = 0; k < 3; ++k) {
    const size_t role = std::string("ufcx").find(r.roles[k]);
    if (role == std::string::npos) throw std::runtime_error("role of point '" + r.id + "' is none of u, f, c, x");
    p.roles[k] = static_cast<CoordinateRole>(role);
  }
  for (const char axis : r.known) {
    const size_t k = std::string("ENH").find(axis);
    if (k == std::string::npos)
      throw std::runtime_error("point '" + r.id + "' is known in '" + axis + "', expected E, N or H");
    p.known[k] = true;
  }
  p.code = r.code;
  p.description = r.description;
  return p;
}

inline SurveyObservationT to_artifact(const Observation& o) {
  SurveyObservationT r;
  r.kind = static_cast<SurveyKind>(o.kind);
  r.set_up = o.set_up;
  r.pointing = o.pointing;
  r.from = o.from;
  r.to = o.to;
  r.second_to = o.second_to;
  r.value = o.value;
  r.sigma = o.sigma;
  r.without_centring = o.without_centring;
  r.levelling_length = o.levelling_length;
  r.instrument_height = o.instrument_height;
  r.target_height = o.target_height;
  r.second_target_height = o.second_target_height;
  r.face = static_cast<int8_t>(o.face);
  r.set_number = o.set_number;
  r.instrument = o.instrument;
  put_source(o.source, r);
  r.corrections = o.corrections;
  return r;
}

inline Observation from_artifact(const SurveyObservationT& r) {
  Observation o;
  if (static_cast<int>(r.kind) < 0 || static_cast<int>(r.kind) > static_cast<int>(ObservationKind::azimuth))
    throw std::runtime_error("an observation from '" + r.from + "' has the kind " +
                             std::to_string(static_cast<int>(r.kind)) + ", expected 0 to 6");
  if (r.face < 0 || r.face > 2)
    throw std::runtime_error("the observation " + r.from + " -> " + r.to + " has the face " + std::to_string(r.face) +
                             ", expected 0, 1 or 2");
  o.kind = static_cast<ObservationKind>(r.kind);
  o.set_up = r.set_up;
  o.pointing = r.pointing;
  o.from = r.from;
  o.to = r.to;
  o.second_to = r.second_to;
  o.value = r.value;
  o.sigma = r.sigma;
  o.without_centring = r.without_centring;
  o.levelling_length = r.levelling_length;
  o.instrument_height = r.instrument_height;
  o.target_height = r.target_height;
  o.second_target_height = r.second_target_height;
  o.face = r.face;
  o.set_number = r.set_number;
  o.instrument = r.instrument;
  o.source = {r.file, r.line, r.column};
  o.corrections = r.corrections;
  return o;
}

inline SurveyCoordinatesT to_artifact(const CoordinateGroup& g) {
  SurveyCoordinatesT r;
  for (const auto& c : g.components) {
    r.points.push_back(c.point);
    r.axes.push_back(static_cast<int8_t>(c.axis));
  }
  r.values = to_vector(g.values);
  r.covariance = pack_lower(g.covariance);
  r.is_control = g.is_control;
  put_source(g.source, r);
  return r;
}

inline CoordinateGroup from_artifact(const SurveyCoordinatesT& r) {
  CoordinateGroup g;
  if (r.axes.size() != r.points.size() || r.values.size() != r.points.size())
    throw std::runtime_error("observed coordinates: points, axes and values differ in number");
  for (size_t k = 0; k < r.points.size(); ++k) {
    if (r.axes[k] < 0 || r.axes[k] > 2)
      throw std::runtime_error("observed coordinates of '" + r.points[k] + "' have the axis " +
                               std::to_string(r.axes[k]) + ", expected 0, 1 or 2");
    g.components.push_back({r.points[k], r.axes[k]});
  }
  g.values = to_eigen(r.values);
  g.covariance = unpack_lower(r.covariance, static_cast<int>(r.values.size()));
  g.is_control = r.is_control;
  g.source = {r.file, r.line, r.column};
  return g;
}

inline SurveyVectorsT to_artifact(const VectorGroup& g) {
  SurveyVectorsT r;
  for (const auto& v : g.vectors) {
    r.from.push_back(v.from);
    r.to.push_back(v.to);
    r.heights.insert(r.heights.end(), {v.from_height, v.to_height});
  }
  r.values = to_vector(g.values);
  r.covariance = pack_lower(g.covariance);
  r.is_geocentric = g.is_geocentric;
  r.horizontal_factor = g.horizontal_factor;
  r.vertical_factor = g.vertical_factor;
  put_source(g.source, r);
  return r;
}

inline VectorGroup from_artifact(const SurveyVectorsT& r) {
  VectorGroup g;
  const size_t n = r.from.size();
  if (r.to.size() != n || r.heights.size() != 2 * n || r.values.size() != 3 * n)
    throw std::runtime_error("observed vectors: points, heights and values differ in number");
  g.is_geocentric = r.is_geocentric;
  g.horizontal_factor = r.horizontal_factor;
  g.vertical_factor = r.vertical_factor;
  for (size_t k = 0; k < n; ++k) g.vectors.push_back({r.from[k], r.to[k], r.heights[2 * k], r.heights[2 * k + 1]});
  g.values = to_eigen(r.values);
  g.covariance = unpack_lower(r.covariance, static_cast<int>(r.values.size()));
  g.source = {r.file, r.line, r.column};
  return g;
}

inline SurveyLocalCoordinateT to_artifact(const LocalCoordinate& c) {
  SurveyLocalCoordinateT r;
  r.set_up = c.set_up;
  r.point = c.point;
  r.position = c.position;
  if (c.covariance.allFinite()) r.covariance = pack_lower(c.covariance);
  r.target_height = c.target_height;
  put_source(c.source, r);
  r.corrections = c.corrections;
  return r;
}

inline LocalCoordinate from_artifact(const SurveyLocalCoordinateT& r) {
  LocalCoordinate c;
  c.set_up = r.set_up;
  c.point = r.point;
  c.position = r.position;
  if (!r.covariance.empty()) c.covariance = unpack_lower(r.covariance, 3);
  c.target_height = r.target_height;
  c.source = {r.file, r.line, r.column};
  c.corrections = r.corrections;
  return c;
}

/// Indices are as good as the artifact they come from.
inline void check_indices(const SurveyObservations& s) {
  const auto check = [](int index, size_t count, int least, const std::string& what) {
    if (index < least || index >= static_cast<int>(count))
      throw std::runtime_error(what + " number " + std::to_string(index) + ", there are " + std::to_string(count));
  };
  for (const Observation& o : s.observations)
    check(o.set_up, s.set_ups.size(), -1, "the observation " + o.from + " -> " + o.to + " refers to set-up");
  for (const Observation& o : s.observations)
    check(o.instrument, s.instruments.size(), -1, "the observation " + o.from + " -> " + o.to + " is of instrument");
  for (const LocalCoordinate& c : s.local_coordinates)
    check(c.set_up, s.set_ups.size(), 0, "local coordinates of " + c.point + " refer to set-up");
  for (const ObservationCovariance& c : s.covariances)
    for (int i : c.indices) check(i, s.observations.size(), 0, "a covariance refers to observation");
}

template <typename Plain, typename Native>
void pack_list(const std::vector<Plain>& from, std::vector<std::unique_ptr<Native>>& to) {
  for (const auto& item : from) to.push_back(std::make_unique<Native>(to_artifact(item)));
}
template <typename Plain, typename Native>
void unpack_list(const std::vector<std::unique_ptr<Native>>& from, std::vector<Plain>& to) {
  for (const auto& item : from) to.push_back(from_artifact(*item));
}

}  // namespace detail

inline SurveyObservationsT to_artifact(const SurveyObservations& s) {
  SurveyObservationsT r;
  r.info = std::make_unique<SurveyInfoT>(detail::to_artifact(s.info));
  r.files = s.files;
  detail::pack_list(s.points, r.points);
  for (const SetUp& set_up : s.set_ups) {
    auto item = std::make_unique<SurveySetUpT>();
    item->id = set_up.id;
    item->station = set_up.station;
    item->instrument_height = set_up.instrument_height;
    item->stated_orientation = set_up.stated_orientation;
    detail::put_source(set_up.source, *item);
    r.set_ups.push_back(std::move(item));
  }
  detail::pack_list(s.observations, r.observations);
  for (const auto& c : s.covariances) {
    auto item = std::make_unique<SurveyCovarianceT>();
    item->indices = c.indices;
    item->covariance = pack_lower(c.covariance);
    r.covariances.push_back(std::move(item));
  }
  detail::pack_list(s.coordinates, r.coordinates);
  detail::pack_list(s.vectors, r.vectors);
  detail::pack_list(s.local_coordinates, r.local_coordinates);
  for (const auto& skipped : s.skipped) {
    auto item = std::make_unique<SurveySkippedT>();
    detail::put_source(skipped.source, *item);
    item->found = skipped.found;
    item->expected = skipped.expected;
    r.skipped.push_back(std::move(item));
  }
  r.warnings = s.warnings;
  r.instruments = s.instruments;
  return r;
}

/// Throws std::runtime_error where sizes or indices do not fit each other.
inline SurveyObservations from_artifact(const SurveyObservationsT& r) {
  SurveyObservations s;
  s.info = detail::from_artifact(*r.info);
  s.files = r.files;
  detail::unpack_list(r.points, s.points);
  for (const auto& item : r.set_ups)
    s.set_ups.push_back({item->id,
                         item->station,
                         item->instrument_height,
                         {item->file, item->line, item->column},
                         item->stated_orientation});
  detail::unpack_list(r.observations, s.observations);
  for (const auto& item : r.covariances)
    s.covariances.push_back({item->indices, unpack_lower(item->covariance, static_cast<int>(item->indices.size()))});
  detail::unpack_list(r.coordinates, s.coordinates);
  detail::unpack_list(r.vectors, s.vectors);
  detail::unpack_list(r.local_coordinates, s.local_coordinates);
  for (const auto& item : r.skipped)
    s.skipped.push_back({{item->file, item->line, item->column}, item->found, item->expected});
  s.warnings = r.warnings;
  s.instruments = r.instruments;
  detail::check_indices(s);
  return s;
}

}  // namespace plumbline::survey

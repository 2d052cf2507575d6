// Sections of Krumm's files whose lines belong together: dynamic datum, levelling, correlated distances, baselines,
// restrictions; and marks that only orient.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "survey/files/krumm_reader.hpp"

namespace plumbline::survey {
namespace {

constexpr double kCondition = 1e-6;  // [m], standard deviation that holds a restriction

}  // namespace

// One number in each row: standard deviations, zero holds. More: the lower triangle or all of a covariance matrix.
void KrummReader::finish_dynamic_datum() {
  const auto n = static_cast<Eigen::Index>(dynamic_rows_.size());
  if (n == 0) return;
  const bool sigmas =
      std::all_of(dynamic_rows_.begin(), dynamic_rows_.end(), [](const DynamicRow& r) { return r.values.size() == 1; });
  CoordinateGroup group;
  group.is_control = true;
  group.source = dynamic_rows_.front().source;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const DynamicRow& row = dynamic_rows_[i];
    const auto given = static_cast<Eigen::Index>(row.values.size());
    if (!sigmas && given != i + 1 && given != n)
      return builder_.skip(row.source.line, 1, row.point, "a row of a covariance matrix, or one standard deviation");
    if (row.values[sigmas ? 0 : static_cast<std::size_t>(i)] < 0)
      return builder_.skip(row.source.line, 1, row.point, "a standard deviation or variance that is not negative");
    for (Eigen::Index j = 0; j <= i; ++j) {
      const double value = sigmas ? (i == j ? row.values[0] * row.values[0] : 0) : row.values[j];
      covariance(i, j) = covariance(j, i) = value;
    }
  }
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < n; ++i) {
    const DynamicRow& row = dynamic_rows_[i];
    Point& point = builder_.point(row.point, row.source);
    if (std::isnan(point.coordinates[row.axis])) continue;
    if (covariance(i, i) > 0) {
      kept.push_back(i);
      group.components.push_back({row.point, row.axis});
    } else {
      point.roles[row.axis] = CoordinateRole::fixed;
    }
  }
  if (kept.empty()) return;
  group.values.resize(static_cast<Eigen::Index>(kept.size()));
  for (std::size_t k = 0; k < kept.size(); ++k)
    group.values[static_cast<Eigen::Index>(k)] =
        builder_.point(group.components[k].point, group.source).coordinates[group.components[k].axis];
  group.covariance = covariance(kept, kept);
  if (Eigen::LLT<Eigen::MatrixXd>(group.covariance).info() != Eigen::Success)
    return builder_.skip(group.source.line, 1, "[Datum]", "a positive definite covariance matrix");
  builder_.survey.coordinates.push_back(std::move(group));
}

void KrummReader::read_levelling(const Parts& parts) {
  if (parts.size() < 4 || parts.size() > 5)
    return reject(line_text_, "from, to, height difference, length of the line [m], standard deviation of 1 km [m]");
  Observation o;
  o.kind = ObservationKind::height_difference;
  o.from = std::string(parts[0]);
  o.to = std::string(parts[1]);
  o.source = builder_.at(line_, 1);
  const auto value = text::parse_number(parts[2]), length = text::parse_number(parts[3]);
  if (!value || !length || *length <= 0) return reject(parts[value ? 3 : 2], "a height difference and a length [m]");
  if (o.from == o.to) return reject(parts[1], "another point than the first one");
  if (parts.size() == 5) {
    const auto sigma = sigma_of(parts[4], o.kind);
    if (!sigma || *sigma <= 0) return reject(parts[4], "the standard deviation of a line of 1 km [m]");
    first_sigma_ = *sigma;
  }
  o.value = *value;
  o.levelling_length = *length;
  const double per_km = std::isnan(first_sigma_) ? sigma0_ : first_sigma_;
  o.sigma = per_km * std::sqrt(*length / 1000);
  if (!(o.sigma > 0 && std::isfinite(o.sigma)))
    return reject(parts[3], "a length with a standard deviation above zero");
  builder_.add(std::move(o));
}

// "C H 1771.42 0.00072 0.0009": behind the distance its row of the covariance matrix, lower triangle.
void KrummReader::read_correlated(const Parts& parts) {
  const std::vector<double> values = numbers(parts, 2);
  if (values.size() != correlated_.size() + 2 || values[0] <= 0)
    return reject(line_text_, "from, to, distance and a row of the covariance matrix [m^2]");
  Observation o;
  o.kind = ObservationKind::horizontal_distance;
  o.from = std::string(parts[0]);
  o.to = std::string(parts[1]);
  if (o.from == o.to) return reject(parts[1], "another point than the first one");
  o.value = values[0];
  o.source = builder_.at(line_, 1);
  if (!(values.back() > 0)) return reject(parts.back(), "a variance above zero [m^2]");
  o.sigma = std::sqrt(values.back());
  correlated_.push_back(static_cast<int>(builder_.survey.observations.size()));
  correlated_rows_.push_back({values.begin() + 1, values.end()});
  builder_.add(std::move(o));
}

void KrummReader::finish_correlated() {
  const auto n = static_cast<Eigen::Index>(correlated_.size());
  if (n < 2) return;
  ObservationCovariance c;
  c.indices = correlated_;
  c.covariance.resize(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) c.covariance(i, j) = c.covariance(j, i) = correlated_rows_[i][j];
  if (Eigen::LLT<Eigen::MatrixXd>(c.covariance).info() != Eigen::Success)
    return builder_.skip(line_, 1, "[CorrelatedDistances]", "a positive definite covariance matrix");
  builder_.survey.covariances.push_back(std::move(c));
}

// dx, dy, dz, then three standard deviations or the upper triangle of the covariance matrix, then perhaps two heights.
void KrummReader::read_baseline(const Parts& parts) {
  std::vector<double> v = numbers(parts, 2);
  if (parts.size() < 2 || (v.size() != 6 && v.size() != 9 && v.size() != 11))
    return reject(line_text_, "from, to, dx, dy, dz [m] and three standard deviations or six covariances");
  VectorGroup group;
  const bool heights = v.size() == 11;
  group.vectors.push_back({std::string(parts[0]), std::string(parts[1]), heights ? v[9] : 0, heights ? v[10] : 0});
  group.values = Eigen::Vector3d(v[0], v[1], v[2]);
  Eigen::Matrix3d covariance = Eigen::Vector3d(v[3] * v[3], v[4] * v[4], v[5] * v[5]).asDiagonal();
  if (v.size() > 6) covariance << v[3], v[4], v[5], v[4], v[6], v[7], v[5], v[7], v[8];
  group.covariance = covariance;
  group.source = builder_.at(line_, 1);
  if (parts[0] == parts[1] || Eigen::LLT<Eigen::MatrixXd>(group.covariance).info() != Eigen::Success)
    return reject(line_text_, "two points and a positive definite covariance matrix");
  for (const std::string_view id : {parts[0], parts[1]}) builder_.point(std::string(id), group.source);
  builder_.survey.vectors.push_back(std::move(group));
}

void KrummReader::read_restriction(std::string_view text) {
  const auto condition = krumm_distance_condition(text);
  if (!condition || !builder_.has_point(condition->from) ||
      (!condition->to.empty() && !builder_.has_point(condition->to)))
    return reject(text, "a distance held between two points, (xA-xB)^2+(yA-yB)^2-d^2, or of one from the origin");
  Observation o;
  o.kind = ObservationKind::horizontal_distance;
  o.from = condition->from;
  o.to = condition->to;
  o.source = builder_.at(line_, 1);
  if (o.to.empty()) {
    o.to = "origin";
    while (builder_.has_point(o.to)) o.to += "_";
    builder_.give_coordinates(o.to, {0, 0, kNotGiven}, o.source);
    builder_.point(o.to, o.source).roles = {CoordinateRole::fixed, CoordinateRole::fixed, CoordinateRole::unused};
  }
  o.value = condition->distance;
  o.sigma = kCondition;
  o.corrections.push_back("a restriction, held to 1 micrometre");
  builder_.add(std::move(o));
}

// An angle whose arm is a mark known by its azimuth alone is an azimuth of its other arm.
void KrummReader::orient_by_marks() {
  if (!correlated_.empty()) return;  // their indices must stay
  std::map<std::string, std::set<std::string>> seen_from;
  std::map<std::string, double> azimuths;
  for (const Observation& o : builder_.survey.observations) {
    seen_from[o.to].insert(o.from);
    if (!o.second_to.empty()) seen_from[o.second_to].insert(o.from);
    seen_from[o.from].insert("");  // a station is no mark
    const bool angular = o.kind == ObservationKind::angle || o.kind == ObservationKind::azimuth;
    if (!angular) seen_from[o.to].insert("");
    if (o.kind == ObservationKind::azimuth) azimuths.try_emplace(o.to, o.value);
  }
  std::erase_if(azimuths, [&](const auto& mark) {
    return seen_from[mark.first].size() != 1 || !builder_.point(mark.first, {}).coordinates.array().isNaN().all();
  });
  if (azimuths.empty()) return;
  std::erase_if(builder_.survey.observations,
                [&](const Observation& o) { return o.kind == ObservationKind::azimuth && azimuths.contains(o.to); });
  for (Observation& o : builder_.survey.observations) {
    if (o.kind != ObservationKind::angle) continue;
    const auto left = azimuths.find(o.to), right = azimuths.find(o.second_to);
    if ((left == azimuths.end()) == (right == azimuths.end())) continue;
    const bool by_left = left != azimuths.end();
    const std::string mark = by_left ? o.to : o.second_to;
    o.kind = ObservationKind::azimuth;
    o.value = wrap_to_circle(by_left ? left->second + o.value : right->second - o.value);
    if (by_left) o.to = o.second_to;
    o.second_to.clear();
    o.corrections.push_back("angle to the mark " + mark + ", whose azimuth is given, made an azimuth");
  }
  std::erase_if(builder_.survey.points, [&](const Point& p) { return azimuths.contains(p.id); });
}

}  // namespace plumbline::survey

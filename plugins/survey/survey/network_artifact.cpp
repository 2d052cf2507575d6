#include "network_artifact.hpp"

#include <cmath>
#include <memory>

#include "ellipsoid_artifact.hpp"
#include "geometry/packed_symmetric.hpp"

namespace plumbline::survey {

namespace {

std::vector<std::unique_ptr<PointT>> pack_points(const NetworkResult& r) {
  std::vector<std::unique_ptr<PointT>> points;
  for (const ResultPoint& p : r.points) {
    auto point = std::make_unique<PointT>();
    point->id = p.id;
    point->position = p.position;
    point->sigma = r.sigma(p);
    points.push_back(std::move(point));
  }
  return points;
}

std::unique_ptr<StatisticsT> pack_statistics(const NetworkResult& r) {
  auto s = std::make_unique<StatisticsT>();
  s->sigma0 = r.sigma0;
  s->degrees_of_freedom = r.degrees_of_freedom;
  s->weighted_sum_of_squares = r.sum_of_squares;
  s->observations = r.observations;
  s->unknowns = r.unknowns;
  s->datum_defect = r.defect;
  return s;
}

std::unique_ptr<NetworkTestsT> pack_tests(const NetworkResult& r, const AdjustOptions& options) {
  using Verdict = least_squares::GlobalTest::Verdict;
  auto t = std::make_unique<NetworkTestsT>();
  t->alpha = options.alpha;
  t->alpha0 = options.alpha0;
  t->power = options.power;
  t->statistic = r.global_test.statistic;
  t->lower = r.global_test.lower;
  t->upper = r.global_test.upper;
  t->verdict = r.degrees_of_freedom <= 0                ? "none"
               : r.global_test.verdict == Verdict::low  ? "low"
               : r.global_test.verdict == Verdict::high ? "high"
                                                        : "pass";
  t->critical_w = r.critical_w;
  t->critical_tau = r.critical_tau;
  return t;
}

std::unique_ptr<NetworkObservationT> pack_row(const ResultRow& row) {
  auto o = std::make_unique<NetworkObservationT>();
  const least_squares::RowStatistics& s = row.statistics;
  o->kind = row.kind;
  o->set_up = row.set_up;
  o->from = row.from;
  o->to = row.to;
  o->detail = row.detail;
  o->value = row.value;
  o->residual = s.residual;
  o->sigma = s.sigma;
  o->sigma_adjusted = s.sigma_adjusted;
  o->redundancy_number = s.redundancy_number;
  o->w = s.w;
  o->estimated_blunder = s.estimated_blunder;
  o->mdb = s.mdb;
  o->external_effect = s.external_effect;
  o->external_point = row.external_point;
  o->control = s.controlled < 0.1 ? "uncontrolled" : s.controlled < 0.3 ? "weak" : "controlled";
  o->flagged = row.flagged;
  o->removed = row.removed;
  o->sets = row.sets;
  o->file = row.source.file;
  o->line = row.source.line;
  o->column = row.source.column;
  o->corrections = row.corrections;
  return o;
}

std::vector<std::unique_ptr<NetworkKnownPointT>> pack_known(const std::vector<KnownPoint>& points) {
  std::vector<std::unique_ptr<NetworkKnownPointT>> packed;
  for (const KnownPoint& k : points) {
    auto known = std::make_unique<NetworkKnownPointT>();
    known->id = k.id;
    known->difference = k.difference;
    known->sigma = k.sigma;
    known->statistic = k.statistic;
    known->critical = k.critical;
    known->rank = k.rank;
    packed.push_back(std::move(known));
  }
  return packed;
}

void pack_tables(const NetworkResult& r, SurveyNetworkT& n) {
  for (const ResultRow& row : r.rows) n.observations.push_back(pack_row(row));
  for (const ResultPointing& p : r.pointings) {
    auto t = std::make_unique<PointingTestT>();
    t->set_up = p.set_up;
    t->to = p.to;
    t->statistic = p.test.statistic;
    t->rank = p.test.rank;
    t->critical = p.critical;
    t->flagged = p.flagged;
    n.pointings.push_back(std::move(t));
  }
  for (const SnoopingAction& a : r.snooping) {
    auto s = std::make_unique<SnoopingStepT>();
    s->observation = a.row;
    s->action = a.restored ? "restored" : "removed";
    s->w = a.w;
    s->estimated_blunder = a.estimated_blunder;
    s->weighted_sum_of_squares = a.sum_of_squares;
    s->degrees_of_freedom = a.degrees_of_freedom;
    n.snooping.push_back(std::move(s));
  }
  for (const Finding& f : r.findings) {
    static const char* const severities[] = {"note", "warning", "error"};
    auto finding = std::make_unique<NetworkFindingT>();
    finding->severity = severities[static_cast<int>(f.severity)];
    finding->text = f.text;
    finding->points = f.points;
    static const char* const subjects[] = {"network", "reading", "exclusion", "left_out",
                                           "unread",  "control", "either"};
    finding->subject = subjects[static_cast<int>(f.subject)];
    n.findings.push_back(std::move(finding));
  }
  for (const ResultSetUp& s : r.set_ups) {
    auto set_up = std::make_unique<NetworkSetUpT>();
    set_up->id = s.id;
    set_up->station = s.station;
    set_up->orientation = s.orientation;
    set_up->orientation_sigma = s.orientation_sigma;
    set_up->instrument_height_correction = s.instrument_height_correction;
    set_up->instrument_height = s.instrument_height;
    set_up->collimation = s.collimation.value, set_up->collimation_sigma = s.collimation.sigma;
    set_up->index = s.index.value, set_up->index_sigma = s.index.sigma;
    set_up->constant = s.constant.value, set_up->constant_sigma = s.constant.sigma;
    set_up->scale = s.scale.value, set_up->scale_sigma = s.scale.sigma;
    n.set_ups.push_back(std::move(set_up));
  }
  for (const ResultGroup& g : r.groups) {
    auto group = std::make_unique<VarianceGroupT>();
    group->name = g.name;
    group->applied_factor = g.applied_factor;
    group->ratio = std::sqrt(g.component.factor);
    group->redundancy = g.component.redundancy;
    group->observations = g.component.rows;
    n.groups.push_back(std::move(group));
  }
  for (const ResultParameter& p : r.parameters) {
    auto parameter = std::make_unique<NetworkParameterT>();
    parameter->name = p.name;
    parameter->value = p.value;
    parameter->sigma = p.sigma;
    n.parameters.push_back(std::move(parameter));
  }
}

}  // namespace

PointsT to_points_artifact(const NetworkResult& r, bool joint) {
  PointsT points;
  points.points = pack_points(r);
  if (joint) points.covariance = pack_symmetric(r.full_covariance());
  points.statistics = pack_statistics(r);
  return points;
}

PointsT to_artifact(const MeasuredControl& measured) {
  PointsT points;
  for (std::size_t i = 0; i < measured.ids.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(3 * i);
    auto point = std::make_unique<PointT>();
    point->id = measured.ids[i];
    point->position = measured.coordinates.segment<3>(row);
    point->sigma = measured.covariance.diagonal().segment<3>(row).cwiseSqrt();
    points.points.push_back(std::move(point));
  }
  points.covariance = pack_symmetric(measured.covariance);
  points.statistics = std::make_unique<StatisticsT>();
  points.statistics->datum_defect = measured.defect;
  return points;
}

MeasuredControl measured_control(const PointsT& points) {
  ControlPoints all = control_from_artifact(points);
  return {std::move(all.ids), std::move(all.coordinates), std::move(all.covariance),
          points.statistics ? points.statistics->datum_defect : 0};
}

void add_covariances(const NetworkResult& r, const std::vector<std::pair<std::size_t, std::size_t>>& pairs,
                     SurveyNetworkT& network) {
  const auto add = [&](const std::string& from, const std::string& to, const Eigen::Matrix3d& covariance) {
    auto entry = std::make_unique<NetworkCovarianceT>();
    entry->from = from, entry->to = to;
    entry->values = pack_symmetric(covariance);
    network.covariances.push_back(std::move(entry));
  };
  for (const ResultPoint& p : r.points) add(p.id, "", r.covariance(p, p));
  for (const auto& [a, b] : pairs) add(r.points[a].id, r.points[b].id, r.relative_covariance(r.points[a], r.points[b]));
}

SurveyNetworkT to_network_artifact(const NetworkResult& r, const AdjustOptions& options) {
  SurveyNetworkT n;
  n.axes = "en";
  n.points = pack_points(r);
  n.statistics = pack_statistics(r);
  n.tests = pack_tests(r, options);
  static const char* const modes[] = {"automatic", "file", "fixed", "weighted", "inner"};
  n.datum = modes[static_cast<int>(r.datum)];
  n.datum_points = r.datum_points;
  n.iterations = r.iterations;
  n.scaled_with_sigma0 = r.variance_factor != 1;
  pack_tables(r, n);
  n.known_points = pack_known(r.known_points);
  n.left_out_known = pack_known(r.left_out_known);
  static const char* const validities[] = {"sound", "doubtful", "invalid"};
  n.validity = validities[static_cast<int>(r.validity)];
  n.verdict = r.verdict;
  n.without_readings = r.without_readings;
  n.frame = r.frame;
  n.left_out = r.left_out;
  if (r.validity != Validity::invalid)  // what is no result has no precision
    for (const ResultPoint& p : r.points) n.ellipsoids.push_back(ellipsoid_artifact(p.id, r.covariance(p, p)));
  return n;
}

}  // namespace plumbline::survey

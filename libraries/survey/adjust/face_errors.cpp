// Index and collimation of the instrument have opposite signs in the two faces, and a target read in both is free of
// them. Where the control was read in one face and the rest in the other, nothing is: heights bend by the distance
// times twice the index, and every target agrees with itself.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/text/words.hpp"
#include "survey/adjust/adjuster.hpp"

namespace plumbline::survey {

namespace {

constexpr int kPairsThatTell = 3;  // so many determine index and collimation, which were taken off then

/// Of one set-up.
struct Faces {
  std::set<std::string> targets[3];  ///< read in no or both, in one, in two
  int pairs = 0;

  bool apart() const {
    if (targets[1].empty() || targets[2].empty() || pairs >= kPairsThatTell) return false;
    return std::none_of(targets[1].begin(), targets[1].end(),
                        [&](const std::string& target) { return targets[2].contains(target); });
  }
};

/// By set-up, of directions or zenith angles.
std::map<int, Faces> faces_of(const NetworkModel& m, ObservationKind kind) {
  std::map<int, Faces> all;
  for (size_t i = 0; i < m.observations.size(); ++i) {
    const MeanObservation& mean = m.observations[i];
    const Observation& o = mean.observation;
    if (o.kind != kind || o.set_up < 0 || m.dropped[i]) continue;
    Faces& faces = all[o.set_up];
    faces.targets[o.face == 1 || o.face == 2 ? o.face : 0].insert(o.to);
    faces.pairs += o.face == 0 && mean.members.size() > 1;
  }
  return all;
}

}  // namespace

double Adjuster::effect_of_face(const Pass& pass, int row, CommonError::Kind kind) const {
  const Observation& o = m_.observations[row].observation;
  const double sign = o.face == 1 ? 1 : o.face == 2 ? -1 : 0;
  if (kind == CommonError::Kind::face_index) return o.kind == ObservationKind::zenith_angle ? sign : 0;
  if (o.kind != ObservationKind::direction) return 0;
  const auto point = [&](const std::string& id) {
    const int block = pass.problem.point_blocks[m_.index.at(id)];
    return Eigen::Map<const Eigen::Vector3d>(pass.problem.problem.parameters[block].value.data());
  };
  const Eigen::Vector3d d = point(o.to) - point(o.from);
  const double h = d.head<2>().norm();
  return !(h > 0) ? 0 : std::isnan(d.z()) ? sign : sign * d.norm() / h;
}

std::vector<Adjuster::Hypothesis> Adjuster::face_errors(const Pass& pass) const {
  using Kind = CommonError::Kind;
  const std::map<int, Faces> of[] = {faces_of(m_, ObservationKind::zenith_angle),
                                     faces_of(m_, ObservationKind::direction)};
  std::map<std::pair<Kind, int>, std::vector<std::pair<int, double>>> rows;  // set-up -1: all
  for (int r = 0; r < static_cast<int>(pass.problem.rows.size()); ++r) {
    const int row = pass.problem.rows[r];
    if (row < 0 || static_cast<size_t>(row) >= m_.observations.size() || !m_.rows[row].removable) continue;
    const int own = set_up_of_row_[row];
    for (const Kind kind : {Kind::face_index, Kind::collimation}) {
      const auto faces = of[kind == Kind::collimation].find(own);
      const double effect = effect_of_face(pass, row, kind);
      if (effect == 0 || faces == of[kind == Kind::collimation].end() || !faces->second.apart()) continue;
      for (const int set_up : {-1, own}) rows[{kind, set_up}].emplace_back(r, effect);
    }
  }
  std::vector<Hypothesis> all;
  for (auto& [hypothesis, list] : rows) {
    if (list.size() < 3) continue;
    CommonError error;
    error.kind = hypothesis.first, error.set_up = hypothesis.second;
    all.push_back({error, std::move(list)});
  }
  return all;
}

std::string Adjuster::tell_faces_apart(NetworkResult& result) const {
  const auto taken_off = [&](ObservationKind kind, int set_up) {
    const auto error =
        kind == ObservationKind::direction ? ExtraUnknown::Kind::collimation : ExtraUnknown::Kind::face_index;
    return std::any_of(state_.extra.begin(), state_.extra.end(),
                       [&](const ExtraUnknown& e) { return e.kind == error && (e.set_up < 0 || e.set_up == set_up); });
  };
  std::set<std::string> set_ups;
  for (const ObservationKind kind : {ObservationKind::zenith_angle, ObservationKind::direction})
    for (const auto& [set_up, faces] : faces_of(m_, kind))
      if (faces.apart() && faces.pairs == 0 && !taken_off(kind, set_up)) set_ups.insert(m_.survey.set_ups[set_up].id);
  if (set_ups.empty()) return "";
  const std::string names = text::join({set_ups.begin(), set_ups.end()}, 8);
  result.findings.push_back({Finding::Severity::warning,
                             "read in both faces, but no target in both, at " + names +
                                 ": index and collimation of the instrument stay in the readings, with opposite signs "
                                 "in the two faces; read targets in both",
                             {}});
  return names;
}

}  // namespace plumbline::survey

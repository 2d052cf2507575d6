// Errors that all readings of a set-up have in common: a wrong prism constant, a wrong ppm setting, an index error.
// Each reading shows a little of such an error, and data snooping, which looks for single wrong readings, takes
// innocent ones out. So each is tested as one alternative hypothesis (Teunissen 2000): observations = f(x) + c e, with
//   w = c'Pv / sqrt(c' P Qvv P c),   e = -c'Pv / (c' P Qvv P c).
// w^2 is what the hypothesis takes off v'Pv, which makes it comparable with the w of a single observation.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "survey/adjust/adjuster.hpp"
#include "survey/doctor/network_words.hpp"

namespace plumbline::survey {

namespace {

bool is_distance(const std::string& kind) { return kind == "slope_distance" || kind == "horizontal_distance"; }

/// Differences between the constants of common reflectors [mm], for a hint.
const char* known_difference(double millimetres, double sigma) {
  const auto near = [&](double value) { return std::abs(std::abs(millimetres) - value) < std::max(0.3, 3 * sigma); };
  if (sigma > 1.0) return "";
  if (near(34.4)) return " (34.4 mm lie between a round prism and measuring without reflector)";
  if (near(23.1)) return " (23.1 mm lie between a round and a 360 degree prism)";
  if (near(17.5)) return " (17.5 mm lie between a round and a mini prism)";
  return "";
}

std::string describe(const CommonError& e) {
  const std::string owner = e.set_up.empty() ? "" : " of set-up " + e.set_up;
  const std::string all = "all " + std::to_string(e.observations) + " ";
  std::string text;
  switch (e.kind) {
    case CommonError::Kind::constant:
      text = all + "distances" + owner + " look too " + (e.size > 0 ? "long" : "short") + " by " +
             fixed_digits(std::abs(e.size) * 1000, 1) + " mm: check the prism constant" +
             known_difference(e.size * 1000, e.sigma * 1000);
      break;
    case CommonError::Kind::scale:
      text = all + "distances" + owner + " look too " + (e.size > 0 ? "long" : "short") + " by " +
             fixed_digits(std::abs(e.size) * 1e6, 0) + " ppm: check the ppm setting and the unit";
      break;
    case CommonError::Kind::index:
      text = all + "zenith angles" + owner + " look wrong by " + fixed_digits(e.size * 200000 / std::numbers::pi, 1) +
             " mgon: check the vertical index, and whether the instrument was level";
      break;
    case CommonError::Kind::height:
      text = "the instrument height" + owner + " looks too " + (e.size > 0 ? "large" : "small") + " by " +
             fixed_digits(std::abs(e.size) * 1000, 1) + " mm: check it, and the point the instrument stood on";
      break;
  }
  return text + " (w = " + fixed_digits(e.w, 1) +
         "). This explains the misfit better than any single observation; mend it first, others may follow from it";
}

}  // namespace

/// One hypothesis: `rows` of the problem, each with its coefficient c.
CommonError Adjuster::test_common_error(const Pass& pass, const std::vector<std::pair<int, double>>& rows) const {
  const adjustment::Linearisation& lin = pass.solution.linearisation;
  Eigen::VectorXd atc = Eigen::VectorXd::Zero(pass.solution.unknowns.count());
  std::vector<int> touched;
  double numerator = 0, own = 0;
  std::size_t b = 0;
  for (std::size_t i = 0; i < rows.size();) {  // rows ascend, so do blocks
    while (lin.blocks[b].row + lin.blocks[b].rows <= rows[i].first) ++b;
    const auto& block = lin.blocks[b];
    Eigen::VectorXd c = Eigen::VectorXd::Zero(block.rows);
    for (; i < rows.size() && rows[i].first < block.row + block.rows; ++i)
      c[rows[i].first - block.row] = rows[i].second;
    c = pass.problem.problem.residuals[b]->whitening() * c;
    numerator += c.dot(lin.residuals.segment(block.row, block.rows));
    own += c.squaredNorm();
    const Eigen::VectorXd part = lin.jacobian_of(block).transpose() * c;
    for (int k = 0; k < block.column_count; ++k) {
      const int unknown = lin.columns[static_cast<std::size_t>(block.column_begin + k)];
      if (atc[unknown] == 0) touched.push_back(unknown);
      atc[unknown] += part[k];
    }
  }
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  double network = 0;
  for (const int j : touched)
    for (const int i : touched) network += atc[i] * pass.cofactors(i, j) * atc[j];
  CommonError result;
  result.observations = static_cast<int>(rows.size());
  const double information = own - network;
  if (!(information > 1e-6 * own)) return result;  // the network cannot tell this error from its unknowns
  result.w = numerator / std::sqrt(information);
  result.size = -numerator / information;
  result.sigma = 1 / std::sqrt(information);
  return result;
}

double Adjuster::effect_of_instrument_height(const Pass& pass, int row) const {
  const ResultRow& o = m_.rows[row];
  const auto point = [&](const std::string& id) {
    const int block = pass.problem.point_blocks[m_.index.at(id)];
    return Eigen::Map<const Eigen::Vector3d>(pass.problem.problem.parameters[block].value.data());
  };
  const Eigen::Vector3d d = point(o.to) - point(o.from);
  const double h = d.head<2>().norm(), s = d.norm();
  if (!(s > 0)) return 0;
  return o.kind == "zenith_angle" ? -h / (s * s) : o.kind == "slope_distance" ? d.z() / s : 0;
}

CommonError Adjuster::largest_common_error(const Pass& pass) const {
  using Kind = CommonError::Kind;
  std::map<std::pair<Kind, std::string>, std::vector<std::pair<int, double>>> hypotheses;  // set-up "": all
  double single = critical_w();
  for (int r = 0; r < static_cast<int>(pass.problem.rows.size()); ++r) {
    const int row = pass.problem.rows[r];
    if (row < 0) continue;
    single = std::max(single, std::abs(pass.reliability.rows[r].w));
    const ResultRow& o = m_.rows[row];
    const bool distance = is_distance(o.kind);
    if (!o.removable || (!distance && o.kind != "zenith_angle")) continue;
    const std::string& own = o.set_up.empty() ? o.from : o.set_up;
    for (const std::string& set_up : {std::string(), own}) {
      if (distance) hypotheses[{Kind::constant, set_up}].emplace_back(r, 1.0);
      if (distance) hypotheses[{Kind::scale, set_up}].emplace_back(r, o.value);
      if (!distance) hypotheses[{Kind::index, set_up}].emplace_back(r, 1.0);
    }
    if (o.kind != "horizontal_distance")
      hypotheses[{Kind::height, own}].emplace_back(r, effect_of_instrument_height(pass, row));
  }
  CommonError worst;
  for (const auto& [hypothesis, rows] : hypotheses) {
    if (rows.size() < 3) continue;
    CommonError error = test_common_error(pass, rows);
    error.kind = hypothesis.first, error.set_up = hypothesis.second;
    // Sights of similar length cannot tell a constant from a scale: then the constant is the usual mistake.
    const double preference = error.kind == Kind::scale ? 0.95 : 1.0;
    if (preference * std::abs(error.w) > std::abs(worst.w)) worst = error;
  }
  return std::abs(worst.w) > single ? worst : CommonError{};
}

void Adjuster::report_common_error(const Pass& pass, NetworkResult& result) const {
  const CommonError error = largest_common_error(pass);
  if (error.observations == 0) return;
  result.findings.push_back({Finding::Severity::warning, describe(error), {}});
}

}  // namespace plumbline::survey

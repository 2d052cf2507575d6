// Two readings that control each other alone: taken out either way the network agrees, and the point that hangs on them
// lies elsewhere. Which of them went is chance, so it is said. What another reading j explains in place of one that
// was taken out, i, follows from the last factor: with i back (z = Q a_i, T = sigma_i^2 + a_i'z)
//   x' = x - z v_i / T,   Q' = Q - z z' / T,   v'Pv' = v'Pv + v_i^2 / T,
// and j explains w_j'^2 of that, with its test at x' and Q' (Baarda; rank-one update of Sherman and Morrison).
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>

#include "survey/adjust/adjuster.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

constexpr double kDecides = 10.8;  // of v'Pv: 0.1 %
constexpr std::size_t kMostCandidates = 50;
constexpr double kOneTest = 0.5;  // square of the correlation of two tests

/// A row of the problem that may explain what another one does.
struct Candidate {
  int row = -1;          // of the model
  double own = 0;        // c'Pc
  double numerator = 0;  // c'Pv with the other one back
  double shared = 0;     // c'PA z
  Eigen::VectorXd c;     // whitened
  std::size_t block = 0;
};

least_squares::Functional gradient_of(const least_squares::Linearisation& lin, const Candidate& candidate) {
  const auto& block = lin.blocks[candidate.block];
  const Eigen::VectorXd part = lin.jacobian_of(block).transpose() * candidate.c;
  least_squares::Functional gradient;
  for (int k = 0; k < block.column_count; ++k) gradient.emplace_back(lin.columns[block.column_begin + k], part[k]);
  return gradient;
}

std::string words_of(const ResultRow& row) {
  std::string kind = row.kind;
  std::replace(kind.begin(), kind.end(), '_', ' ');
  const std::string at = place(row.source);
  return kind + " " + row.from + " -> " + row.to + (at.empty() ? "" : " (" + at + ")");
}

}  // namespace

std::vector<Eigen::Vector3d> Adjuster::of_points(const Pass& pass, const Eigen::VectorXd& step) const {
  std::vector<Eigen::Vector3d> moved(m_.ids.size(), Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < m_.ids.size(); ++i)
    for (int k = 0; k < 3; ++k)
      if (const int unknown = pass.solution.unknowns(pass.problem.point_blocks[i], k); unknown >= 0)
        moved[i][k] = step[unknown];
  return moved;
}

std::vector<Adjuster::RivalReading> Adjuster::rivals_of(const Pass& pass, int row) const {
  const std::optional<TakenOut> out = taken_out(pass, row);
  if (!out) return {};
  const Eigen::VectorXd z = pass.cofactors.times(out->gradient);
  const double total = out->sigma * out->sigma + out->gradient.dot(z);
  const double explained = out->residual * out->residual / total;
  if (!(explained > kDecides)) return {};
  const least_squares::Linearisation& lin = pass.solution.linearisation;
  std::vector<Candidate> candidates;
  for (std::size_t b = 0; b < lin.blocks.size(); ++b) {
    const auto& block = lin.blocks[b];
    Eigen::VectorXd along(block.column_count);
    for (int k = 0; k < block.column_count; ++k) along[k] = z[lin.columns[block.column_begin + k]];
    const Eigen::VectorXd az = lin.jacobian_of(block) * along;
    if (az.isZero(0)) continue;
    const Eigen::MatrixXd whitening = pass.problem.problem.residuals[b]->whitening();
    for (int k = 0; k < block.rows; ++k) {
      Candidate one;
      one.row = pass.problem.rows[block.row + k];
      if (one.row < 0 || !m_.rows[one.row].removable || one.row == row) continue;
      one.block = b, one.c = whitening.col(k), one.own = one.c.squaredNorm(), one.shared = one.c.dot(az);
      one.numerator = one.c.dot(lin.residuals.segment(block.row, block.rows)) - one.shared * out->residual / total;
      // Its information is at least what it shares: where even that is too much it cannot explain enough. And one that
      // shares little is a misfit of its own: with it out the other one would fail as before.
      if (one.shared * one.shared > kOneTest * total * least_squares::kUncontrolled * one.own &&
          one.numerator * one.numerator > (explained - kDecides) * one.shared * one.shared / total)
        candidates.push_back(std::move(one));
    }
  }
  const auto most = [](const Candidate& c) { return c.shared * c.shared / c.own; };
  std::stable_sort(candidates.begin(), candidates.end(),
                   [&](const Candidate& a, const Candidate& b) { return most(a) > most(b); });
  if (candidates.size() > kMostCandidates) candidates.resize(kMostCandidates);
  std::vector<least_squares::Functional> gradients;
  for (const Candidate& c : candidates) gradients.push_back(gradient_of(lin, c));
  const Eigen::VectorXd network = pass.cofactors.variances(gradients);
  std::vector<RivalReading> rivals;
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    const Candidate& c = candidates[k];
    const double information = c.own - network[static_cast<Eigen::Index>(k)] + c.shared * c.shared / total;
    if (!(information > least_squares::kUncontrolled * c.own)) continue;
    if (!(c.shared * c.shared > kOneTest * total * information)) continue;
    const double less = explained - c.numerator * c.numerator / information;
    if (!(less < kDecides)) continue;
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(z.size());
    for (const auto& [unknown, value] : gradients[k]) gradient[unknown] += value;
    const Eigen::VectorXd step =
        -z * (out->residual / total) +
        (pass.cofactors.times(gradient) - z * (c.shared / total)) * (c.numerator / information);
    if (const auto elsewhere = lies_elsewhere(pass, of_points(pass, step)))
      rivals.push_back({c.row, less, elsewhere->point, elsewhere->by});
  }
  std::stable_sort(rivals.begin(), rivals.end(),
                   [](const RivalReading& a, const RivalReading& b) { return a.alike < b.alike; });
  return rivals;
}

void Adjuster::tell_rival_readings(const Pass& pass, const std::set<std::string>& told) {
  constexpr std::size_t kNamed = 3;
  std::size_t choices = 0;
  const std::set<int> misnamed(m_.misnamed.begin(), m_.misnamed.end());  // of them more is known than that they misfit
  for (int row = 0; row < static_cast<int>(m_.observations.size()); ++row) {
    if (!state_.removed[row] || misnamed.contains(row) || told.contains(m_.rows[row].to)) continue;
    const std::vector<RivalReading> rivals = rivals_of(pass, row);
    if (rivals.empty()) continue;
    std::string readings = words_of(m_.rows[row]);
    std::vector<std::string> points = {m_.rows[row].to};
    for (std::size_t k = 0; k < std::min(kNamed, rivals.size()); ++k) {
      readings += ", " + words_of(m_.rows[rivals[k].row]);
      const std::string& to = m_.rows[rivals[k].row].to;
      if (std::find(points.begin(), points.end(), to) == points.end()) points.push_back(to);
    }
    const std::string text =
        "1 of " + std::to_string(rivals.size() + 1) + " readings is wrong, and nothing tells which: " + readings +
        (rivals.size() > kNamed ? " and others" : "") + "; the first was taken out, and by the second " +
        m_.ids[rivals.front().point] + " lies " + fixed_digits(1000 * rivals.front().moved, 1) +
        " mm elsewhere; measure " + join(points) + " once more";
    m_.findings.push_back({Finding::Severity::warning, text, points, Finding::Subject::either});
    if (choices++ == 0 && told.empty()) either_ = text;
  }
  if (choices > 1 && told.empty()) either_ += " (and " + std::to_string(choices - 1) + " more of that kind)";
}

}  // namespace plumbline::survey

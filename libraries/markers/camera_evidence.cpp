#include "markers/camera_evidence.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <optional>
#include <tuple>

#include "geometry/median.hpp"
#include "geometry/random.hpp"

namespace plumbline::markers {
namespace {

constexpr int bootstrap_samples = 400;

/// Ratio of standard deviations of resampled photographs to `sigma`, median over the parameters.
double bootstrap_ratio(const CameraEvidence& evidence, const Eigen::VectorXd& sigma) {
  const auto p = static_cast<Eigen::Index>(evidence.parameters.size());
  const std::size_t n = evidence.score.size();
  const Eigen::MatrixXd total = evidence.formal.inverse();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(p, p);
  for (const Eigen::MatrixXd& one : evidence.information) sum += one.topLeftCorner(p, p);
  Random random(1, "photographs");
  std::vector<std::vector<double>> samples(static_cast<std::size_t>(p));
  for (int b = 0; b < bootstrap_samples; ++b) {
    // What the points and the board take of the information is the same in every sample.
    Eigen::MatrixXd normal = total - sum;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(p);
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t drawn = std::min(n - 1, static_cast<std::size_t>(random.uniform() * static_cast<double>(n)));
      normal += evidence.information[drawn].topLeftCorner(p, p), right += evidence.score[drawn].head(p);
    }
    const Eigen::LDLT<Eigen::MatrixXd> factor(normal);
    if (!factor.isPositive()) continue;
    const Eigen::VectorXd moved = factor.solve(right);
    for (Eigen::Index k = 0; k < p; ++k) samples[static_cast<std::size_t>(k)].push_back(moved(k));
  }
  // By the quartiles: a sample of few distinct photographs determines hardly anything.
  std::vector<double> ratios;
  for (Eigen::Index k = 0; k < p; ++k) {
    auto& values = samples[static_cast<std::size_t>(k)];
    if (values.size() < 50 || !(sigma(k) > 0)) continue;
    std::sort(values.begin(), values.end());
    const double spread = values[3 * values.size() / 4] - values[values.size() / 4];
    ratios.push_back(spread / 1.349 / sigma(k));
  }
  return ratios.empty() ? std::nan("") : upper_median(ratios);
}

}  // namespace

bool before_by_name(const std::string& a, const std::string& b) {
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (digit(a[i]) && digit(b[j])) {
      const auto number = [&](const std::string& text, std::size_t& at) {
        while (at < text.size() && text[at] == '0') ++at;
        const std::size_t from = at;
        while (at < text.size() && digit(text[at])) ++at;
        return text.substr(from, at - from);
      };
      const std::string one = number(a, i), two = number(b, j);
      if (one.size() != two.size()) return one.size() < two.size();
      if (one != two) return one < two;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
    }
  }
  return a.size() - i < b.size() - j;
}

Eigen::Matrix2d effects_at(const Eigen::Vector2d& pixel, int height) {
  return (pixel.y() / height - 0.5) * Eigen::Matrix2d::Identity();
}

CameraEvidence evidence_of(const std::vector<PhotographShare>& shares, const Eigen::MatrixXd& cofactor, double factor,
                           const std::vector<int>& columns, const std::vector<int>& members,
                           const std::vector<std::string>& paths) {
  CameraEvidence evidence;
  std::vector<int> wanted;
  for (std::size_t k = 0; k < columns.size(); ++k)
    if (columns[k] >= 0) evidence.parameters.push_back(static_cast<int>(k)), wanted.push_back(columns[k]);
  evidence.formal = factor * cofactor(wanted, wanted);
  std::vector<std::size_t> order(members.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return before_by_name(paths[a], paths[b]); });
  const auto kept = static_cast<int>(cofactor.rows());
  for (int e = 0; e < effect_count; ++e) wanted.push_back(kept + e);
  const auto n = static_cast<Eigen::Index>(wanted.size());
  for (const std::size_t k : order) {
    const PhotographShare& share = shares[static_cast<std::size_t>(members[k])];
    evidence.paths.push_back(paths[k]), evidence.members.push_back(members[k]);
    Eigen::VectorXd score = Eigen::VectorXd::Zero(n);
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
    std::vector<Eigen::Index> at;
    for (const int column : wanted) {
      const auto found = std::lower_bound(share.columns.begin(), share.columns.end(), column);
      const bool there = found != share.columns.end() && *found == column;
      at.push_back(there ? found - share.columns.begin() : -1);
    }
    for (Eigen::Index i = 0; i < n; ++i) {
      if (at[static_cast<std::size_t>(i)] < 0) continue;
      score(i) = share.score(at[static_cast<std::size_t>(i)]) / factor;
      for (Eigen::Index j = 0; j < n; ++j)
        if (at[static_cast<std::size_t>(j)] >= 0)
          information(i, j) =
              share.information(at[static_cast<std::size_t>(i)], at[static_cast<std::size_t>(j)]) / factor;
    }
    evidence.score.push_back(score), evidence.information.push_back(information);
    const std::vector<int> parameters(wanted.begin(), wanted.end() - effect_count);
    evidence.change_without.push_back(change_without(share, cofactor, parameters));
  }
  return evidence;
}

EmpiricalCovariance empirical_covariance(const CameraEvidence& evidence) {
  EmpiricalCovariance result;
  result.photographs = static_cast<int>(evidence.score.size());
  result.written = result.scatter = evidence.formal;
  const auto p = evidence.formal.rows();
  result.sigma_ratio = Eigen::VectorXd::Ones(p);
  const Eigen::LLT<Eigen::MatrixXd> root(evidence.formal);
  if (p == 0 || result.photographs < fewest_to_scatter || root.info() != Eigen::Success) return result;
  const double n = result.photographs;
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(p);
  for (const Eigen::VectorXd& change : evidence.change_without) mean += change / n;
  // In units of the formal covariance: a sound model gives the unit matrix.
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(p, p);
  std::vector<Eigen::MatrixXd> products;
  for (const Eigen::VectorXd& change : evidence.change_without) {
    const Eigen::VectorXd whitened = std::sqrt(n - 1) * root.matrixL().solve(change - mean);
    products.emplace_back(whitened * whitened.transpose());
    scatter += products.back() / n;
  }
  if (!scatter.allFinite()) return result;
  const double level = std::max(0.0, scatter.trace() / static_cast<double>(p));
  const Eigen::MatrixXd target = level * Eigen::MatrixXd::Identity(p, p);
  double noise = 0;
  for (const Eigen::MatrixXd& product : products) noise += (product - scatter).squaredNorm() / (n * n);
  const double apart = (scatter - target).squaredNorm();
  const double shrink = apart > 0 ? std::min(1.0, noise / apart) : 1.0;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(shrink * target + (1 - shrink) * scatter);
  const Eigen::MatrixXd larger =
      axes.eigenvectors() * axes.eigenvalues().cwiseMax(1).asDiagonal() * axes.eigenvectors().transpose();
  const Eigen::MatrixXd lower = root.matrixL();
  result.judged = true;
  result.scatter = lower * scatter * lower.transpose();
  result.written = lower * larger * lower.transpose();
  result.written = (0.5 * (result.written + result.written.transpose())).eval();
  result.factor = std::sqrt(larger.trace() / static_cast<double>(p));
  result.sigma_ratio = (result.written.diagonal().array() / evidence.formal.diagonal().array()).sqrt();
  result.bootstrap_ratio = bootstrap_ratio(evidence, result.scatter.diagonal().cwiseMax(0).cwiseSqrt());
  return result;
}

Eigen::MatrixXd in_nine(const CameraEvidence& evidence, const Eigen::MatrixXd& of_estimated) {
  Eigen::MatrixXd nine = Eigen::MatrixXd::Zero(BrownCamera::parameter_count, BrownCamera::parameter_count);
  for (std::size_t i = 0; i < evidence.parameters.size(); ++i)
    for (std::size_t j = 0; j < evidence.parameters.size(); ++j)
      nine(evidence.parameters[i], evidence.parameters[j]) =
          of_estimated(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  return nine;
}

namespace {

constexpr std::array<Scatter::Kind, 3> kinds_of_scatter{Scatter::Kind::focus, Scatter::Kind::principal_point, Scatter::Kind::rolling_shutter};
using Rms = std::array<double, kinds_of_scatter.size()>;  // of each; 0: there is no such effect

/// The likelihood of all photographs' scores if each has effects of its own.
class JointScatter {
 public:
  JointScatter(const CameraEvidence& evidence, const BrownCamera& camera) : largest_{0.3, 0.1 * camera.width, 0.1 * camera.width} {
    const auto p = static_cast<Eigen::Index>(evidence.parameters.size());
    const auto values = camera.parameters();
    Eigen::MatrixXd directions = Eigen::MatrixXd::Zero(p + effect_count, size);
    for (Eigen::Index at = 0; at < p; ++at) {
      const int parameter = evidence.parameters[static_cast<std::size_t>(at)];
      if (parameter < 2) directions(at, 0) = values[static_cast<std::size_t>(parameter)];
      if (parameter == 2 || parameter == 3) directions(at, parameter - 1) = 1;
    }
    directions.bottomRightCorner<effect_count, effect_count>().setIdentity();
    normal_ = Eigen::MatrixXd::Zero(p, p), sum_ = Eigen::VectorXd::Zero(p);
    for (std::size_t i = 0; i < evidence.score.size(); ++i) {
      scores_.emplace_back(directions.transpose() * evidence.score[i]);
      const Eigen::MatrixXd through = directions.transpose() * evidence.information[i];
      information_.emplace_back(through * directions);
      through_.emplace_back(through.leftCols(p));
      normal_ += evidence.information[i].topLeftCorner(p, p), sum_ += evidence.score[i].head(p);
    }
  }

  /// Logarithm of the likelihood over that of no effect, the common parameters where they fit best: each photograph's
  /// score has the covariance J + J T J.
  double gain(const Rms& rms) const { return profile(rms).first; }

  /// How far the common parameters move with these effects.
  Eigen::VectorXd moved(const Rms& rms) const { return profile(rms).second; }

  /// The rms of the effects that are not 0 in `rms` and of `added` that are most likely, each in turn until none moves.
  std::pair<double, Rms> best(Rms rms, std::optional<std::size_t> added) const {
    double value = gain(rms);
    if (added) {
      Rms tried = rms;
      double first = -std::numeric_limits<double>::infinity();
      for (double each = largest_[*added]; each > 1e-4 * largest_[*added]; each /= 1.5) {
        tried[*added] = each;
        if (const double found = gain(tried); found > first) first = found, rms = tried;
      }
      value = first;
    }
    for (double step = 1.5; step > 1.01;) {
      bool moved = false;
      for (std::size_t k = 0; k < rms.size(); ++k)
        for (const double factor : {step, 1 / step}) {
          double& each = rms[k];
          const double before = each;
          each = std::min(factor * each, largest_[k]);
          const double found = before > 0 ? gain(rms) : value;
          if (found > value + 1e-9)
            value = found, moved = true;
          else
            each = before;
        }
      if (!moved) step = std::sqrt(step);
    }
    return {value, rms};
  }

 private:
  static constexpr int size = 3 + effect_count;
  using Vector = Eigen::Matrix<double, size, 1>;
  using Matrix = Eigen::Matrix<double, size, size>;
  using Through = Eigen::Matrix<double, size, Eigen::Dynamic, 0, size, BrownCamera::parameter_count>;

  std::pair<double, Eigen::VectorXd> profile(const Rms& rms) const {
    Vector sigma;
    sigma << rms[0], rms[1], rms[1], rms[2], rms[2];
    double sum = 0;
    Eigen::MatrixXd normal = normal_;
    Eigen::VectorXd right = sum_;
    for (std::size_t i = 0; i < scores_.size(); ++i) {
      const Matrix inflated = Matrix::Identity() + (sigma.asDiagonal() * information_[i] * sigma.asDiagonal()).eval();
      const Eigen::LLT<Matrix> root(inflated);
      const Vector scaled = root.matrixL().solve(sigma.cwiseProduct(scores_[i]));
      const Through through = root.matrixL().solve((sigma.asDiagonal() * through_[i]).eval());
      sum += 0.5 * scaled.squaredNorm() - root.matrixLLT().diagonal().array().log().sum();
      normal.noalias() -= through.transpose() * through, right.noalias() -= through.transpose() * scaled;
    }
    const Eigen::LDLT<Eigen::MatrixXd> factor(normal);
    if (!factor.isPositive()) return {-std::numeric_limits<double>::infinity(), Eigen::VectorXd::Zero(right.size())};
    const Eigen::VectorXd by = factor.solve(right);
    return {sum + 0.5 * right.dot(by), by};
  }

  Rms largest_;
  Eigen::MatrixXd normal_;
  Eigen::VectorXd sum_;  // of the scores: what the adjustment left of them
  std::vector<Through> through_;
  std::vector<Vector> scores_;
  std::vector<Matrix> information_;
};

}  // namespace

std::vector<Scatter> explain_scatter(const CameraEvidence& evidence, const BrownCamera& camera) {
  if (evidence.parameters.empty()) return {};
  const JointScatter joint(evidence, camera);
  Rms rms{};
  double reached = 0;
  std::vector<Scatter> causes(kinds_of_scatter.size());
  for (;;) {
    std::array<std::pair<double, Rms>, kinds_of_scatter.size()> with;
    std::size_t best = 0, next = 0;  // of those that are not among them yet
    for (std::size_t k = 0; k < with.size(); ++k) {
      with[k] = {-std::numeric_limits<double>::infinity(), {}};
      if (!(rms[k] > 0)) with[k] = joint.best(rms, k);
    }
    for (std::size_t k = 1; k < with.size(); ++k)
      if (with[k].first > with[best].first) best = k;
    next = best == 0 ? 1 : 0;
    for (std::size_t k = 0; k < with.size(); ++k)
      if (k != best && with[k].first > with[next].first) next = k;
    if (!(with[best].first > reached + significant_gain)) break;
    if (with[next].first > std::max(reached, with[best].first - significant_gain))
      causes[best].instead = kinds_of_scatter[next], causes[best].instead_rms = with[next].second[next];
    std::tie(reached, rms) = with[best];
  }
  // What came first may be of no use beside what came after.
  for (std::size_t k = 0; k < rms.size(); ++k) {
    if (!(rms[k] > 0)) continue;
    Rms others = rms;
    others[k] = 0;
    const auto without = joint.best(others, std::nullopt);
    causes[k].gain = reached - without.first;
    if (!(causes[k].gain > significant_gain)) std::tie(reached, rms) = without;
  }
  for (std::size_t k = 0; k < rms.size(); ++k) {
    if (rms[k] > 0) causes[k].kind = kinds_of_scatter[k], causes[k].rms = rms[k];
    if (rms_of(causes, causes[k].instead) > 0) causes[k].instead = Scatter::Kind::none;
  }
  std::erase_if(causes, [](const Scatter& cause) { return cause.kind == Scatter::Kind::none; });
  std::stable_sort(causes.begin(), causes.end(), [](const Scatter& a, const Scatter& b) { return a.gain > b.gain; });
  return causes;
}

CameraEvidence about_common(const CameraEvidence& evidence, const BrownCamera& camera,
                            const std::vector<Scatter>& causes) {
  const Rms rms{rms_of(causes, Scatter::Kind::focus), rms_of(causes, Scatter::Kind::principal_point), 0};
  if (evidence.parameters.empty() || rms == Rms{}) return evidence;
  const Eigen::VectorXd moved = JointScatter(evidence, camera).moved(rms);
  CameraEvidence about = evidence;
  for (std::size_t i = 0; i < about.score.size(); ++i)
    about.score[i] -= about.information[i].leftCols(moved.size()) * moved;
  return about;
}

double rms_of(const std::vector<Scatter>& causes, Scatter::Kind kind) {
  for (const Scatter& cause : causes)
    if (kind != Scatter::Kind::none && cause.kind == kind) return cause.rms;
  return 0;
}

CameraEvidence without_rolling_shutter(const CameraEvidence& evidence, double rms) {
  CameraEvidence left = evidence;
  const auto p = static_cast<Eigen::Index>(evidence.parameters.size());
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(p, p);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(p);
  for (std::size_t i = 0; i < evidence.score.size(); ++i) {
    Eigen::MatrixXd &all = left.information[i], own = all.bottomRightCorner<effect_count, effect_count>();
    own += Eigen::MatrixXd::Identity(effect_count, effect_count) / (rms * rms);
    const Eigen::MatrixXd through = all.topRightCorner(p, effect_count) * own.inverse();
    left.score[i].head(p) -= through * evidence.score[i].tail(effect_count);
    all.topLeftCorner(p, p) -= (through * all.bottomLeftCorner(effect_count, p)).eval();
    normal += all.topLeftCorner(p, p), right += left.score[i].head(p);
  }
  const Eigen::VectorXd moved = normal.ldlt().solve(right);
  for (std::size_t i = 0; i < left.score.size(); ++i)
    left.score[i].head(p) -= left.information[i].topLeftCorner(p, p) * moved;
  left.formal = normal.inverse();
  return left;
}

namespace {

/// What it is like, and what to do about it.
std::pair<std::string, std::string> words_of(Scatter::Kind kind, double rms) {
  char text[200] = "";
  switch (kind) {
    case Scatter::Kind::focus:
      std::snprintf(text, sizeof text,
                    "a principal distance that differs by %.2f %% rms from photograph to photograph (an autofocus or a "
                    "zoom)",
                    100 * rms);
      return {text, "fix the focus"};
    case Scatter::Kind::principal_point:
      std::snprintf(text, sizeof text,
                    "a principal point that moves by %.1f px rms from photograph to photograph (a stabiliser, or a "
                    "lens that is loose)",
                    rms);
      return {text, "switch the stabiliser off"};
    case Scatter::Kind::rolling_shutter:
      std::snprintf(text, sizeof text,
                    "rows read one after another while the camera moves, by %.1f px rms from the first to the last (a "
                    "rolling shutter)",
                    rms);
      return {text, "hold the camera still"};
    case Scatter::Kind::none:
      break;
  }
  return {};
}

}  // namespace

std::string scatter_in_words(const EmpiricalCovariance& empirical) {
  char text[300];
  std::snprintf(text, sizeof text,
                "the %d photographs scatter %.1f times as far as their corners allow: the standard deviations of the "
                "camera are made of that scatter",
                empirical.photographs, empirical.factor);
  return text;
}

std::string in_words(const EmpiricalCovariance& empirical, const std::vector<Scatter>& causes) {
  // Sound photographs scatter by chance, too: 20 of them by 1.4 times in the mean, as no direction counts less than 1.
  const double told = causes.empty() ? 3 : 1.5;
  if (!empirical.judged || !(empirical.factor > told)) return "";
  const std::string words = scatter_in_words(empirical);
  if (causes.empty()) return words + "; lens or board are not quite as the model has them";
  std::string like, remedy;
  for (const Scatter& cause : causes) {
    const auto [own, own_remedy] = words_of(cause.kind, cause.rms);
    const auto [other, other_remedy] = words_of(cause.instead, cause.instead_rms);
    like += (like.empty() ? "" : ", and ") + own + (other.empty() ? "" : ", or nearly as much like " + other);
    remedy += (remedy.empty() ? "" : ", ") + own_remedy + (other.empty() ? "" : ", " + other_remedy);
  }
  remedy[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(remedy[0])));
  return words + ". It is most like " + like + ". " + remedy;
}

}  // namespace plumbline::markers

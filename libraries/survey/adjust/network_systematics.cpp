// Errors that all readings of a set-up have in common: a wrong prism constant, a wrong ppm setting, an index error.
// Each reading shows a little of such an error, and data snooping, which looks for single wrong readings, takes
// innocent ones out. So each is tested as one alternative hypothesis (Teunissen 2000): observations = f(x) + c e, with
//   w = c'Pv / sqrt(c' P Qvv P c),   e = -c'Pv / (c' P Qvv P c).
// w^2 is what the hypothesis takes off v'Pv, which makes it comparable with the w of a single observation.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "survey/adjust/adjuster.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

bool is_distance(const std::string& kind) { return kind == "slope_distance" || kind == "horizontal_distance"; }

/// What the mistakes of the field can amount to: prism constants, settings of ppm, indices, heights read off a tape.
/// What is larger is another mistake, or none of these.
double largest_plausible(CommonError::Kind kind) {
  switch (kind) {
    case CommonError::Kind::constant:
    case CommonError::Kind::reflector:
      return 0.1;  // [m]
    case CommonError::Kind::scale:
      return 1e-3;
    case CommonError::Kind::index:
    case CommonError::Kind::face_index:
    case CommonError::Kind::collimation:
      return 0.016;  // [rad], 1 gon
    case CommonError::Kind::height:
    case CommonError::Kind::target:
      return 5.0;  // [m]: a pole of 2 m in feet
    case CommonError::Kind::tilt:
    case CommonError::Kind::twist:
      return 0.016;  // [rad], 1 gon
    case CommonError::Kind::sink:
      return 0.1;  // [m]
    case CommonError::Kind::edge:
      return 1.0;  // [m]
    case CommonError::Kind::circle:
      return std::numbers::pi;
  }
  return 0;
}

/// What the rows say of an error c that they have in common: c'Pv, c'Pc, and A'Pc.
struct CommonTest {
  double numerator = 0, own = 0;
  least_squares::Functional network;
};

CommonTest common_test(const Pass& pass, const std::vector<std::pair<int, double>>& rows, Eigen::VectorXd& atc) {
  const least_squares::Linearisation& lin = pass.solution.linearisation;
  CommonTest test;
  atc.setZero(pass.solution.unknowns.count());
  const auto block_of = [&](int row) {  // the last that begins at the row or before
    return static_cast<std::size_t>(std::upper_bound(lin.blocks.begin(), lin.blocks.end(), row,
                                                     [](int r, const auto& block) { return r < block.row; }) -
                                    lin.blocks.begin() - 1);
  };
  for (std::size_t i = 0; i < rows.size();) {  // rows ascend, so do blocks
    const std::size_t b = block_of(rows[i].first);
    const auto& block = lin.blocks[b];
    Eigen::VectorXd c = Eigen::VectorXd::Zero(block.rows);
    for (; i < rows.size() && rows[i].first < block.row + block.rows; ++i)
      c[rows[i].first - block.row] = rows[i].second;
    c = pass.problem.problem.residuals[b]->whitening() * c;
    test.numerator += c.dot(lin.residuals.segment(block.row, block.rows));
    test.own += c.squaredNorm();
    const Eigen::VectorXd part = lin.jacobian_of(block).transpose() * c;
    for (int k = 0; k < block.column_count; ++k) atc[lin.columns[block.column_begin + k]] += part[k];
  }
  for (int k = 0; k < static_cast<int>(atc.size()); ++k)
    if (atc[k] != 0) test.network.emplace_back(k, atc[k]);
  return test;
}

}  // namespace

/// With an unknown for it (e = -c'Pv / information) the unknowns move by Q A'P c (-e), and v'Pv loses w^2.
Adjuster::MendedPlaces Adjuster::places_by_equations(const Pass& pass, const CommonError& error) const {
  Eigen::VectorXd gradient;
  common_test(pass, *error.rows, gradient);
  const Eigen::VectorXd step = pass.cofactors.times(gradient) * -error.size;
  MendedPlaces mended{pass.solution.sum_of_squares() - error.w * error.w, of_points(pass, step)};
  for (std::size_t i = 0; i < mended.places.size(); ++i)
    mended.places[i] +=
        Eigen::Map<const Eigen::Vector3d>(pass.problem.problem.parameters[pass.problem.point_blocks[i]].value.data());
  return mended;
}

std::vector<CommonError> Adjuster::test(const Pass& pass, const std::vector<Hypothesis>& hypotheses) const {
  std::vector<CommonTest> tests;
  std::vector<least_squares::Functional> functionals;
  Eigen::VectorXd work;
  for (const Hypothesis& h : hypotheses) {
    tests.push_back(common_test(pass, h.rows, work));
    functionals.push_back(std::move(tests.back().network));
  }
  const Eigen::VectorXd network = pass.cofactors.variances(functionals);
  std::vector<CommonError> errors;
  for (std::size_t k = 0; k < hypotheses.size(); ++k) {
    CommonError& result = errors.emplace_back(hypotheses[k].error);
    result.observations = static_cast<int>(hypotheses[k].rows.size());
    result.rows = std::make_shared<const std::vector<std::pair<int, double>>>(hypotheses[k].rows);
    const double information = tests[k].own - network[static_cast<Eigen::Index>(k)];
    // The network cannot tell this error from its unknowns: a scale in a free network, the height of a free station.
    // What is left of it there is noise of linearisation and of weak ties.
    if (!(information > 1e-3 * tests[k].own)) continue;
    result.w = tests[k].numerator / std::sqrt(information);
    result.size = -tests[k].numerator / information;
    result.sigma = 1 / std::sqrt(information);
  }
  return errors;
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

void Adjuster::find_set_ups_of_rows() {
  set_up_of_row_.assign(m_.rows.size(), -1);
  for (size_t row = 0; row < m_.observations.size(); ++row)
    set_up_of_row_[row] = m_.observations[row].observation.set_up;
}

std::vector<CommonError> Adjuster::common_errors(const Pass& pass) const {
  using Kind = CommonError::Kind;
  std::map<std::pair<Kind, int>, std::vector<std::pair<int, double>>> hypotheses;  // set-up -1: all
  for (int r = 0; r < static_cast<int>(pass.problem.rows.size()); ++r) {
    const int row = pass.problem.rows[r];
    if (row < 0) continue;
    const ResultRow& o = m_.rows[row];
    const bool distance = is_distance(o.kind);
    const int own = set_up_of_row_[row];
    if (!o.removable || own < 0 || (!distance && o.kind != "zenith_angle")) continue;
    for (const int set_up : {-1, own}) {
      if (distance) hypotheses[{Kind::constant, set_up}].emplace_back(r, 1.0);
      if (distance) hypotheses[{Kind::scale, set_up}].emplace_back(r, o.value);
      if (!distance) hypotheses[{Kind::index, set_up}].emplace_back(r, 1.0);
    }
    if (o.kind != "horizontal_distance")
      hypotheses[{Kind::height, own}].emplace_back(r, effect_of_instrument_height(pass, row));
  }
  std::vector<Hypothesis> all = target_heights(pass);
  for (Hypothesis& h : face_errors(pass)) all.push_back(std::move(h));
  for (auto& [hypothesis, rows] : hypotheses) {
    if (rows.size() < 3) continue;
    CommonError error;
    error.kind = hypothesis.first, error.set_up = hypothesis.second;
    all.push_back({error, std::move(rows)});
  }
  return test(pass, all);
}

/// A pole set to another length than noted: all sights of a set-up with this height noted, where it has others too
/// (with one height alone it is the instrument's that may be wrong).
std::vector<Adjuster::Hypothesis> Adjuster::target_heights(const Pass& pass) const {
  std::map<int, std::map<double, std::vector<std::pair<int, double>>>> by_height;  // set-up -> height noted -> rows
  for (int r = 0; r < static_cast<int>(pass.problem.rows.size()); ++r) {
    const int row = pass.problem.rows[r];
    if (row < 0 || static_cast<size_t>(row) >= m_.observations.size()) continue;
    const ResultRow& o = m_.rows[row];
    const int own = set_up_of_row_[row];
    if (!o.removable || own < 0 || (o.kind != "zenith_angle" && o.kind != "slope_distance")) continue;
    const double height = m_.observations[row].observation.target_height;
    by_height[own][std::isnan(height) ? 0 : height].emplace_back(r, -effect_of_instrument_height(pass, row));
  }
  std::vector<Hypothesis> all;
  for (const auto& [set_up, heights] : by_height)
    for (const auto& [height, rows] : heights) {
      if (heights.size() < 2 || rows.size() < 4) continue;  // two sights
      CommonError error;
      error.kind = CommonError::Kind::target, error.set_up = set_up, error.target_height = height;
      all.push_back({error, rows});
    }
  return all;
}

/// A step in the directions of a set-up, in the order they were read. Many tests, so only where a direction fails.
std::vector<Adjuster::Hypothesis> Adjuster::circles(const Pass& pass) const {
  constexpr size_t kFewest = 3;                                // on either side: fewer are as well wrong one by one
  std::map<int, std::vector<std::pair<int, int>>> directions;  // set-up -> first reading, row of the problem
  std::set<int> failing;
  for (int r = 0; r < static_cast<int>(pass.problem.rows.size()); ++r) {
    const int row = pass.problem.rows[r];
    if (row < 0 || m_.rows[row].kind != "direction" || !m_.rows[row].removable) continue;
    const int set_up = set_up_of_row_[row];
    directions[set_up].emplace_back(m_.observations[row].members.front(), r);
    if (std::abs(pass.reliability.rows[r].w) > critical_w()) failing.insert(set_up);
  }
  std::vector<Hypothesis> all;
  for (const int set_up : failing) {
    auto& list = directions.at(set_up);
    std::sort(list.begin(), list.end());
    for (size_t k = kFewest; k + kFewest <= list.size(); ++k) {
      std::vector<std::pair<int, double>> rows;
      for (size_t i = k; i < list.size(); ++i) rows.emplace_back(list[i].second, 1.0);
      std::sort(rows.begin(), rows.end());
      CommonError error;
      error.kind = CommonError::Kind::circle, error.set_up = set_up;
      error.first = pass.problem.rows[list[k].second];
      all.push_back({error, std::move(rows)});
    }
  }
  return all;
}

namespace {

/// What a hypothesis explains, as |w| of one that was stated before the readings were looked at.
double explained(const CommonError& error) {
  // Sights of similar length cannot tell a constant from a scale: then the constant is the usual mistake.
  // Likewise an index of all from one with the sign of the face, where no target was read in both.
  const bool of_face = error.kind == CommonError::Kind::face_index || error.kind == CommonError::Kind::collimation;
  const double preference = error.kind == CommonError::Kind::scale ? 0.95 : of_face ? 1.01 : 1.0;
  return preference * std::sqrt(std::max(0.0, error.w * error.w - error.penalty));
}

/// Whether one turns sights and the other lengthens them: points come to lie elsewhere.
bool differ(const CommonError& a, const CommonError& b) {
  const auto turns = [](const CommonError& e) { return e.kind == CommonError::Kind::circle; };
  const auto lengthens = [](const CommonError& e) {
    return e.kind == CommonError::Kind::constant || e.kind == CommonError::Kind::reflector ||
           e.kind == CommonError::Kind::scale;
  };
  return (turns(a) && lengthens(b)) || (lengthens(a) && turns(b));
}

}  // namespace

/// What nobody can mend may be what one reading looks like: an edge, sighted from two sides that are nearly one.
CommonError Adjuster::as_good_as_a_reading(int suspect, double least, const std::vector<CommonError>& errors) const {
  CommonError best;
  for (const CommonError& error : errors)
    if (!can_be_mended(error.kind) && explained(error) > explained(best)) best = error;
  if (suspect < 0 || best.observations == 0 || !(best.w * best.w - best.penalty > least) ||
      explained(best) < critical_removal())
    return {};
  return best;
}

CommonError Adjuster::largest_common_error(const Pass& pass, std::vector<CommonError> errors,
                                           const std::set<int>& left_alone) {
  double single = critical_removal();
  int suspect = -1;  // row of the problem
  for (int r = 0; r < static_cast<int>(pass.problem.rows.size()); ++r)
    if (pass.problem.rows[r] >= 0 && !left_alone.contains(pass.problem.rows[r]) &&
        std::abs(pass.reliability.rows[r].w) > single)
      single = std::abs(pass.reliability.rows[r].w), suspect = r;
  for (std::vector<CommonError> more : {test(pass, circles(pass)), reflectors(pass), set_up_motions(pass)})
    errors.insert(errors.end(), more.begin(), more.end());
  std::erase_if(errors, [&](const CommonError& error) {
    if (std::abs(error.size) > largest_plausible(error.kind) || refused_.contains(error.key())) return true;
    if (left_alone.empty()) return false;
    const std::set<int> own = rows_of(error.set_up, error.sights);
    return std::any_of(own.begin(), own.end(), [&](int row) { return left_alone.contains(row); });
  });
  CommonError worst;
  for (const CommonError& error : errors)
    if (explained(error) > explained(worst)) worst = error;
  // Where little is controlled one reading and many explain the same misfit equally well.
  constexpr double kClearlyMore = 1.01;
  constexpr double kClearly = 10.8;  // of w^2: 0.1 %
  if (!(std::sqrt(std::max(0.0, worst.w * worst.w - worst.penalty)) > kClearlyMore * single))
    return as_good_as_a_reading(suspect, single * single - kClearly, errors);
  CommonError rival;
  for (const CommonError& error : errors)
    if (differ(error, worst) && explained(error) > explained(rival)) rival = error;
  if (rival.observations > 0 && std::pow(explained(worst), 2) - std::pow(explained(rival), 2) < kClearly)
    worst.rival = describe(rival);
  std::erase_if(errors, [&](const CommonError& error) { return differ(error, worst); });
  if (!can_be_mended(worst.kind)) return worst;
  if (const CommonError equal = rival_of(pass, worst, std::move(errors)); equal.observations > 0) {
    worst.equal = describe(equal);
    worst.equal_set_up = equal.set_up, worst.equal_sights = equal.sights;
  }
  return worst;
}

void Adjuster::split_set_up(const CommonError& error) {
  SetUp part = m_.survey.set_ups[error.set_up];
  const auto taken = [&](const std::string& id) {
    return std::any_of(m_.survey.set_ups.begin(), m_.survey.set_ups.end(), [&](const SetUp& s) { return s.id == id; });
  };
  int number = 2;
  const std::string base = part.id;
  while (taken(part.id = base + " (part " + std::to_string(number) + ")")) ++number;
  const int index = static_cast<int>(m_.survey.set_ups.size());
  m_.survey.set_ups.push_back(part);
  m_.orientations.push_back(m_.orientations[error.set_up] - error.size);
  const int from = m_.observations[error.first].members.front();
  for (size_t i = 0; i < m_.observations.size(); ++i) {
    Observation& o = m_.observations[i].observation;
    if (o.set_up != error.set_up || m_.observations[i].members.front() < from) continue;
    o.set_up = index;
    m_.rows[i].set_up = part.id;
  }
  find_set_ups_of_rows();
}

void Adjuster::apply(const CommonError& error) {
  if (error.kind == CommonError::Kind::circle) return split_set_up(error);
  static constexpr ExtraUnknown::Kind kinds[] = {ExtraUnknown::Kind::constant,    ExtraUnknown::Kind::scale,
                                                 ExtraUnknown::Kind::index,       ExtraUnknown::Kind::height,
                                                 ExtraUnknown::Kind::target,      ExtraUnknown::Kind::face_index,
                                                 ExtraUnknown::Kind::collimation, ExtraUnknown::Kind::reflector};
  state_.extra.push_back({kinds[static_cast<int>(error.kind)], error.set_up, error.target_height, error.sights});
}

bool Adjuster::estimate(Pass& pass, const CommonError& error) {
  using Kind = CommonError::Kind;
  constexpr size_t kMost = 12;  // beyond that nothing is common any more
  if (state_.extra.size() >= kMost) return false;
  const NetworkModel before = m_;
  const StochasticState state = state_;
  apply(error);
  m_.findings.push_back(
      {Finding::Severity::warning,
       describe(error) + (error.kind == Kind::circle ? "; the sights after it have an orientation of their own now"
                                                     : "; it was estimated with the network and taken off"),
       {}});
  try {
    Pass next = adjust();
    // The test was of the linearised network: what it promised must come true.
    if (next.solution.sum_of_squares() > pass.solution.sum_of_squares() - 0.5 * error.w * error.w)
      throw NetworkError("no gain");
    pass = std::move(next);
    if (!error.rival.empty()) undecided_ = describe(error) + ", or " + error.rival;
    return true;
  } catch (const NetworkError&) {
    m_ = before;
    state_ = state;
    find_set_ups_of_rows();
    return false;
  }
}

}  // namespace plumbline::survey

#include "building/judgement/surface_errors.hpp"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/packed_symmetric.hpp"

namespace plumbline::judgement {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

struct PanelQuantity {
  const char* name;
  Vector6 by_coefficients;
};

/// Rows: offset of the best plane, both tilts, both bows, twist. The best plane of 1 − x² lies two thirds up.
std::array<PanelQuantity, 6> quantities(const SurfaceFaceT& face) {
  std::array<PanelQuantity, 6> rows;
  const char* names[] = {"offset", "tilt", "tilt", "bow", "bow", "twist"};
  for (Eigen::Index i = 0; i < 6; ++i) rows[i] = {names[i], Vector6::Unit(i)};
  rows[0].by_coefficients(3) = rows[0].by_coefficients(4) = 2.0 / 3;
  rows[1].by_coefficients *= 2 / face.width, rows[2].by_coefficients *= 2 / face.height;
  return rows;
}

struct MeasuredPanel {
  const PanelSurfaceFiguresT* figures;
  Vector6 error;
};

/// Joint covariance of the coefficients of all panels: random parts by themselves, systematic ones by what is common.
Eigen::MatrixXd covariance_of(const std::vector<MeasuredPanel>& panels, int rank) {
  const auto n = static_cast<Eigen::Index>(panels.size());
  Eigen::MatrixXd factor(6 * n, rank), all = Eigen::MatrixXd::Zero(6 * n, 6 * n);
  for (Eigen::Index p = 0; p < n; ++p) {
    const PanelSurfaceFiguresT& panel = *panels[p].figures;
    all.block<6, 6>(6 * p, 6 * p) = unpack_symmetric(panel.coefficients_random, 6, "panel " + panel.face->id);
    if (static_cast<Eigen::Index>(panel.coefficients_factor.size()) != 6 * rank)
      throw std::runtime_error("panel " + panel.face->id + " has " + std::to_string(panel.coefficients_factor.size()) +
                               " systematic errors, expected " + std::to_string(6 * rank));
    factor.middleRows<6>(6 * p) = Eigen::Map<const Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>>(
        panel.coefficients_factor.data(), 6, rank);
  }
  return all + factor * factor.transpose();
}

double nees_of(const Eigen::VectorXd& errors, const Eigen::MatrixXd& covariance) {
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  return factor.info() == Eigen::Success ? errors.dot(factor.solve(errors)) : std::numeric_limits<double>::quiet_NaN();
}

SurfaceErrorsOf summary_of(const std::string& quantity, const std::vector<SurfaceError>& errors) {
  SurfaceErrorsOf of;
  of.quantity = quantity;
  double count = 0, squares = 0, stated = 0;
  for (const SurfaceError& one : errors) {
    if (one.quantity != quantity) continue;
    const double error = one.found - one.truth;
    ++count, squares += error * error, stated += one.sigma * one.sigma, of.bias += error;
    of.largest = std::max(of.largest, std::abs(error)), of.nees += error * error / (one.sigma * one.sigma);
  }
  of.rms = std::sqrt(squares / count), of.predicted = std::sqrt(stated / count), of.bias /= count;
  of.nees /= count, of.freedom = count;
  return of;
}

void of_panels(const std::vector<MeasuredPanel>& panels, int rank, SurfaceErrors& result) {
  if (panels.empty()) return;
  const Eigen::MatrixXd covariance = covariance_of(panels, rank);
  for (const char* name : {"offset", "tilt", "bow", "twist"}) {
    std::vector<Eigen::VectorXd> rows;
    for (size_t p = 0; p < panels.size(); ++p)
      for (const PanelQuantity& quantity : quantities(*panels[p].figures->face)) {
        if (std::string(quantity.name) != name) continue;
        rows.emplace_back(Eigen::VectorXd::Zero(covariance.rows()));
        rows.back().segment<6>(6 * static_cast<Eigen::Index>(p)) = quantity.by_coefficients;
        const double error = quantity.by_coefficients.dot(panels[p].error);
        const Eigen::Map<const Vector6> found(panels[p].figures->coefficients.data());
        const double value = quantity.by_coefficients.dot(found);
        result.all.push_back({panels[p].figures->face->id, name, value, value - error,
                              std::sqrt(rows.back().dot(covariance * rows.back()))});
      }
    Eigen::MatrixXd by(static_cast<Eigen::Index>(rows.size()), covariance.rows());
    Eigen::VectorXd errors(by.rows());
    for (Eigen::Index i = 0; i < by.rows(); ++i) {
      by.row(i) = rows[i];
      const SurfaceError& one = result.all[result.all.size() - rows.size() + static_cast<size_t>(i)];
      errors(i) = one.found - one.truth;
    }
    result.of.push_back(summary_of(name, result.all));
    result.of.back().nees = nees_of(errors, by * covariance * by.transpose());
  }
}

/// Of places in order along a joint, between the two nearest; nan beyond them.
double between(const std::vector<std::unique_ptr<JointPlaceT>>& places, double along, double JointPlaceT::*value) {
  for (size_t i = 1; i < places.size(); ++i) {
    const JointPlaceT &a = *places[i - 1], &b = *places[i];
    if (along < a.along || along > b.along) continue;
    const double share = (along - a.along) / (b.along - a.along);
    return (1 - share) * a.*value + share * b.*value;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

/// An error at a place of a joint.
struct PlaceError {
  const JointFiguresT* joint;
  const JointPlaceT* place;
  double error;
};

/// What the places of all joints are off by.
struct JointErrors {
  std::vector<PlaceError> width, beside, step;
};

/// `across`: from the joint's first panel to its second; nan: nobody knows.
void of_joint(const JointFiguresT& measured, const JointFiguresT& truth, const Eigen::Vector3d& across, bool beside,
              JointErrors& joints, std::vector<SurfaceError>& errors) {
  const double shift = across.dot(truth.origin - measured.origin);
  for (const auto& place : measured.places) {
    // Both may count along the joint from different middles, and in opposite directions.
    const double along = truth.along.dot(measured.origin + place->along * measured.along - truth.origin);
    const std::string where = fmt::format("{} | {} at {:+.2f} m", measured.first, measured.second, place->along);
    const double width = between(truth.places, along, &JointPlaceT::width),
                 step = between(truth.places, along, &JointPlaceT::step);
    if (std::isfinite(width)) {
      (beside ? joints.beside : joints.width).push_back({&measured, place.get(), place->width - width});
      errors.push_back({where, beside ? "width_beside_unmeasured" : "width", place->width, width, place->width_sigma});
    }
    if (!beside && std::isfinite(width + shift + place->shift))
      errors.push_back({where, "shift", place->shift, shift, place->shift_sigma});
    if (beside || !std::isfinite(step) || !std::isfinite(place->step)) continue;
    joints.step.push_back({&measured, place.get(), place->step - step});
    errors.push_back({where, "step", place->step, step, place->step_sigma});
  }
}

/// e' C⁻¹ e with C = D + U U', by the lemma of Woodbury: D differs from place to place, U is what all joints have in
/// common and what the places of one joint have. nan where nobody said so.
double nees_of_widths(const std::vector<PlaceError>& errors, int rank) {
  std::map<const JointFiguresT*, Eigen::Index> column;
  for (const PlaceError& one : errors)
    column.try_emplace(one.joint, rank + 2 * static_cast<Eigen::Index>(column.size()));
  const auto n = static_cast<Eigen::Index>(errors.size()), k = rank + 2 * static_cast<Eigen::Index>(column.size());
  Eigen::MatrixXd common = Eigen::MatrixXd::Zero(n, k);  // over the random part
  Eigen::VectorXd own(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const JointPlaceT& place = *errors[i].place;
    if (!(place.width_random > 0) || static_cast<int>(place.width_factor.size()) != rank)
      return std::numeric_limits<double>::quiet_NaN();
    for (int c = 0; c < rank; ++c) common(i, c) = place.width_factor[c] / place.width_random;
    for (size_t e = 0; e < place.width_by_edge.size() && e < 2; ++e)
      common(i, column.at(errors[i].joint) + static_cast<Eigen::Index>(e)) =
          place.width_by_edge[e] / place.width_random;
    own(i) = errors[i].error / place.width_random;
  }
  const Eigen::VectorXd right = common.transpose() * own;
  const Eigen::MatrixXd inner = Eigen::MatrixXd::Identity(k, k) + common.transpose() * common;
  return own.squaredNorm() - right.dot(inner.llt().solve(right));
}

/// c0 … c5 of a panel's height at a place of its border.
Vector6 base_at(const SurfaceFaceT& face, const Eigen::Vector3d& place) {
  const double x = std::clamp(2 * face.right.dot(place - face.origin) / face.width, -1.0, 1.0),
               y = std::clamp(2 * face.up.dot(place - face.origin) / face.height, -1.0, 1.0);
  return (Vector6() << 1, x, y, 1 - x * x, 1 - y * y, x * y).finished();
}

/// Along a joint a step is of second degree: its first, middle and last place hold all of it.
std::vector<PlaceError> three_of_each(const std::vector<PlaceError>& errors) {
  std::vector<PlaceError> kept;
  for (size_t from = 0, to; from < errors.size(); from = to) {
    for (to = from; to < errors.size() && errors[to].joint == errors[from].joint;) ++to;
    const size_t middle = from + (to - from) / 2;
    for (size_t i = from; i < to; ++i)
      if (i == from || i == middle || i + 1 == to) kept.push_back(errors[i]);
  }
  return kept;
}

void count_steps(const std::vector<PlaceError>& all, const std::vector<MeasuredPanel>& panels, int rank,
                 SurfaceErrorsOf& of) {
  std::map<std::string, Eigen::Index> number;
  for (size_t p = 0; p < panels.size(); ++p) number[panels[p].figures->face->id] = static_cast<Eigen::Index>(p);
  std::vector<PlaceError> errors = three_of_each(all);
  std::erase_if(errors, [&](const PlaceError& one) {
    return !number.contains(one.joint->first) || !number.contains(one.joint->second);
  });
  const Eigen::MatrixXd covariance = covariance_of(panels, rank);
  Eigen::MatrixXd by = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(errors.size()), covariance.rows());
  Eigen::VectorXd off(by.rows()), own(by.rows());
  for (Eigen::Index i = 0; i < by.rows(); ++i) {
    const PlaceError& one = errors[i];
    const Eigen::Vector3d at = one.joint->origin + one.place->along * one.joint->along;
    for (const auto& [name, sign] : {std::pair{one.joint->first, -1.0}, {one.joint->second, 1.0}}) {
      const Eigen::Index p = number.at(name);
      by.row(i).segment<6>(6 * p) += sign * base_at(*panels[p].figures->face, at).transpose();
    }
    off(i) = one.error;
    // What a step states beyond that is what its panels' edges are off their fitted surfaces: each place's own.
    own(i) = std::max(0.0, std::pow(one.place->step_sigma, 2) - by.row(i).dot(covariance * by.row(i).transpose()));
  }
  if (off.size() == 0) return void(of.nees = of.freedom = 0);
  // Steps around a corner of four panels add up to nothing: such directions have no error, and none is tested.
  Eigen::MatrixXd of_steps = by * covariance * by.transpose();
  of_steps.diagonal() += own;
  const linear_algebra::SymmetricEigen spectrum(of_steps);
  constexpr double kLeast = 2e-6;  // [m]
  of.nees = of.freedom = 0;
  for (Eigen::Index i = 0; i < off.size(); ++i) {
    const double variance = spectrum.eigenvalues()(i);
    if (variance < std::max(kLeast * kLeast, 1e-6 * spectrum.eigenvalues()(off.size() - 1))) continue;
    of.nees += std::pow(spectrum.eigenvectors().col(i).dot(off), 2) / variance, ++of.freedom;
  }
}

void of_joints(const JointErrors& errors, const std::vector<MeasuredPanel>& panels, const SurfacesT& measured,
               SurfaceErrors& result) {
  for (const auto& [name, places, joints] : {std::tuple{"width", &errors.width, result.joints_measured},
                                             {"width_beside_unmeasured", &errors.beside, result.joints_beside}}) {
    if (places->empty()) continue;
    SurfaceErrorsOf of = summary_of(name, result.all);
    const double nees = nees_of_widths(*places, measured.joint_rank);
    of.one_by_one = !std::isfinite(nees);
    if (of.one_by_one)
      of.nees *= joints, of.freedom = joints;
    else
      of.nees = nees;
    result.of.push_back(of);
  }
  const auto is_shift = [](const SurfaceError& one) { return one.quantity == "shift"; };
  if (std::any_of(result.all.begin(), result.all.end(), is_shift)) {
    result.of.push_back(summary_of("shift", result.all));
    result.of.back().freedom = 1;  // what the whole measurement's place is off by is most of it, and all share that
  }
  if (errors.step.empty()) return;
  result.of.push_back(summary_of("step", result.all));
  count_steps(errors.step, panels, measured.rank, result.of.back());
}

void refuse_equal_names(const SurfacesT& surfaces, const char* which) {
  std::map<std::string, int> count;
  for (const auto& panel : surfaces.panels)
    if (++count[panel->face->id] == 2)
      throw std::runtime_error("two panels of " + std::string(which) + " are called '" + panel->face->id +
                               "': which of them is which nobody can tell; evaluate one facade at a time");
}

}  // namespace

Eigen::Matrix<double, 6, 1> coefficients_on(const SurfaceFaceT& face, const PanelSurfaceFiguresT& truth) {
  const SurfaceFaceT& own = *truth.face;
  if ((face.right - own.right).norm() > 1e-6 || (face.out - own.out).norm() > 1e-6)
    throw std::runtime_error("panel " + face.id + " and its truth have faces that are turned against each other");
  if (truth.coefficients.size() != 6) throw std::runtime_error("the truth of panel " + face.id + " has no form");
  const Eigen::Vector3d moved = face.origin - own.origin;
  const double r = face.width / own.width, q = face.height / own.height;
  const double s = 2 * own.right.dot(moved) / own.width, t = 2 * own.up.dot(moved) / own.height;
  const std::vector<double>& c = truth.coefficients;
  // x of the truth is r x + s, y is q y + t.
  Vector6 on;
  on << c[0] + c[1] * s + c[2] * t + c[3] * (1 - r * r - s * s) + c[4] * (1 - q * q - t * t) + c[5] * s * t -
            own.out.dot(moved),
      c[1] * r - 2 * c[3] * r * s + c[5] * r * t, c[2] * q - 2 * c[4] * q * t + c[5] * s * q, c[3] * r * r,
      c[4] * q * q, c[5] * r * q;
  return on;
}

SurfaceErrors surface_errors(const SurfacesT& measured, const SurfacesT& truth) {
  SurfaceErrors result;
  refuse_equal_names(measured, "the measured surfaces"), refuse_equal_names(truth, "the truth");
  std::map<std::string, const PanelSurfaceFiguresT*> panels;
  for (const auto& panel : measured.panels) panels[panel->face->id] = panel.get();
  std::vector<MeasuredPanel> compared;
  std::map<std::string, bool> can_be;
  for (const auto& panel : truth.panels) {
    const bool wanted = can_be[panel->face->id] = panel->not_measured.empty();
    const auto found = panels.find(panel->face->id);
    const bool has = found != panels.end() && found->second->not_measured.empty();
    result.wanted += wanted, result.measured += wanted && has, result.invented += !wanted && has;
    if (!wanted || !has) continue;
    const Eigen::Map<const Vector6> form(found->second->coefficients.data());
    compared.push_back({found->second, form - coefficients_on(*found->second->face, *panel)});
    result.coverage += found->second->coverage;
  }
  if (result.wanted == 0) throw std::runtime_error("input 'truth' has no panel that can be measured");
  result.coverage /= result.wanted;
  of_panels(compared, measured.rank, result);
  std::map<std::pair<std::string, std::string>, const JointFiguresT*> joints;
  for (const auto& joint : measured.joints) joints[{joint->first, joint->second}] = joint.get();
  JointErrors errors;
  for (const auto& joint : truth.joints) {
    const bool beside = !can_be[joint->first] || !can_be[joint->second];
    const auto found = joints.find({joint->first, joint->second});
    const bool has = found != joints.end() && !found->second->places.empty();
    if (beside)
      result.joints_beside += has;
    else
      ++result.joints_wanted, result.joints_measured += has;
    const auto first = panels.find(joint->first);
    if (!has) continue;
    Eigen::Vector3d across = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    if (first != panels.end()) across = joint->upright ? first->second->face->right : first->second->face->up;
    of_joint(*found->second, *joint, across, beside, errors, result.all);
  }
  of_joints(errors, compared, measured, result);
  for (const SurfaceError& one : result.all) result.beyond_3_sigma += std::abs(one.found - one.truth) > 3 * one.sigma;
  if (!result.all.empty()) result.beyond_3_sigma /= static_cast<double>(result.all.size());
  return result;
}

}  // namespace plumbline::judgement

#include "building/judgement/surface_errors.hpp"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

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

void of_joint(const JointFiguresT& measured, const JointFiguresT& truth, std::vector<SurfaceError>& errors) {
  for (const auto& place : measured.places) {
    // Both may count along the joint from different middles, and in opposite directions.
    const double along = truth.along.dot(measured.origin + place->along * measured.along - truth.origin);
    const std::string where = fmt::format("{} | {} at {:+.2f} m", measured.first, measured.second, place->along);
    const double width = between(truth.places, along, &JointPlaceT::width),
                 step = between(truth.places, along, &JointPlaceT::step);
    if (std::isfinite(width)) errors.push_back({where, "width", place->width, width, place->width_sigma});
    if (std::isfinite(step) && std::isfinite(place->step))
      errors.push_back({where, "step", place->step, step, place->step_sigma});
  }
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
  for (const auto& joint : truth.joints) {
    if (!can_be[joint->first] || !can_be[joint->second]) continue;
    const auto found = joints.find({joint->first, joint->second});
    const bool has = found != joints.end() && !found->second->places.empty();
    ++result.joints_wanted, result.joints_measured += has;
    if (has) of_joint(*found->second, *joint, result.all);
  }
  for (const char* name : {"width", "step"}) {
    if (std::none_of(result.all.begin(), result.all.end(), [&](const auto& one) { return one.quantity == name; }))
      continue;
    result.of.push_back(summary_of(name, result.all));
    result.of.back().nees *= result.joints_measured, result.of.back().freedom = result.joints_measured;
  }
  for (const SurfaceError& one : result.all) result.beyond_3_sigma += std::abs(one.found - one.truth) > 3 * one.sigma;
  if (!result.all.empty()) result.beyond_3_sigma /= static_cast<double>(result.all.size());
  return result;
}

}  // namespace plumbline::judgement

// Which way the facade of a design looks.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "ifc/design.hpp"

namespace plumbline::bim {

std::optional<Eigen::Vector3d> estimate_facade_normal(const Design& design) {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero(), rest = Eigen::Vector2d::Zero();
  double anchors = 0, others = 0;
  // The building is where its shapes are; placements may stand anywhere, and panels hang before the anchors.
  const auto shows_building = [](const Element& element) {
    return !element.is_anchor && !element.is_panel && element.has_box;
  };
  const bool shown = std::any_of(design.elements.begin(), design.elements.end(), shows_building);
  for (const Element& element : design.elements) {
    if (element.is_anchor)
      centre += element.position.head<2>(), ++anchors;
    else if (!shown || shows_building(element))
      rest += element.position.head<2>(), ++others;
  }
  if (anchors < 2) return {};
  centre /= anchors;
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Element& element : design.elements) {
    if (!element.is_anchor) continue;
    const Eigen::Vector2d d = element.position.head<2>() - centre;
    scatter += d * d.transpose() / anchors;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(scatter);
  const double across = std::sqrt(std::max(0.0, eigen.eigenvalues()(0))), along = std::sqrt(eigen.eigenvalues()(1));
  // 0.1 m: anchors of one column scatter by their tolerance only, which is no facade line.
  if (along < 0.1 || across > 0.05 * along) return {};
  Eigen::Vector2d normal = eigen.eigenvectors().col(0);
  const double outward = others > 0 ? normal.dot(centre - rest / others) : 0;
  // Without a building behind the anchors: towards the negative y axis, or the positive x axis if it is square to that.
  const bool undecided = std::abs(outward) < 0.01;
  const double sense = !undecided ? outward : std::abs(normal.y()) > 1e-6 ? -normal.y() : normal.x();
  if (sense < 0) normal = -normal;
  return Eigen::Vector3d(normal.x(), normal.y(), 0);
}

}  // namespace plumbline::bim

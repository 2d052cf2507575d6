#include "building/ifc/enlarged_surfaces.hpp"

#include <cmath>
#include <vector>

namespace plumbline::ifc {
namespace {

void scale(std::vector<double>& values, double by) {
  for (double& value : values) value *= by;
}

}  // namespace

void enlarge(SurfacesT& surfaces, double factor) {
  const double root = std::sqrt(factor);
  for (auto& panel : surfaces.panels) {
    scale(panel->covariance, factor), scale(panel->random_covariance, factor);
    scale(panel->coefficients_random, factor), scale(panel->coefficients_factor, root);
    panel->form_sigma *= root;
    for (auto& gap : panel->flatness) gap->sigma *= root, gap->noise_mean *= root, gap->noise_sigma *= root;
  }
  for (auto& joint : surfaces.joints)
    for (auto& place : joint->places) {
      place->width_sigma *= root, place->width_random *= root, place->step_sigma *= root, place->shift_sigma *= root;
      scale(place->width_by_edge, root), scale(place->width_factor, root);
    }
}

}  // namespace plumbline::ifc

#include "planted_surfaces.hpp"

#include <cmath>

namespace plumbline::simulate {
namespace {

constexpr double kThickness = 0.05;      // of a panel [m]
constexpr double kBetweenPlaces = 0.01;  // along a joint [m]

std::unique_ptr<PanelSurfaceFiguresT> figures_of(const PanelledFacade& facade, const RaisedPanel& panel) {
  auto figures = std::make_unique<PanelSurfaceFiguresT>();
  figures->face = std::make_unique<SurfaceFaceT>();
  const Eigen::Matrix3d axes = facade.world_from_facade.rotation.toRotationMatrix();
  figures->face->id = panel.id;
  figures->face->origin = facade.world_from_facade * Eigen::Vector3d(panel.u, panel.v, 0);
  figures->face->right = axes.col(0), figures->face->up = axes.col(1), figures->face->out = axes.col(2);
  figures->face->width = panel.width, figures->face->height = panel.height, figures->face->thickness = kThickness;
  if (panel.skin != Skin::plaster) figures->not_measured = to_string(panel.skin);
  figures->coverage = 1;
  figures->offset = panel.offset, figures->tilt = {panel.tilt_u, panel.tilt_v};
  figures->form = {panel.bow_u, panel.bow_v, 0}, figures->form_sigma = Eigen::Vector3d::Zero();
  figures->coefficients = {panel.offset - 2.0 / 3 * (panel.bow_u + panel.bow_v),
                           0.5 * panel.width * panel.tilt_u,
                           0.5 * panel.height * panel.tilt_v,
                           panel.bow_u,
                           panel.bow_v,
                           0};
  return figures;
}

/// `a` lies at the left or below.
std::unique_ptr<JointFiguresT> joint_between(const PanelledFacade& facade, const RaisedPanel& a, const RaisedPanel& b,
                                             bool upright, double nominal) {
  auto joint = std::make_unique<JointFiguresT>();
  joint->first = a.id, joint->second = b.id, joint->upright = upright, joint->nominal_width = nominal;
  const double edge_a = upright ? a.u + 0.5 * a.width : a.v + 0.5 * a.height;
  const double edge_b = upright ? b.u - 0.5 * b.width : b.v - 0.5 * b.height;
  const double across = 0.5 * (edge_a + edge_b), along = 0.5 * (upright ? a.v + b.v : a.u + b.u);
  joint->length = upright ? a.height : a.width;
  joint->origin =
      facade.world_from_facade * (upright ? Eigen::Vector3d(across, along, 0) : Eigen::Vector3d(along, across, 0));
  joint->along = facade.world_from_facade.rotation * (upright ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX());
  const int half = static_cast<int>(std::ceil(0.5 * joint->length / kBetweenPlaces));
  for (int i = -half; i <= half; ++i) {
    auto place = std::make_unique<JointPlaceT>();
    place->along = i * kBetweenPlaces, place->width = edge_b - edge_a, place->width_sigma = place->step_sigma = 0;
    const double at = along + place->along;
    place->step = upright ? b.at(edge_b, at) - a.at(edge_a, at) : b.at(at, edge_b) - a.at(at, edge_a);
    joint->places.push_back(std::move(place));
  }
  joint->looked_at = static_cast<int>(joint->places.size());
  return joint;
}

}  // namespace

void add_planted_surfaces(const PanelledFacade& facade, std::int64_t columns, double nominal_joint,
                          SurfacesT& planted) {
  const auto count = static_cast<std::int64_t>(facade.panels.size()),
             before = static_cast<std::int64_t>(planted.panels.size());
  for (const RaisedPanel& panel : facade.panels) planted.panels.push_back(figures_of(facade, panel));
  const auto join = [&](std::int64_t first, std::int64_t second, bool upright) {
    planted.joints.push_back(
        joint_between(facade, facade.panels[first], facade.panels[second], upright, nominal_joint));
    planted.joints.back()->first_panel = static_cast<int>(before + first);
    planted.joints.back()->second_panel = static_cast<int>(before + second);
  };
  for (std::int64_t i = 0; i < count; ++i) {
    if ((i + 1) % columns != 0 && i + 1 < count) join(i, i + 1, true);
    if (i + columns < count) join(i, i + columns, false);
  }
}

}  // namespace plumbline::simulate

#include "faces.hpp"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

#include "building/judgement/outer_side.hpp"

namespace plumbline::surface {
namespace {

/// The panel's own direction out, if the design knows one; nan without.
Eigen::Vector3d own_out(const DesignElementT& element) {
  if (!element.facade || !(element.facade->out.norm() > 0.5)) return Eigen::Vector3d::Constant(std::nan(""));
  return element.facade->out.normalized();
}

/// On which side of `face` (a unit vector across the panel) the outside is: 1 or -1; 0: nobody knows, `why` says it.
/// Photographs of one facade look at the panels of another from behind, through the building, so they are asked only
/// where the design does not know for sure, and believed only if none contradicts.
/// `guessed`: nothing but an unconfirmed direction, or the one of the whole design, says so.
int side_of(const DesignElementT& element, const DesignT& design, const Eigen::Vector3d& middle,
            const Eigen::Vector3d& face, const std::vector<Eigen::Vector3d>& seen_from, bool& guessed,
            std::string& why) {
  const Eigen::Vector3d own = own_out(element);
  const bool known = own.allFinite() && std::abs(own.dot(face)) > 0.1;
  if (known && element.facade->confirmed) return own.dot(face) > 0 ? 1 : -1;
  const Lookers lookers = looked_at(middle, face, seen_from);
  const int nearer = lookers.before >= lookers.behind ? 1 : -1;
  if (lookers.before + lookers.behind > 0 && std::min(lookers.before, lookers.behind) == 0) return nearer;
  guessed = lookers.before + lookers.behind == 0;
  if (known && (lookers.before + lookers.behind == 0 || nearer * own.dot(face) > 0)) return own.dot(face) > 0 ? 1 : -1;
  if (lookers.before + lookers.behind > 0) {
    why = std::to_string(std::max(lookers.before, lookers.behind)) + " places look at it from one side, " +
          std::to_string(std::min(lookers.before, lookers.behind)) +
          " from the other, and the design does not say for sure which is outside; a rule for its facade does";
    return 0;
  }
  if (design.facade_normal.allFinite() && std::abs(design.facade_normal.dot(face)) > 0.1)
    return design.facade_normal.dot(face) > 0 ? 1 : -1;
  why = "nothing looks at it and the design does not say which side is outside";
  return 0;
}

/// Of the box's three directions the one across the panel: the thinnest, but of a panel that is known to face another
/// way (a fin, a deep frame) the one that faces there.
int across_panel(const DesignElementT& element, const Eigen::Matrix3d& turn, const Eigen::Vector3d& size) {
  int thin = 0;
  size.minCoeff(&thin);
  const Eigen::Vector3d own = own_out(element);
  if (!own.allFinite() || !element.facade->confirmed || std::abs(turn.col(thin).dot(own)) > std::sqrt(0.5)) return thin;
  (turn.transpose() * own).cwiseAbs().maxCoeff(&thin);
  return thin;
}

SurfaceLeftOutT left_out(const std::string& id, const std::string& guid, const std::string& reason) {
  SurfaceLeftOutT panel;
  panel.id = id, panel.guid = guid, panel.reason = reason;
  return panel;
}

/// What the design's own outer side may be off a plane; flatness is judged in more [m].
constexpr double kFlatDesign = 0.001;

/// By how much the design's outer side is no plane; nan: not known.
double sag_of(const DesignElementT& element, int through, int side) {
  if (element.sag.size() != 6) return std::nan("");
  return element.sag[static_cast<size_t>(2 * through + (side > 0 ? 1 : 0))];
}

/// Share of a rectangle from which on a side is taken for one: notches of sheets, no slanting edge.
constexpr double kRectangle = 0.97;

/// How much of its rectangle the design's outer side fills; nan: not known.
double filled_of(const DesignElementT& element, int through, int side) {
  if (element.filled.size() != 6) return std::nan("");
  return element.filled[static_cast<size_t>(2 * through + (side > 0 ? 1 : 0))];
}

std::string no_rectangle(double filled) {
  return fmt::format(
      "the design's outer side of it is no rectangle, it fills {:.0f} % of one: the rest is its neighbours' or "
      "nothing, "
      "and its edges and joints lie elsewhere",
      100 * filled);
}

std::string no_plane(double sag) {
  return fmt::format(
      "the design's outer side of it is no plane: its parts lie {:.1f} mm apart across it, and flatness, bow and place "
      "would be those of the design",
      1e3 * sag);
}

/// What each panel is called, by its number among the elements: its name, and where panels share one (families of
/// Revit and Tekla) what tells them apart, their tags, or where those do not their GlobalIds.
std::vector<std::string> names_of_panels(const DesignT& design, const std::set<std::string>& wholes) {
  std::map<std::string, std::vector<size_t>> by_name;
  std::vector<std::string> names(design.elements.size());
  for (size_t e = 0; e < names.size(); ++e) {
    const DesignElementT& element = *design.elements[e];
    if (!element.is_panel || wholes.contains(element.guid)) continue;
    names[e] = element.name.empty() ? element.guid : element.name;
    by_name[names[e]].push_back(e);
  }
  for (const auto& [name, panels] : by_name) {
    if (panels.size() < 2) continue;
    std::set<std::string> tags;
    for (const size_t e : panels) tags.insert(design.elements[e]->tag);
    const bool by_tag = tags.size() == panels.size() && !tags.contains("");
    for (const size_t e : panels)
      names[e] += " [" + (by_tag ? design.elements[e]->tag : design.elements[e]->guid) + "]";
  }
  return names;
}

}  // namespace

std::set<std::string> wholes_of_panels(const DesignT& design) {
  std::set<std::string> wholes;
  for (const auto& element : design.elements)
    if (element->is_panel && !element->parent_guid.empty()) wholes.insert(element->parent_guid);
  return wholes;
}

std::vector<std::unique_ptr<SurfaceLeftOutT>> copies_of(const std::vector<SurfaceLeftOutT>& panels) {
  std::vector<std::unique_ptr<SurfaceLeftOutT>> copies;
  for (const SurfaceLeftOutT& panel : panels) copies.push_back(std::make_unique<SurfaceLeftOutT>(panel));
  return copies;
}

std::vector<Eigen::Vector3d> stations_of(const std::vector<double>& values) {
  if (values.size() % 3 != 0)
    throw std::runtime_error("'seen_from' has " + std::to_string(values.size()) +
                             " values, expected x, y and z of each station");
  std::vector<Eigen::Vector3d> stations;
  for (size_t i = 0; i < values.size(); i += 3) stations.emplace_back(values[i], values[i + 1], values[i + 2]);
  return stations;
}

Lookers looked_at(const Eigen::Vector3d& origin, const Eigen::Vector3d& out,
                  const std::vector<Eigen::Vector3d>& seen_from) {
  Lookers count;
  for (const Eigen::Vector3d& place : seen_from) {
    const double cosine = (place - origin).normalized().dot(out);
    if (std::abs(cosine) > 0.26) ++(cosine > 0 ? count.before : count.behind);
  }
  return count;
}

Faces faces_of(const DesignT& design, const std::vector<Eigen::Vector3d>& seen_from) {
  Faces result;
  const std::set<std::string> wholes = wholes_of_panels(design);
  const std::vector<std::string> names = names_of_panels(design, wholes);
  for (size_t e = 0; e < names.size(); ++e) {
    const auto& element = design.elements[e];
    if (!element->is_panel || wholes.contains(element->guid)) continue;
    const std::string& name = names[e];
    const Eigen::Vector3d size = element->box_high - element->box_low;
    if (!size.allFinite() || !(size.minCoeff() >= 0)) {
      result.left_out.push_back(
          left_out(name, element->guid, "the design gives no shape that a face could be taken from"));
      continue;
    }
    const Eigen::Matrix3d turn = element->placement.rotation.toRotationMatrix();
    const int through = across_panel(*element, turn, size);
    const Eigen::Vector3d middle = element->placement * Eigen::Vector3d(0.5 * (element->box_low + element->box_high));
    std::string why;
    bool guessed = false;
    const int side = side_of(*element, design, middle, turn.col(through), seen_from, guessed, why);
    if (side == 0) {
      result.left_out.push_back(left_out(name, element->guid, why));
      continue;
    }
    if (const double sag = sag_of(*element, through, side); sag > kFlatDesign) {
      result.left_out.push_back(left_out(name, element->guid, no_plane(sag)));
      continue;
    }
    if (const double filled = filled_of(*element, through, side); filled < kRectangle) {
      result.left_out.push_back(left_out(name, element->guid, no_rectangle(filled)));
      continue;
    }
    if (guessed) result.guessed.push_back(name);
    const Eigen::Vector3d out = side * turn.col(through);
    PanelFace face;
    face.id = name;
    const Eigen::AlignedBox3d outer = judgement::outer_side(*element, through, side);
    face.plane = facade_plane(element->placement * outer.center() + 0.5 * size(through) * out, out);
    // Up as the design has it: on a soffit or a leaning facade it is not the vertical.
    const bool own_up =
        element->facade && element->facade->up.norm() > 0.5 && std::abs(element->facade->up.dot(out)) < 0.7;
    const Eigen::Vector3d upward = own_up ? element->facade->up : face.plane.axes.col(1);
    // The box's own edges are the face's, whatever is up: a panel may stand askew.
    const int wide = (through + 1) % 3, high = (through + 2) % 3;
    const bool swapped = std::abs(turn.col(wide).dot(upward)) > std::abs(turn.col(high).dot(upward));
    const int across = swapped ? high : wide, upwards = swapped ? wide : high;
    Eigen::Vector3d up = turn.col(upwards);
    if (up.dot(upward) < 0) up = -up;
    face.plane.axes << up.cross(out), up, out;
    face.width = outer.sizes()(across), face.height = outer.sizes()(upwards), face.thickness = size(through);
    result.faces.push_back(face);
    result.guids.push_back(element->guid);
  }
  return result;
}

void leave_out_seen_from_behind(Faces& faces, const std::vector<Eigen::Vector3d>& seen_from) {
  Faces kept;
  kept.left_out = std::move(faces.left_out), kept.guessed = std::move(faces.guessed);
  for (size_t f = 0; f < faces.faces.size(); ++f) {
    const Lookers lookers = looked_at(faces.faces[f].plane.origin, faces.faces[f].plane.axes.col(2), seen_from);
    if (lookers.before == 0 && lookers.behind > 0) {
      kept.left_out.push_back(
          left_out(faces.faces[f].id, faces.guids[f],
                   "all " + std::to_string(lookers.behind) +
                       " stations of 'seen_from' that look at it see it from behind: not its outer face"));
      continue;
    }
    kept.faces.push_back(std::move(faces.faces[f])), kept.guids.push_back(std::move(faces.guids[f]));
  }
  faces = std::move(kept);
}

Faces face_through(const PointsT& points, const std::vector<Eigen::Vector3d>& seen_from, double margin) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> places;
  for (const auto& point : points.points)
    if (point->position.allFinite()) places.push_back(point->position), mean += point->position;
  if (places.size() < 3)
    throw std::runtime_error("a plane needs three points with coordinates, 'points' has " +
                             std::to_string(places.size()));
  mean /= static_cast<double>(places.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& place : places) scatter += (place - mean) * (place - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(scatter);
  if (!(axes.eigenvalues()(1) > 1e-4 * axes.eigenvalues()(2)))
    throw std::runtime_error("the " + std::to_string(places.size()) +
                             " points of 'points' lie on a line; connect 'design', or more points");
  Eigen::Vector3d out = axes.eigenvectors().col(0);
  const Lookers lookers = looked_at(mean, out, seen_from);
  if (lookers.before == lookers.behind)
    throw std::runtime_error(std::to_string(lookers.before) +
                             " places look at the plane of 'points' from one side and " +
                             std::to_string(lookers.behind) +
                             " from the other: nobody knows which side is outside, and every sign hangs on it; set "
                             "'seen_from' to the scanner's stations, or take photographs of one side");
  if (lookers.behind > lookers.before) out = -out;
  PanelFace face;
  face.id = "plane of the points";
  face.plane = facade_plane(mean, out);
  Eigen::Vector2d low(1e300, 1e300), high = -low;
  for (const Eigen::Vector3d& place : places) {
    const Eigen::Vector2d at = face.plane.local(place).head<2>();
    low = low.cwiseMin(at), high = high.cwiseMax(at);
  }
  const Eigen::Vector2d middle = 0.5 * (low + high);
  face.plane.origin = face.plane.world({middle.x(), middle.y(), 0});
  face.width = high.x() - low.x() + 2 * margin, face.height = high.y() - low.y() + 2 * margin;
  return {{face}, {""}, {}, {}};
}

}  // namespace plumbline::surface

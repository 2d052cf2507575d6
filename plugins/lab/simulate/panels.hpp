// Panels of the design as they hang before the simulated building, with relief and texture: what photographs of
// surfaces are tried on.
//
// A site measures brackets before it hangs panels. Here the plates are drawn over the panels, as if each had a hole
// before its plate, so that one set of photographs has both: orientations from the tags, and surfaces.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "building.hpp"

namespace plumbline::simulate {

/// Where the design has panels: between the columns of anchors, a storey high, before the facade [m].
struct PanelGrid {
  static constexpr double joint = 0.01;   ///< between neighbours
  static constexpr double middle = -0.2;  ///< y of their middle plane
  static constexpr double thickness = 0.05;
  static constexpr double face = middle - 0.5 * thickness;  ///< y of their outer side
};
/// "F01-P02"
std::string panel_name(int floor, int column);

/// One panel: h = offset + tilt_right X + tilt_up Z + bow_across (1 − X²) + bow_up (1 − Z²) out of the design's face,
/// with X and Z from −1 to 1 over it [m].
struct HungPanel {
  std::string name;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero(), half = Eigen::Vector2d::Zero();  ///< in x and z [m]
  double offset = 0, tilt_right = 0, tilt_up = 0, bow_across = 0, bow_up = 0;        ///< [m]
  std::uint64_t seed = 0;                                                            ///< of its texture
  /// At a place from its middle [m].
  double height(const Eigen::Vector2d& from_middle) const;
};

/// Those of a building with one facade; each form is normal with `sigma` [m], tilts and bows half as large. Equal input
/// gives equal panels.
std::vector<HungPanel> hang_panels(const Building& building, double sigma, std::uint64_t seed);

/// Paints panels over a row of the wall. x and z: where rays meet the plane y = `wall` [m], `centre`: where they come
/// from, `pixel`: what a pixel covers there [m], `contrast`: of the texture, 1 a stone's. Joints are dark.
void paint_panels(const std::vector<HungPanel>& panels, const Eigen::Vector3d& centre, double wall, double pixel,
                  double contrast, const std::vector<float>& x, const std::vector<float>& z,
                  std::vector<float>& reflectance);

/// truth/panels.csv: plane and form of each as panels.csv of surface.panels has them.
std::string panels_truth(const std::vector<HungPanel>& panels);

}  // namespace plumbline::simulate

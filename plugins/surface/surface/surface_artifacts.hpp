// Structs of libraries/surface/dense to artifacts and back.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "artifacts/surface_points.hpp"
#include "artifacts/surfaces.hpp"
#include "surface/dense/common_place.hpp"
#include "surface/dense/joint_pairs.hpp"
#include "surface/dense/panel_surface.hpp"

namespace plumbline::surface {

std::unique_ptr<SurfaceFaceT> describe(const PanelFace& face, const std::string& guid);
PanelFace face_of(const SurfaceFaceT& face);

/// Writes the tile's points to the end of the file at `path`. Throws std::runtime_error if the disk refuses.
void append_points(const MeasuredTile& tile, const std::string& path);

/// The tile with its points read from `path`. Throws std::runtime_error for a file of another size, and for a factor of
/// another rank.
MeasuredTile read_tile(const SurfaceTileT& tile, int rank, const std::string& path);

std::vector<double> row_by_row(const Eigen::Ref<const Eigen::MatrixXd>& matrix);

std::unique_ptr<PanelSurfaceFiguresT> describe(const PanelSurface& panel, const PanelFace& face,
                                               const std::string& guid, int rank);
/// What joints need of a panel: its form with both parts of the covariance.
PanelSurface panel_of(const PanelSurfaceFiguresT& figures, int rank);

std::unique_ptr<JointFiguresT> describe(const MeasuredJoint& measured, const Joint& joint);
/// What stands out of it, and nan for what does not.
std::unique_ptr<BesidePlaceT> describe(const CommonPlace& place);
/// Joints that nobody measures (pairs_without_joint()): a rule for joints is not judged there, and that is said.
void add_pairs_without_joint(const std::vector<PanelFace>& faces, double widest, SurfacesT& surfaces);

/// Gives the widths of all joints what they have in common: one row a place, in the order of joints and places.
void add_common_errors(const Eigen::MatrixXd& factor, SurfacesT& surfaces);

/// A cell of a CSV table, in quotes where it has to be.
std::string csv_text(const std::string& text);

/// Panels and joints as text, one a line, for spreadsheets: millimetres and mm/m, with standard deviations.
std::string panels_table(const SurfacesT& surfaces);
std::string joints_table(const SurfacesT& surfaces);

}  // namespace plumbline::surface

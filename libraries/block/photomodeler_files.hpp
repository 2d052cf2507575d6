// Text exports of PhotoModeler ("export to text file": *-pmexport.txt), and lists of control points beside them.
//
// Layout of an export, blocks separated by an empty line:
//   title / tolerance, iterations, image width and height [px] / default standard deviations / camera c, xp, yp, format
//   width and height, K1, K2, K3, P1, P2 [mm] / its standard deviations;
//   for each photo five lines that begin with its number: file; X, Y, Z [m], κ, φ, ω [°]; their standard deviations;
//   (covariances, or an empty line); camera; its standard deviations;
//   control points: id, X, Y, Z, standard deviations [m];
//   object points: the same, control points among them;
//   marks: photo, point, x, y [px, from the top left corner, y down], standard deviations [px].
// A control list has a point a line, separated by commas or blanks: id, name, X, Y, Z and perhaps three standard
// deviations [m], or id, X, Y, Z …; '#' begins a comment. Points without standard deviations (or with zeros) are held.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "block/point_block.hpp"

namespace plumbline::adjust {

struct ReadBlock {
  PointBlock block;
  int measurements_read = 0;
  std::vector<std::string> left_out;  ///< what the block does not contain, with the reason
};

/// Throws std::runtime_error with file and line for what cannot be read. Marks of unknown points, points with a single
/// ray and no known coordinates, and photos that too few points tie to the others are left out and told of. Call
/// add_control() before drop_unusable(): a known point needs no second ray. `image_size` [px] is for exports whose
/// second line has none; 0 × 0: it must have one.
ReadBlock read_photomodeler_export(const std::filesystem::path& file, const std::array<int, 2>& image_size = {0, 0});

/// Adds the control points of a list, matched by id or by name; those named in `check` are compared with only. Points
/// of the list that no image measures are told of. Throws if none matches, if one occurs twice, or for a line that
/// cannot be read.
void add_control(const std::filesystem::path& file, const std::vector<std::string>& check, ReadBlock& read);

/// Leaves out what cannot be adjusted: see read_photomodeler_export(). Until nothing changes.
void drop_unusable(ReadBlock& read);

/// An AICON folder, a PhotoModeler export or a problem of bal_files.hpp, whichever `folder` holds (also in folders
/// below it). Exports are known by their name or by how they begin. `project` chooses one of several by the beginning
/// of its name or path; `control` is a list of control points, in the folder or a path of its own; empty: none. Throws
/// std::runtime_error that names what was found.
ReadBlock read_image_block(const std::filesystem::path& folder, const std::string& project, const std::string& control,
                           const std::vector<std::string>& check, const std::array<int, 2>& image_size = {0, 0});

}  // namespace plumbline::adjust

// Text exports of PhotoModeler ("export to text file": *-pmexport.txt).
//
// Layout of an export, blocks separated by an empty line:
//   title / tolerance, iterations, image width and height [px] / default standard deviations / camera c, xp, yp, format
//   width and height, K1, K2, K3, P1, P2 [mm] / its standard deviations;
//   for each photo five lines that begin with its number: file; X, Y, Z [m], κ, φ, ω [°]; their standard deviations;
//   (covariances, or an empty line); camera; its standard deviations;
//   control points: id, X, Y, Z, standard deviations [m];
//   object points: the same, control points among them;
//   marks: photo, point, x, y [px, from the top left corner, y down], standard deviations [px].
#pragma once

#include <array>
#include <filesystem>

#include "photo/block/read_block.hpp"

namespace plumbline::block {

/// Throws std::runtime_error with file and line for what cannot be read. Marks of unknown points are left out and told
/// of. `image_size` [px] is for exports whose second line has none; 0 × 0: it must have one.
ReadBlock read_photomodeler_export(const std::filesystem::path& file, const std::array<int, 2>& image_size = {0, 0});

/// Whether a text begins as an export does, whatever it is called: a title, then lines of numbers.
bool looks_like_photomodeler(const std::filesystem::path& file);

}  // namespace plumbline::block

// Bundle adjustment problems as plain text, as the collection "Bundle Adjustment in the Large" has them (Agarwal et
// al., ECCV 2010), and many programs since: the number of cameras, points and observations; one line an observation
// (camera, point, x, y); nine numbers a camera (rotation vector, translation, f, k1, k2); three a point. A camera maps
// X to P = R X + t and p = −(P_x, P_y)/P_z, and measures f (1 + k1 |p|² + k2 |p|⁴) p in pixels from the image's centre,
// x to the right and y up. Nothing says how large a pixel or the image is, nor what the unit of length is.
#pragma once

#include <filesystem>
#include <string>

#include "photo/block/read_block.hpp"

namespace plumbline::block {

/// Of a pixel where nothing says it [mm].
constexpr double bal_pixel_pitch = 0.001;

/// Every camera of the file becomes an image with a camera of its own (balanced model, f, k1 and k2 to be estimated).
/// Sensor coordinates are the file's pixels times `pixel_pitch` [mm]; object coordinates are taken for metres. What
/// lies behind its camera, is measured twice in an image, or is seen too little is left out and told of. Throws
/// std::runtime_error with file and line for what cannot be read.
ReadBlock read_bal_file(const std::filesystem::path& file, double pixel_pitch);

/// Whether a file begins as such a problem does: three whole numbers, then two whole numbers and two coordinates.
bool looks_like_bal(const std::filesystem::path& file);

/// The block as such a problem, numbers with 17 digits. Cameras that the format has (one principal distance, two radial
/// terms) keep them; of others the measurements are reduced to an ideal image, and `notes` says so. Control, scale bars
/// and standard deviations have no place in it. Pixels are the camera's own, or 1 µm where those are unknown. Throws
/// std::runtime_error for a measurement that the lens model cannot have produced.
std::string bal_text(const PointBlock& block, std::vector<std::string>& notes);

}  // namespace plumbline::block

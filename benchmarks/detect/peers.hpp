// The detectors that are compared: each finds tags of one family in a grey image, with one thread.
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "photo/detect/square_code.hpp"
#include "photo/images/grey_image.hpp"

namespace plumbline::benchmark {

struct Found {
  int id = 0;
  std::array<Eigen::Vector2d, 4> corners;  ///< in the detector's own order [px]
  Eigen::Vector2d centre() const { return 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]); }
  double shortest_side() const;
};

struct Peer {
  std::string name;
  std::function<std::vector<Found>(const GreyImage&)> detect;
};

/// libapriltag with its own edge refinement, one corrected bit and detect.apriltag's least decision margin of 25. Takes
/// dictionaries of ArUco markers, too: their cells are put in the order in which it turns codes.
Peer libapriltag_peer(const detect::SquareFamily& family, float decimate);
/// OpenCV's detectMarkers with its default parameters. `name` is that of a builtin dictionary.
Peer opencv_peer(const std::string& name);
/// See nano.cpp.
Peer nano_peer(const detect::SquareFamily& family);
/// detect.tag_pyramid over rows in memory; `edges`: with the fit of the edges and its covariance, which no other has.
Peer pyramid_peer(const detect::SquareFamily& family, double smallest_tag, bool edges);

}  // namespace plumbline::benchmark

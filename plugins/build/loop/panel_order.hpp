// Which panels stand next below another: they hang before it. Geometry alone, without a port.
#pragma once

#include <string>
#include <vector>

#include "loop/fit/facade.hpp"

namespace plumbline::loop {

/// A panel by points around it: corners of its face, or of its box.
struct PanelPlace {
  std::string id;
  std::vector<Eigen::Vector3d> points;
};

/// Of those that end where `panel` begins or lower, over half of the narrower one's width and in its plane, the ones
/// with no other of them between, however far below: a ribbon of windows leaves no joint. In the order of `others`.
std::vector<std::size_t> next_below(const Panel& panel, const std::vector<PanelPlace>& others);

}  // namespace plumbline::loop

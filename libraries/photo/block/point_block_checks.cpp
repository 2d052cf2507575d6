#include "photo/block/point_block_checks.hpp"

#include <fmt/core.h>

#include <stdexcept>

#include "base/text/words.hpp"
#include "least_squares/problem/defects.hpp"

namespace plumbline::block {
namespace {

std::string list(const std::vector<std::string>& names) {
  if (names.size() <= 8) return text::enumerate(names);
  return text::enumerate({names[0], names[1], names[2], std::to_string(names.size() - 3) + " more"});
}

void require_on_earth(const std::string& what, const Eigen::Vector3d& position) {
  constexpr double furthest = 1e9;  // [m]: a hundred and fifty times the way to the centre of the Earth
  if (position.allFinite() && position.cwiseAbs().maxCoeff() < furthest) return;
  throw std::runtime_error(what +
                           fmt::format(" is at ({:.6g}, {:.6g}, {:.6g})", position.x(), position.y(), position.z()) +
                           ": expected are metres, below 1e9; correct it in the file, or leave it out");
}

}  // namespace

void require_enough_observations(const PointBlock& block) {
  if (block.images.size() < 2)
    throw std::runtime_error("a block needs at least 2 images, this one has " + std::to_string(block.images.size()));
  std::vector<int> rays(block.points.size()), seen(block.images.size());
  for (const auto& m : block.measurements) {
    ++rays[m.point];
    ++seen[m.image];
  }
  std::vector<bool> known(block.points.size());
  for (size_t k = 0; k < block.control.points.size(); ++k) known[block.control.points[k]] = !block.control.is_check[k];
  std::vector<std::string> few;
  for (size_t i = 0; i < rays.size(); ++i)
    if (rays[i] < 2 && !known[i]) few.push_back(block.points[i].name);
  if (!few.empty())
    throw std::runtime_error("object point" + std::string(few.size() > 1 ? "s " : " ") + list(few) +
                             " measured in fewer than 2 images: no position follows from that; leave the point out");
  for (size_t i = 0; i < seen.size(); ++i)
    if (seen[i] < 3) few.push_back(std::to_string(block.images[i].id) + " (" + std::to_string(seen[i]) + ")");
  if (!few.empty())
    throw std::runtime_error("image" + std::string(few.size() > 1 ? "s " : " ") + list(few) +
                             " with fewer than 3 measured points: the pose is undetermined; leave the image out");
}

void require_enough_control(const PointBlock& block) {
  std::vector<std::string> names;
  for (size_t k = 0; k < block.control.points.size(); ++k)
    if (!block.control.is_check[k]) names.push_back(block.points[block.control.points[k]].name);
  if (names.empty() || names.size() > 2) return;
  throw std::runtime_error("only " + std::to_string(names.size()) + (names.size() == 1 ? " point" : " points") +
                           " of the control (" + text::enumerate(names) +
                           ") can be used in this block: with fewer than three points that are not on one line it can "
                           "still turn. Is the list that of another block, or does it number the points otherwise? "
                           "Give more control, or none: then the block is free, with inner constraints");
}

void require_coordinates(const PointBlock& block) {
  for (const auto& point : block.points) require_on_earth("point " + point.name, point.position);
  for (const auto& image : block.images)
    require_on_earth("the projection centre of image " + std::to_string(image.id), image.centre);
  for (size_t k = 0; k < block.control.points.size(); ++k)
    require_on_earth("control point " + block.points[block.control.points[k]].name,
                     block.control.position.segment<3>(3 * static_cast<Eigen::Index>(k)));
}

}  // namespace plumbline::block

#include "photo/block/read_block.hpp"

#include "base/text/words.hpp"
#include "least_squares/problem/defects.hpp"

namespace plumbline::block {
namespace {

int count_erased(std::vector<BlockMeasurement>& measurements, const std::vector<bool>& drop_point,
                 const std::vector<bool>& drop_image) {
  return static_cast<int>(std::erase_if(
      measurements, [&](const BlockMeasurement& m) { return drop_point[m.point] || drop_image[m.image]; }));
}

/// Removes points and images without a measurement and numbers the others anew.
void compact(PointBlock& block, const std::vector<bool>& drop_point, const std::vector<bool>& drop_image) {
  std::vector<int> point(block.points.size(), -1), image(block.images.size(), -1);
  std::vector<BlockPoint> points;
  std::vector<BlockImage> images;
  for (size_t i = 0; i < point.size(); ++i)
    if (!drop_point[i]) {
      point[i] = static_cast<int>(points.size());
      points.push_back(block.points[i]);
    }
  for (size_t i = 0; i < image.size(); ++i)
    if (!drop_image[i]) {
      image[i] = static_cast<int>(images.size());
      images.push_back(block.images[i]);
    }
  block.points = std::move(points);
  block.images = std::move(images);
  for (auto& m : block.measurements) {
    m.point = point[m.point];
    m.image = image[m.image];
  }
  std::erase_if(block.scale_bars, [&](ScaleBar& bar) {
    bar.from = point[bar.from];
    bar.to = point[bar.to];
    return bar.from < 0 || bar.to < 0;
  });
  BlockControl& control = block.control;
  std::vector<Eigen::Index> rows;
  std::vector<int> kept;
  std::vector<bool> is_check;
  for (size_t k = 0; k < control.points.size(); ++k) {
    const int now = point[control.points[k]];
    if (now < 0) continue;
    kept.push_back(now);
    is_check.push_back(control.is_check[k]);
    for (Eigen::Index c = 0; c < 3; ++c) rows.push_back(3 * static_cast<Eigen::Index>(k) + c);
  }
  if (!control.points.empty()) {
    control.position = Eigen::VectorXd(control.position(rows));
    control.covariance = Eigen::MatrixXd(control.covariance(rows, rows));
  }
  control.points = kept;
  control.is_check = is_check;
}

}  // namespace

std::string few_of(const std::vector<std::string>& names) {
  if (names.size() <= 5) return text::enumerate(names);
  return text::enumerate({names[0], names[1], names[2], std::to_string(names.size() - 3) + " more"});
}

std::string number_of(size_t count, const std::string& thing) {
  return std::to_string(count) + " " + thing + (count == 1 ? "" : "s");
}

void drop_unusable(ReadBlock& read) {
  PointBlock& block = read.block;
  std::vector<bool> known(block.points.size()), drop_point(block.points.size()), drop_image(block.images.size());
  for (size_t k = 0; k < block.control.points.size(); ++k) known[block.control.points[k]] = !block.control.is_check[k];
  std::vector<std::string> single, unmarked, poor;
  for (bool changed = true; changed;) {
    changed = false;
    std::vector<int> rays(block.points.size()), ties(block.images.size());
    for (const auto& m : block.measurements) ++rays[m.point];
    for (const auto& m : block.measurements) {
      const size_t j = static_cast<size_t>(m.point);
      if (rays[j] >= 2 || known[j]) ties[m.image] += known[j] || rays[j] > 2 ? 2 : 1;
    }
    for (size_t j = 0; j < rays.size(); ++j)
      if (!drop_point[j] && rays[j] < (known[j] ? 1 : 2)) {
        drop_point[j] = changed = true;
        (rays[j] == 0 ? unmarked : single).push_back(block.points[j].name);
      }
    // A point that two other images place fixes both coordinates of its mark; one that a single other image sees has
    // its distance still open and fixes one. A pose takes six.
    for (size_t i = 0; i < ties.size(); ++i)
      if (!drop_image[i] && ties[i] < 6) {
        drop_image[i] = changed = true;
        poor.push_back(std::to_string(block.images[i].id));
      }
    count_erased(block.measurements, drop_point, drop_image);
  }
  if (!single.empty())
    read.left_out.push_back(number_of(single.size(), "point") + " measured in one image only: " + few_of(single));
  if (!unmarked.empty())
    read.left_out.push_back(number_of(unmarked.size(), "point") + " measured in no image: " + few_of(unmarked));
  if (!poor.empty())
    read.left_out.push_back(number_of(poor.size(), "image") +
                            " that too few points tie to the others: " + few_of(poor));
  compact(block, drop_point, drop_image);
}

}  // namespace plumbline::block

#include "crossval_node.hpp"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "artifacts/camera.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "geometry/random.hpp"

namespace plumbline::block {
namespace {

/// Names in an order that has nothing to do with places: a fold is no corner of the building.
std::vector<std::string> scattered(std::vector<std::string> names) {
  std::sort(names.begin(), names.end(), [](const std::string& a, const std::string& b) {
    return std::pair(derive_seed(0, a), a) < std::pair(derive_seed(0, b), b);
  });
  return names;
}

double normalised_square(const Eigen::VectorXd& off, const Eigen::MatrixXd& covariance) {
  return off.dot(covariance.llt().solve(off));
}

Eigen::MatrixXd heights_of(const Eigen::MatrixXd& covariance, Eigen::VectorXd& off) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = 2; k < off.size(); k += 3) rows.push_back(k);
  off = off(rows).eval();
  return covariance(rows, rows);
}

/// The control without what belongs to the other half.
void keep(const std::vector<int>& plates, TagControl& control) {
  std::vector<int> rows;
  TagControl kept;
  for (size_t k = 0; k < control.plates.size(); ++k) {
    if (std::find(plates.begin(), plates.end(), control.plates[k]) == plates.end()) continue;
    kept.plates.push_back(control.plates[k]);
    for (int c = 0; c < 3; ++c) rows.push_back(3 * static_cast<int>(k) + c);
  }
  kept.position = control.position(rows);
  kept.covariance = control.covariance(rows, rows);
  control = kept;
}

}  // namespace

void EvaluateCrossval::run(Context& context) { tell(context, *by == "halves" ? halves(context) : withheld(context)); }

/// The block with all photographs, or with every second from `first` on.
TagBlockBuilder EvaluateCrossval::builder_of(bool every, size_t first) const {
  TagBlockBuilder builder(camera.unpack(), plates.unpack(), poses.unpack());
  builder.set_prior(*self_calibration == "prior");
  for (size_t i = first; i < observations.size(); i += every ? 1 : 2)
    builder.add_image(observations.unpack(i), *corner_sigma);
  builder.set_control(control.unpack());
  return builder;
}

std::map<std::string, int> EvaluateCrossval::floors() const {
  std::map<std::string, int> floor;
  const PlatesT artifact = plates.unpack();
  for (const auto& plate : artifact.plates) floor[plate->anchor] = plate->floor;
  return floor;
}

EvaluateCrossval::Sums EvaluateCrossval::withheld(Context& context) {
  const TagBlockBuilder builder = builder_of(true, 0);
  const TagBlock& block = builder.block();
  std::map<std::string, int> floor = floors(), number;
  std::vector<std::string> names;
  for (int plate : block.control.plates) {
    names.push_back(block.plates[plate].anchor);
    number[names.back()] = plate;
  }
  std::map<std::string, std::vector<int>> groups;
  names = scattered(names);
  for (size_t k = 0; k < names.size(); ++k) {
    const bool by_floor = *by == "floor";
    const int64_t group = by_floor ? floor[names[k]] : static_cast<int64_t>(k) % *folds + 1;
    const std::string label = fmt::format("{} {:3}", by_floor ? "floor" : "fold", group);
    groups[label].push_back(number[names[k]]);
  }
  TagBlockOptions options = tag_options();
  std::vector<std::string> labels;
  for (const auto& [name, members] : groups) labels.push_back(name), options.withhold.push_back(members);
  const TagBlockResult result = adjust_tag_block(block, options);
  report(context, block, result);
  Sums sums;
  for (const RejectedControl& point : result.rejected_control) {
    const std::string& anchor = block.plates[point.plate].anchor;
    sums.left_out.push_back({"left out", anchor, floor[anchor], point.off, point.sigma});
  }
  int failed = 0;
  for (size_t g = 0; g < labels.size(); ++g) {
    const WithheldControl& group = result.withheld[g];
    const bool all_out = std::all_of(options.withhold[g].begin(), options.withhold[g].end(), [&](int plate) {
      return std::any_of(result.rejected_control.begin(), result.rejected_control.end(),
                         [&](const RejectedControl& point) { return point.plate == plate; });
    });
    if (all_out) continue;
    if (!group.undetermined.empty()) {
      context.warn(labels[g] + " is not validated: " + group.undetermined);
      ++failed;
      continue;
    }
    for (size_t k = 0; k < group.plates.size(); ++k) {
      const auto at = static_cast<Eigen::Index>(3 * k);
      const std::string& anchor = block.plates[group.plates[k]].anchor;
      sums.all.push_back({labels[g], anchor, floor[anchor], group.off.segment<3>(at),
                          group.covariance.diagonal().segment<3>(at).cwiseSqrt()});
    }
    sums.nees_3d += normalised_square(group.off, group.covariance);
    Eigen::VectorXd heights = group.off;
    const Eigen::MatrixXd of_heights = heights_of(group.covariance, heights);
    sums.nees_z += normalised_square(heights, of_heights);
  }
  context.metric("folds", static_cast<double>(labels.size()), "1");
  context.metric("failed_folds", failed, "1");
  if (sums.all.empty())
    throw std::runtime_error("no point could be validated: " + result.withheld.front().undetermined +
                             "; take more folds, or control on more floors");
  return sums;
}

EvaluateCrossval::Sums EvaluateCrossval::halves(Context& context) {
  std::map<std::string, int> floor = floors();
  std::vector<TagBlockResult> models;
  std::vector<std::string> anchors;
  Sums sums;
  for (size_t half = 0; half < 2; ++half) {
    const TagBlockBuilder builder = builder_of(false, half);
    TagBlock block = builder.block();
    std::vector<std::string> names;
    for (const auto& plate : block.plates) names.push_back(plate.anchor);
    anchors = names;
    names = scattered(names);
    std::vector<int> mine;
    for (size_t k = half; k < names.size(); k += 2)
      mine.push_back(static_cast<int>(std::find(anchors.begin(), anchors.end(), names[k]) - anchors.begin()));
    keep(mine, block.control);
    try {
      models.push_back(adjust_tag_block(block, tag_options()));
    } catch (const std::runtime_error& error) {
      throw Failure(kind_of(error), "half " + std::to_string(half + 1) + " of the photographs and of the control (" +
                                        std::to_string(block.control.plates.size()) + " points): " + error.what());
    }
    report(context, block, models.back());
    for (const RejectedControl& point : models.back().rejected_control) {
      const std::string& anchor = block.plates[point.plate].anchor;
      sums.left_out.push_back(
          {"left out of half " + std::to_string(half + 1), anchor, floor[anchor], point.off, point.sigma});
    }
  }
  std::vector<int> rows[2];
  for (size_t j = 0; j < models[0].plates.size(); ++j) {
    const auto other = std::find(models[1].plates.begin(), models[1].plates.end(), models[0].plates[j]);
    if (other == models[1].plates.end()) continue;
    for (int c = 0; c < 3; ++c) {
      rows[0].push_back(3 * static_cast<int>(j) + c);
      rows[1].push_back(3 * static_cast<int>(other - models[1].plates.begin()) + c);
    }
    const std::string& anchor = anchors[models[0].plates[j]];
    sums.all.push_back({"halves", anchor, floor[anchor]});
  }
  if (sums.all.empty()) throw std::runtime_error("the two halves of the photographs have no anchor in common");
  Eigen::VectorXd off = models[0].anchors(rows[0]) - models[1].anchors(rows[1]);
  const Eigen::MatrixXd covariance =
      models[0].anchor_covariance(rows[0], rows[0]) + models[1].anchor_covariance(rows[1], rows[1]);
  for (size_t k = 0; k < sums.all.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(3 * k);
    sums.all[k].off = off.segment<3>(at);
    sums.all[k].sigma = covariance.diagonal().segment<3>(at).cwiseSqrt();
  }
  sums.nees_3d = normalised_square(off, covariance);
  const Eigen::MatrixXd of_heights = heights_of(covariance, off);
  sums.nees_z = normalised_square(off, of_heights);
  return sums;
}

void EvaluateCrossval::tell(Context& context, const Sums& sums) {
  PointsT out;
  std::string text = "fold,anchor,floor,dx_m,dy_m,dz_m,sigma_x_m,sigma_y_m,sigma_z_m,normalised_dz\n";
  const auto add_row = [&](const Difference& d) {
    text +=
        fmt::format("{},{},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.3f}\n", d.fold + "," + d.anchor, d.floor,
                    d.off.x(), d.off.y(), d.off.z(), d.sigma.x(), d.sigma.y(), d.sigma.z(), d.off.z() / d.sigma.z());
  };
  double squares = 0, sum = 0, largest = 0, predicted = 0, all = 0, within = 0;
  for (const Difference& d : sums.all) {
    auto point = std::make_unique<PointT>();
    point->id = d.anchor;
    point->position = d.off;
    point->sigma = d.sigma;
    out.points.push_back(std::move(point));
    add_row(d);
    squares += d.off.z() * d.off.z(), sum += d.off.z(), all += d.off.squaredNorm();
    predicted += d.sigma.z() * d.sigma.z();
    largest = std::max(largest, std::abs(d.off.z()));
    within += std::abs(d.off.z()) <= 2 * d.sigma.z() ? 1 : 0;
  }
  for (const Difference& d : sums.left_out) add_row(d);
  const auto n = static_cast<double>(sums.all.size());
  context.metric("points", n, "1");
  context.metric("left_out", static_cast<double>(sums.left_out.size()), "1");
  context.metric("rmse_z", std::sqrt(squares / n), "m");
  context.metric("bias_z", sum / n, "m");
  context.metric("max_abs_z", largest, "m");
  context.metric("rmse_3d", std::sqrt(all / n), "m");
  context.metric("predicted_rmse_z", std::sqrt(predicted / n), "m");
  context.metric("within_two_sigma_z", within / n, "1");
  context.metric("nees_z", sums.nees_z, "1");
  context.metric("freedom_z", n, "1");
  context.metric("nees_3d", sums.nees_3d, "1");
  context.metric("freedom_3d", 3 * n, "1");
  differences.commit(out);
  FileT file;
  file.name = "crossval.csv";
  file.media_type = "text/csv";
  file.content.assign(text.begin(), text.end());
  table.commit(file);
}

}  // namespace plumbline::block

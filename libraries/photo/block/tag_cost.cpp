#include "photo/block/tag_cost.hpp"

#include <algorithm>
#include <stdexcept>

#include "photo/block/tag_block_model.hpp"
#include "photo/bundle/terms.hpp"

namespace plumbline::block {
namespace {

constexpr double held = 1e-8;  ///< [m] standard deviation that holds an anchor: nothing that images tell moves it

TagStart start_of(const TagBlock& block, const std::map<std::string, Eigen::Vector3d>& anchors, TagCost& cost) {
  TagStart start;
  std::vector<bool> image(block.images.size()), plate(block.plates.size());
  for (size_t o = 0; o < block.observations.size(); ++o) {
    const TagObservation& seen = block.observations[o];
    const size_t i = static_cast<size_t>(seen.image), j = static_cast<size_t>(seen.plate);
    if (!block.images[i].cam_from_world || anchors.count(block.plates[j].anchor) == 0) {
      ++cost.left_out;
      continue;
    }
    image[i] = plate[j] = true;
    start.observations.push_back(static_cast<int>(o));
  }
  for (size_t i = 0; i < image.size(); ++i)
    if (image[i]) {
      start.images.push_back(static_cast<int>(i));
      start.cam_from_world.push_back(*block.images[i].cam_from_world);
    }
  for (size_t j = 0; j < plate.size(); ++j)
    if (plate[j]) {
      start.plates.push_back(static_cast<int>(j));
      start.world_from_plate.push_back({block.plates[j].nominal_rotation, anchors.at(block.plates[j].anchor)});
    }
  if (start.images.size() < 2 || start.plates.empty())
    throw std::runtime_error("a cost needs two images with a pose that see anchors with coordinates; there are " +
                             std::to_string(start.images.size()) + " images and " +
                             std::to_string(start.plates.size()) + " anchors");
  return start;
}

/// The model an adjustment with these priors has, at the interior orientation that is judged.
TagModel judged_model(const TagBlock& block, const TagStart& start, const TagCostPriors& priors) {
  TagBlockOptions options;
  options.self_calibration = !priors.calibration.empty();
  options.free_interior = priors.free_interior;
  options.tag_scale_sigma = priors.tag_scale_sigma;
  options.corner_inset_sigma = priors.corner_inset_sigma;
  options.image_principal_point_sigma = priors.image_principal_point_sigma;
  options.free_network = block.control.plates.empty();
  TagBlock assumed = block;
  if (priors.calibration.size() > assumed.cameras.size() ||
      (options.self_calibration && priors.calibration.size() < assumed.cameras.size()))
    throw std::runtime_error("the calibration has " + std::to_string(priors.calibration.size()) +
                             " cameras, those to be judged are " + std::to_string(assumed.cameras.size()));
  for (size_t c = 0; c < priors.calibration.size(); ++c) {
    assumed.cameras[c].interior = priors.calibration[c].interior;
    assumed.cameras[c].covariance = priors.calibration[c].covariance;
  }
  TagModel model = build_tag_model(assumed, options, start);
  for (size_t c = 0; c < block.cameras.size(); ++c) {
    const auto judged = block.cameras[c].interior.parameters();
    std::copy(judged.begin(), judged.end(), model.state.interiors[c].begin());
  }
  return model;
}

/// Turns plates about their anchors, and lets sizes and insets go where they fit best under their priors.
void fit_what_is_open(TagModel& model) {
  bundle::Problem open = model.problem;
  open.known.clear();
  for (const auto& term : model.problem.known)
    if (term.group == group_scale || term.group == group_inset) open.known.push_back(term);
  for (auto& camera : open.cameras) std::fill(camera.free.begin(), camera.free.end(), false);
  for (auto& image : open.images) image.fixed = true, image.shift_free = false;
  for (auto& tag : open.image_tags) tag.robust = false;
  for (int j = 0; j < static_cast<int>(open.plates.size()); ++j)
    open.known.push_back({{{bundle::Kind::plate, j}},
                          model.state.plates[j].position,
                          Eigen::Matrix3d::Identity() / held,
                          group_control});
  bundle::minimise_schur(open, model.state, {});
}

/// Adds up the squares at the model's state.
void sum_up(const TagModel& model, TagCost& cost) {
  const bundle::Layout layout(model.problem);
  bundle::Rows rows;
  for (const auto& tag : model.problem.image_tags) {
    if (!bundle::evaluate(model.problem, layout, model.state, tag, false, rows))
      throw std::runtime_error("the tag of " + model.problem.plates[tag.plate].name + " lies behind the camera of " +
                               model.problem.images[tag.image].name);
    cost.images += rows.values().squaredNorm();
    cost.corner_rows += rows.rows;
  }
  for (int k = 0; k < static_cast<int>(model.problem.known.size()); ++k) {
    const auto known = bundle::evaluate(model.problem, layout, model.state, model.problem.known[k]);
    if (k == model.control_term) {
      cost.control = known.residual.squaredNorm();
      cost.control_rows = static_cast<int>(known.residual.size());
    } else {
      cost.priors += known.residual.squaredNorm();
    }
  }
}

}  // namespace

TagCost cost_of_tag_block(const TagBlock& block, const std::map<std::string, Eigen::Vector3d>& anchors,
                          const TagCostPriors& priors) {
  TagCost cost;
  TagModel model = judged_model(block, start_of(block, anchors, cost), priors);
  fit_what_is_open(model);
  sum_up(model, cost);
  return cost;
}

TagCost start_cost_of_tag_block(const TagBlock& block, const TagCostPriors& priors) {
  require_usable(block);
  TagCost cost;
  std::vector<std::string> left_out, warnings;
  TagStart start = start_tag_block(block, std::vector<bool>(block.observations.size(), true), left_out);
  if (!block.control.plates.empty()) move_to_control(block, start, warnings);
  cost.left_out = static_cast<int>(block.observations.size() - start.observations.size());
  sum_up(judged_model(block, start, priors), cost);
  return cost;
}

}  // namespace plumbline::block

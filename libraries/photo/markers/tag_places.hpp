// Tags that were moved while the photographs were taken, and numbers that two tags carry. To the adjustment both are
// blunders: it leaves out one half of the photographs of the tag, or all, and has a place that is neither.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "photo/markers/marker_model.hpp"

namespace plumbline::markers {

/// The photographs of a tag, placed by the other tags in them, have it at two places.
struct TagAtTwoPlaces {
  int marker = 0;                         ///< index into MarkerBlock::markers
  bool in_order = false;                  ///< by the names of the photographs, all of the one before all of the other
  std::array<Eigen::Vector3d, 2> places;  ///< of its centre; of `in_order` the earlier one first
  std::array<std::vector<int>, 2> views;  ///< at each of them, in the order of the photographs' names
  double distance() const { return (places[1] - places[0]).norm(); }
  size_t larger() const { return views[1].size() > views[0].size() ? 1 : 0; }
};

/// Where one place does not fit and two do, by the scale of what the tags fit that stayed. `placed`: poses and cameras
/// as adjusted with the views of `use`. At least three photographs at each of the places: two rays nearly always meet.
std::vector<TagAtTwoPlaces> tags_at_two_places(const MarkerBlock& block, const MarkerStart& placed,
                                               const std::vector<bool>& use);

/// What happened to them, a sentence each; one for two that changed places. Of each the larger part was kept.
std::vector<std::string> words_of(const MarkerBlock& block, const std::vector<TagAtTwoPlaces>& found);

/// Photographs of a tag that contradict the others and that no second place explains, where they are many.
std::vector<std::string> words_of_rejected(const MarkerBlock& block, const MarkerResult& result,
                                           const std::vector<TagAtTwoPlaces>& explained);

}  // namespace plumbline::markers

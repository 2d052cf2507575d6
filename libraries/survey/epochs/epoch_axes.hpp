// Part of epoch_series.cpp: which coordinates of a point are compared, in which epochs.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "survey/epochs/compare_epochs.hpp"

namespace plumbline::survey {

/// A coordinate of a point in an epoch.
enum class Measured {
  yes,
  held,    ///< without error: it was taken, not measured, and says nothing of a movement
  missing  ///< the point has no such coordinate there
};

struct ComparedAxes {
  std::vector<Eigen::Index> axes;   ///< 0 E, 1 N, 2 H
  std::vector<std::size_t> epochs;  ///< those in which all of them were measured, as indices into what was given
};

/// Of all sets of axes the one with most to compare, axes times epochs after the first; of equals that with more axes.
/// None if no axis was measured twice.
ComparedAxes compared_axes(const std::vector<std::array<Measured, 3>>& epochs);

/// What is not compared though some epoch has it, in words: "epoch E2: H of A held, not measured; ...". Points alike
/// are told together.
class NotCompared {
 public:
  /// `seen[k]` is the epoch numbered `numbers[k]`.
  void add(const std::string& id, const std::vector<std::array<Measured, 3>>& seen,
           const std::vector<std::size_t>& numbers, const ComparedAxes& compared);
  std::vector<std::string> words(const std::vector<std::string>& epoch_names) const;

 private:
  struct Group {
    std::size_t epoch;  ///< kAll: axes that are not compared at all
    std::string axes;
    Measured why;
    std::vector<std::string> ids;
  };
  static constexpr std::size_t kAll = static_cast<std::size_t>(-1);
  void add(std::size_t epoch, const std::string& axes, Measured why, const std::string& id);
  std::vector<Group> groups_;
};

}  // namespace plumbline::survey

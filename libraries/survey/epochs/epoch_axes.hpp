// Part of epoch_series.cpp: which coordinates of a point are compared, in which epochs.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace plumbline::survey {

/// A coordinate of a point in an epoch.
enum class Measured {
  yes,
  held,    ///< without error: it was taken, not measured, and says nothing of a movement
  missing  ///< the point has no such coordinate there
};

/// E, N, H that two epochs or more measured: each is compared in those, whatever the others are there.
std::array<bool, 3> compared_axes(const std::vector<std::array<Measured, 3>>& epochs);

/// What is not compared though some epoch has it, in words: "epoch E2: H of A held, not measured; ...". Points alike
/// are told together.
class NotCompared {
 public:
  /// `seen[k]` is the epoch numbered `numbers[k]`.
  void add(const std::string& id, const std::vector<std::array<Measured, 3>>& seen,
           const std::vector<std::size_t>& numbers, const std::array<bool, 3>& compared);
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

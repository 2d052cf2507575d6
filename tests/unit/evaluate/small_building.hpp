// A building small enough to work every formula by hand: three floors, columns 1 and 2, one anchor each, all check
// anchors.
//
//   dz [mm]    column 1   column 2   r_f
//   floor 3       +4         +2      +3
//   floor 2       -2          0      -1
//   floor 1       +1         +3      +2
#pragma once

#include <cmath>

#include "../bim/doubt.hpp"
#include "building/judgement/accuracy.hpp"

namespace plumbline::judgement::test {

using plumbline::test::doubt;

inline constexpr double mm = 1e-3;

inline Eigen::MatrixXd isotropic(std::size_t points, double sigma) {
  const auto n = static_cast<Eigen::Index>(3 * points);
  return sigma * sigma * Eigen::MatrixXd::Identity(n, n);
}

/// Adds points of the given role; the survey stands at height 0, so that dz is exact.
inline void add_anchor(Inputs& inputs, const std::string& id, int floor, int column, AnchorUse use,
                       const Eigen::Vector3d& difference) {
  inputs.anchors.push_back({id, floor, column, 1, use});
  const Eigen::Vector3d place(2.0 * column, 0, 0);
  inputs.survey.ids.push_back(id);
  inputs.survey.positions.push_back(place);
  inputs.model.ids.push_back(id);
  inputs.model.positions.push_back(place + difference);
}

inline void set_sigmas(Inputs& inputs, double model, double survey) {
  inputs.model.covariance = isotropic(inputs.model.ids.size(), model);
  inputs.survey.covariance = isotropic(inputs.survey.ids.size(), survey);
}

inline Inputs small_building(AnchorUse use = AnchorUse::check) {
  Inputs inputs;
  const double dz[3][2] = {{1 * mm, 3 * mm}, {-2 * mm, 0}, {4 * mm, 2 * mm}};
  for (int floor = 1; floor <= 3; ++floor)
    for (int column = 1; column <= 2; ++column)
      add_anchor(inputs, "F" + std::to_string(floor) + "C" + std::to_string(column), floor, column, use,
                 {0, 0, dz[floor - 1][column - 1]});
  set_sigmas(inputs, 0.3 * mm, 0.4 * mm);
  return inputs;
}

inline const AccuracyComparisonT* find(const AccuracyT& accuracy, AnchorUse use, AccuracyReference reference) {
  for (const auto& c : accuracy.comparisons)
    if (c->use == use && c->reference == reference) return c.get();
  return nullptr;
}

inline bool warns(const AccuracyT& accuracy, const std::string& words) {
  for (const std::string& warning : accuracy.warnings)
    if (warning.find(words) != std::string::npos) return true;
  return false;
}

/// Splitmix64 and Box-Muller: the same numbers on every machine.
class Normal {
 public:
  explicit Normal(std::uint64_t seed) : state_(seed) {}
  double operator()() { return std::sqrt(-2 * std::log(uniform())) * std::cos(2 * M_PI * uniform()); }

 private:
  double uniform() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (static_cast<double>((z ^ (z >> 31)) >> 11) + 0.5) * 0x1p-53;
  }
  std::uint64_t state_;
};

}  // namespace plumbline::judgement::test

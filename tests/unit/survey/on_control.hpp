// A network of two free set-ups on four known points, by which mistakes that a whole set-up shares are told apart.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "simulated_network.hpp"
#include "survey/adjust/adjust_network.hpp"

namespace plumbline::survey::test {

/// Twelve markers, the corners known to a millimetre, seen from two set-ups.
struct OnControl {
  test::SimulatedNetwork network;
  ControlPoints control;

  explicit OnControl(std::uint64_t seed) {
    test::SimulationSettings settings;
    settings.set_ups = 2, settings.columns = 5, settings.rows = 4;
    network = simulate(settings, seed);
    control.coordinates.resize(12);
    for (const size_t i : {size_t{0}, size_t{4}, size_t{15}, size_t{19}}) {
      control.coordinates.segment<3>(static_cast<Eigen::Index>(3 * control.ids.size())) = network.truth[i];
      control.ids.push_back(network.survey.points[i].id);
    }
    control.covariance = 1e-6 * Eigen::MatrixXd::Identity(12, 12);
  }
  void know_stations() {
    for (const size_t i : {size_t{20}, size_t{21}}) {
      control.coordinates.conservativeResize(control.coordinates.size() + 3);
      control.coordinates.tail<3>() = network.truth[i];
      control.ids.push_back(network.survey.points[i].id);
    }
    control.covariance = 1e-6 * Eigen::MatrixXd::Identity(18, 18);
    control.covariance.bottomRightCorner<6, 6>() *= 0.01;
  }
  bool is_known(const std::string& id) const {
    return std::find(control.ids.begin(), control.ids.end(), id) != control.ids.end();
  }
  /// `largest_whole`: with more unknowns than that rivals are judged by the last equations.
  NetworkResult adjust(bool remove, int largest_whole = AdjustOptions().largest_whole) const {
    AdjustOptions options;
    options.largest_whole = largest_whole;
    options.curvature = Switch::off, options.remove_blunders = remove;
    return adjust_network(network.survey, options, control);
  }
  double worst(const NetworkResult& r) const {
    double most = 0;
    for (size_t i = 0; i < 20; ++i)
      most = std::max(most, (r.point(network.survey.points[i].id).position - network.truth[i]).norm());
    return most;
  }
};

}  // namespace plumbline::survey::test

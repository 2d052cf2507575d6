// survey.compare_epochs: two adjusted epochs to movements. survey.check_control: known points against the network that
// is to be tied to them.
#pragma once

#include "artifacts/points.hpp"
#include "artifacts/survey_comparison.hpp"
#include "artifacts/survey_network.hpp"
#include "artifacts/survey_observations.hpp"
#include "map_parameters.hpp"

namespace plumbline::survey {

struct CompareEpochsNode : Node {
  static constexpr Info info{"survey.compare_epochs", "", 7,
                             "Tests whether two epochs of a network are congruent and which points have moved"};
  In<Points> first{"first", frame("frame=?S"), "adjusted points of the first epoch, with full covariance"};
  In<Points> second{"second", frame("frame=?S"), "adjusted points of the second epoch, with full covariance"};
  Optional<SurveyNetwork> first_network{
      "first_network", frame("frame=?S"),
      "with both networks, instrument stations that nothing sights are left out: they stand elsewhere every time"};
  Optional<SurveyNetwork> second_network{"second_network", frame("frame=?S"), "see first_network"};
  Param<std::vector<std::string>> points{
      "points", std::vector<std::string>{},
      "names or patterns with * and ? of the points to compare; empty: all in common"};
  Param<std::string> datum{
      "datum", "automatic", one_of("automatic", "free", "fixed"),
      "free: epochs may be shifted and turned against each other; automatic: if one is a free network"};
  Param<double> alpha{"alpha", 0.05, "1", between(1e-6, 0.5), "error of the first kind of the global test"};
  Param<double> alpha0{"alpha0", 0.001, "1", between(1e-9, 0.5), "error of the first kind of the test of a point"};
  Param<double> power{"power", 0.80, "1", between(0.5, 0.999), "power that the detectable movement refers to"};
  Out<SurveyComparison> comparison{"comparison", frame("frame=?S"), "movements and tests"};
  void run(Context& context) override;
};

struct CheckControlNode : MappedNode {
  static constexpr Info info{"survey.check_control", "", 4,
                             "Tests known points against a free network of the observations, before they bend it"};
  List<plumbline::SurveyObservations> observations{
      "observations", frame("frame=?S"), "readings of one campaign; points that its files hold fixed are control too"};
  Optional<Points> control{"control", frame("frame=?S"), "points known beforehand, with or without covariance"};
  Optional<Points> measured{"measured", frame("frame=?S"),
                            "measured_control of the survey.adjust that has these observations and this control: with "
                            "it nothing is adjusted once more"};
  Param<std::vector<std::string>> same_stations{"same_stations", std::vector<std::string>{},
                                                "as in survey.adjust: stations of several files that are one mark"};
  Param<bool> remove_blunders{"remove_blunders", false,
                              "data snooping cleans the free network first; then `measured` is not used"};
  Param<double> alpha{"alpha", 0.01, "1", between(1e-6, 0.5), "error of the first kind of the global test"};
  Param<double> alpha0{"alpha0", 0.001, "1", between(1e-9, 0.5), "error of the first kind of the test of a point"};
  Param<double> power{"power", 0.80, "1", between(0.5, 0.999), "power that the detectable difference refers to"};
  Out<SurveyComparison> check{"check", frame("frame=?S"), "given coordinates against measured ones, and tests"};
  void run(Context& context) override;
};

}  // namespace plumbline::survey

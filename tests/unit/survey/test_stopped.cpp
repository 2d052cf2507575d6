// Whoever is stopped says so, wherever it was: a stop that is taken for "did not converge" or "not determined" gives
// another result, or a message about the network that is not true.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>

#include "plumbline/stop.hpp"
#include "simulated_network.hpp"
#include "survey/epochs/check_control.hpp"
#include "survey/files/gama.hpp"
#include "survey/files/starnet.hpp"
#include "survey/plan/plan_survey.hpp"
#include "survey/start/merge_surveys.hpp"

namespace plumbline::survey {
namespace test_stopped {

struct Asked {
  long limit = std::numeric_limits<long>::max(), count = 0;
};

bool is_over(const void* of) {
  auto& asked = *static_cast<Asked*>(const_cast<void*>(of));
  return ++asked.count > asked.limit;
}

/// Stops `work` at some thirty of the places where it asks, the first and the last among them.
void expect_to_stop_everywhere(const std::function<void()>& work) {
  Asked all;
  {
    const StopScope scope(&is_over, &all);
    work();
  }
  ASSERT_GT(all.count, 0) << "it never asks";
  for (int part = 0; part <= 30; ++part) {
    Asked asked{(all.count - 1) * part / 30, 0};
    const StopScope scope(&is_over, &asked);
    std::string said = "a result";
    try {
      work();
    } catch (const Stopped&) {
      said = "stopped";
    } catch (const std::exception& error) {
      said = error.what();
    }
    // Work of other threads asks in another order; who was not told to stop need not have.
    if (asked.count > asked.limit) {
      EXPECT_EQ(said, "stopped") << "at " << asked.limit << " of " << all.count;
    }
  }
}

SurveyObservations network_with_a_blunder(bool with_coordinates) {
  test::SimulationSettings settings;
  settings.coordinates = with_coordinates;
  SurveyObservations survey = test::simulate(settings, 5).survey;
  survey.observations[40].value += 0.02;
  return survey;
}

/// What is no result is examined for its cause: hypotheses that fail are no stops, and stops no hypotheses that fail.
TEST(Stopped, TheSearchForACauseStopsWhereverItIs) {
  SurveyObservations survey = network_with_a_blunder(false);
  for (Observation& o : survey.observations)
    if (o.kind == ObservationKind::direction) o.value *= 0.9;
  expect_to_stop_everywhere([&] {
    try {
      adjust_network(survey, {});
    } catch (const NetworkError&) {
    }
  });
}

TEST(Stopped, AnAdjustmentStopsWhereverItIs) {
  for (const bool with_coordinates : {true, false}) {
    const SurveyObservations survey = network_with_a_blunder(with_coordinates);
    AdjustOptions options;
    options.curvature = Switch::off;
    options.remove_blunders = true;
    expect_to_stop_everywhere([&] { adjust_network(survey, options); });
  }
}

TEST(Stopped, AControlCheckStopsWhereverItIs) {
  const auto network = test::simulate({}, 17);
  ControlPoints control;
  for (const char* id : {"M00", "M03", "M20", "M23"})
    for (size_t i = 0; i < network.survey.points.size(); ++i)
      if (network.survey.points[i].id == id) {
        control.ids.emplace_back(id);
        const Eigen::VectorXd before = control.coordinates;
        control.coordinates.resize(before.size() + 3);
        control.coordinates << before, network.truth[i];
      }
  control.covariance = 1e-6 * Eigen::MatrixXd::Identity(control.coordinates.size(), control.coordinates.size());
  AdjustOptions options;
  options.curvature = Switch::off;
  expect_to_stop_everywhere([&] { check_control(network.survey, control, options, {}); });
}

TEST(Stopped, AnAdjustmentThatMeasuresControlToo) {
  SurveyObservations survey = test::simulate({}, 17).survey;
  for (const size_t i : {size_t{0}, size_t{3}, size_t{8}, size_t{11}}) survey.points[i].known.fill(true);
  AdjustOptions options;
  options.curvature = Switch::off;
  options.measure_control = true;
  expect_to_stop_everywhere([&] { adjust_network(survey, options); });
}

/// Files are read and joined reading by reading, epochs compared point by point.
TEST(Stopped, ReadersMergingAndComparisons) {
  const SurveyObservations survey = network_with_a_blunder(true);
  const std::string gama = write_gama_xml(survey), starnet = write_starnet(survey);
  expect_to_stop_everywhere([&] { read_gama_xml(gama, "a.gkf"); });
  expect_to_stop_everywhere([&] { read_starnet(starnet, "a.dat"); });
  SurveyObservations other = test::simulate({}, 6).survey;
  for (auto& s : other.set_ups) s.id += "b";
  expect_to_stop_everywhere([&] { merge_surveys({survey, other}); });
  AdjustOptions options;
  options.curvature = Switch::off;
  options.datum = DatumMode::inner;
  const Epoch first = epoch_of(adjust_network(survey, options)), second = epoch_of(adjust_network(other, options));
  ComparisonOptions comparison;
  comparison.free_motions = 4;
  expect_to_stop_everywhere([&] { compare_epochs(first, second, comparison); });
}

TEST(Stopped, APlanStopsWhereverItIs) {
  std::vector<PlannedMarker> markers;
  for (int f = 1; f <= 2; ++f)
    for (int c = 1; c <= 3; ++c)
      markers.push_back(
          {"A" + std::to_string(f) + std::to_string(c), {2.0 * c, 0.1 * (c % 2), 4.0 * f}, {0, -1, 0}, f, c});
  PlanOptions options;
  options.profile = built_in_profile("ics50_assumed");
  expect_to_stop_everywhere([&] { plan_survey(markers, {{"S1", {5, -15, 1.6}}}, options); });
}

}  // namespace test_stopped
}  // namespace plumbline::survey

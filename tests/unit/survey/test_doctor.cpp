// What the network doctor says of sick networks.
#include "adjust_network.hpp"
#include "simulated_network.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace {

using test::simulate;

std::string message_of(const SurveyObservations& survey, const AdjustOptions& options,
                       const ControlPoints& control = {}) {
  try {
    adjust_network(survey, options, control);
  } catch (const NetworkError& error) {
    return error.what();
  }
  return "";
}

AdjustOptions with_datum(DatumMode mode) {
  AdjustOptions options;
  options.datum = mode;
  options.curvature = Switch::off;
  return options;
}

void expect_words(const std::string& message, std::initializer_list<const char*> words) {
  for (const char* word : words) EXPECT_NE(message.find(word), std::string::npos) << word << " in: " << message;
}

TEST(NetworkDoctor, NamesAllFourDefectsOfALevelledNetwork) {
  const auto n = simulate({}, 1);
  expect_words(message_of(n.survey, with_datum(DatumMode::file)),
               {"rank defect", "translation in east", "translation in north", "translation in height",
                "rotation about the vertical through"});
}

TEST(NetworkDoctor, NamesTheRotationAboutTheOnlyFixedPoint) {
  auto n = simulate({}, 2);
  n.survey.points[0].roles.fill(CoordinateRole::fixed);
  const std::string message = message_of(n.survey, with_datum(DatumMode::file));
  expect_words(message, {"rotation about the vertical through M00"});
  EXPECT_EQ(message.find("translation"), std::string::npos) << message;
}

TEST(NetworkDoctor, OneColumnOfControlLeavesTheRotationAboutIt) {
  auto n = simulate({}, 3);
  for (size_t i : {0u, 4u, 8u}) n.survey.points[i].roles.fill(CoordinateRole::fixed);  // M00, M10, M20
  expect_words(message_of(n.survey, with_datum(DatumMode::file)),
               {"rotation about the vertical through M00, M10, M20"});
}

TEST(NetworkDoctor, NamesTheMissingScale) {
  auto n = simulate({}, 4);
  std::erase_if(n.survey.observations, [](const Observation& o) { return o.kind == ObservationKind::slope_distance; });
  AdjustOptions options = with_datum(DatumMode::fixed);
  options.datum_points = {"M00"};
  expect_words(message_of(n.survey, options), {"scale", "no distance"});
}

TEST(NetworkDoctor, NamesAPointThatIsNotDetermined) {
  auto n = simulate({}, 5);
  int seen = 0;
  std::erase_if(n.survey.observations, [&](const Observation& o) {
    return o.to == "M12" && !(o.kind == ObservationKind::direction && seen++ == 0);
  });
  for (Point& p : n.survey.points)
    if (p.id == "M12") p.coordinates.setConstant(kNotGiven);
  expect_words(message_of(n.survey, with_datum(DatumMode::inner)), {"M12", "1 direction"});
  for (size_t i = 0; i < n.truth.size(); ++i) n.survey.points[i].coordinates = n.truth[i];
  expect_words(message_of(n.survey, with_datum(DatumMode::inner)), {"not determined", "M12"});
}

TEST(NetworkDoctor, NamesSeparateParts) {
  auto n = simulate({}, 6);
  // The first set-up sees only M00..M03, the others only the rest.
  std::erase_if(n.survey.observations, [](const Observation& o) {
    const bool lowest = o.to[1] == '0';
    return lowest != (o.set_up == 0);
  });
  AdjustOptions options = with_datum(DatumMode::fixed);
  options.datum_points = {"M10", "M13"};
  expect_words(message_of(n.survey, options), {"of the part with", "M00"});
}

TEST(NetworkDoctor, ListsUncontrolledObservationsAndHinges) {
  auto n = simulate({}, 7);
  std::erase_if(n.survey.observations, [](const Observation& o) { return o.to == "M23" && o.set_up != 0; });
  const NetworkResult r = adjust_network(n.survey, with_datum(DatumMode::inner));
  std::string all;
  for (const Finding& f : r.findings) all += f.text + "\n";
  expect_words(all, {"not controlled", "S1 -> M23"});

  auto hinge = simulate({}, 8);
  // Set-up 3 sees two markers only, and set-up 1 and 2 all: no hinge; with one marker it hangs on it.
  std::erase_if(hinge.survey.observations, [](const Observation& o) { return o.set_up == 2 && o.to[1] != '2'; });
  const NetworkResult ok = adjust_network(hinge.survey, with_datum(DatumMode::inner));
  for (const Finding& f : ok.findings) EXPECT_EQ(f.text.find("hangs on"), std::string::npos) << f.text;
}

TEST(NetworkDoctor, SaysWhichPointNobodyObserved) {
  auto n = simulate({}, 9);
  Point lonely;
  lonely.id = "X9";
  n.survey.points.push_back(lonely);
  const NetworkResult r = adjust_network(n.survey, with_datum(DatumMode::inner));
  std::string all;
  for (const Finding& f : r.findings) all += f.text + "\n";
  expect_words(all, {"no observation", "X9"});
  EXPECT_THROW(r.point("X9"), std::out_of_range);
}

}  // namespace
}  // namespace plumbline::survey

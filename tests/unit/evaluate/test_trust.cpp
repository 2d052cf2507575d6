// What fails a test proves nothing; what only fits less well than it should is less certain, by a factor that is known.
#include <gtest/gtest.h>

#include <cmath>

#include "building/ifc/doubt_words.hpp"
#include "building/judgement/designed_control.hpp"
#include "building/judgement/trust.hpp"

namespace plumbline::judgement {
namespace test_trust {

/// One failed test of a block whose observations are "images" and "control".
Trust after(BlockTestKind kind, const char* test, double variance_factor, double shift = std::nan(""),
            double points_factor = std::nan(""), Judged what = Judged::points) {
  flatbuffers::FlatBufferBuilder made;
  const auto groups =
      made.CreateVector(std::vector{CreateBlockGroupDirect(made, "images"), CreateBlockGroupDirect(made, "control")});
  const auto tests = made.CreateVector(std::vector{
      CreateBlockTestDirect(made, test, kind, variance_factor, 1.0, false, "it does not fit", shift, points_factor),
      CreateBlockTestDirect(made, "images", BlockTestKind::observations, 9.0, 10.0, true)});
  const auto start = made.StartTable();
  made.AddOffset(Block::VT_GROUPS, groups), made.AddOffset(Block::VT_TESTS, tests);
  made.Finish(flatbuffers::Offset<Block>(made.EndTable(start)));
  return trust_of(flatbuffers::GetRoot<Block>(made.GetBufferPointer()), nullptr, what);
}

/// One factor for all made heights that hardly feel it three times as uncertain: (error/u)^2 was 0.13 in the mean. Of
/// an adjuster that does not say that its covariances hold it, and of surfaces, nothing better is known.
TEST(Trust, WhatTheCovariancesOfPointsHoldIsNotMultipliedOnceMore) {
  const auto kind = BlockTestKind::principal_points;
  const Trust points = after(kind, "any name", 10.8, 1.7, 1.2);
  EXPECT_EQ(points.factor, 1);
  ASSERT_EQ(points.misfits.size(), 1u);
  EXPECT_EQ(ifc::in_words(points.misfits[0]),
            "the image block: it does not fit. To mend it, run again with "
            "\"block.with.image_principal_point_sigma=1.7\" (px; as large as the images show it).");
  EXPECT_EQ(after(kind, "any name", 10.8, 1.7).factor, 10.8);
  EXPECT_EQ(after(kind, "any name", 10.8, 1.7, 1.2, Judged::surfaces).factor, 10.8);
}

TEST(Trust, AModelThatFitsLessWellMakesEverythingLessCertainAndAGroupThatContradictsProvesNothing) {
  EXPECT_TRUE(trust_of(nullptr, nullptr).doubts.empty());
  EXPECT_EQ(trust_of(nullptr, nullptr).factor, 1);
  const Trust model = after(BlockTestKind::principal_points, "any name", 6.25),
              group = after(BlockTestKind::observations, "control", 6.25);
  EXPECT_TRUE(model.doubts.empty());
  EXPECT_EQ(model.factor, 6.25);
  ASSERT_EQ(model.misfits.size(), 1u);
  EXPECT_EQ(model.misfits[0].factor, 2.5);
  EXPECT_EQ(model.misfits[0].mend, "block.with.image_principal_point_sigma=0.5");
  EXPECT_EQ(ifc::in_words(model.misfits[0]),
            "the image block: it does not fit; all standard deviations are 2.5 times as large for it. To mend it, run "
            "again with \"block.with.image_principal_point_sigma=0.5\" (px; 0.1 to 1 for lenses that are focused or "
            "stabilised between images).");
  EXPECT_TRUE(group.misfits.empty());
  // A constant 0.5 made a block whose images show 1.7 px contradict itself: worse than without the command.
  EXPECT_EQ(after(BlockTestKind::principal_points, "any name", 10.8, 1.72).misfits.at(0).mend,
            "block.with.image_principal_point_sigma=1.7");
  EXPECT_EQ(after(BlockTestKind::principal_points, "any name", 10.8, 1.72).misfits.at(0).mend_note,
            "px; as large as the images show it");
  EXPECT_EQ(after(BlockTestKind::principal_points, "any name", 2, 0.01).misfits.at(0).mend,
            "block.with.image_principal_point_sigma=0.1");
  EXPECT_EQ(group.doubts.size(), 1u);
}

TEST(Trust, ATestThatFailsByNobodyKnowsHowMuchIsADoubt) {
  const Trust trust = after(BlockTestKind::principal_points, "any name", std::nan(""));
  EXPECT_TRUE(trust.misfits.empty());
  ASSERT_EQ(trust.doubts.size(), 1u);
  EXPECT_EQ(trust.doubts[0].grade, DoubtGrade::doubt);
  EXPECT_EQ(ifc::in_words(trust.doubts[0]), "the image block: it does not fit");
}

/// Once no word said how such a survey can be used, and nothing ever passed with it.
TEST(Trust, AListOfCoordinatesIsADoubtThatSaysHowItEnds) {
  const auto of = [](const char* validity, bool without_readings, double freedom) {
    flatbuffers::FlatBufferBuilder made;
    SurveyNetworkT network;
    network.statistics = std::make_unique<StatisticsT>();
    network.statistics->degrees_of_freedom = static_cast<int>(freedom), network.statistics->sigma0 = 3;
    network.tests = std::make_unique<NetworkTestsT>();
    network.validity = validity, network.verdict = "not tested", network.without_readings = without_readings;
    made.Finish(SurveyNetwork::Pack(made, &network));
    return trust_of(nullptr, flatbuffers::GetRoot<SurveyNetwork>(made.GetBufferPointer()));
  };
  EXPECT_TRUE(of("sound", true, 0).doubts.empty());
  ASSERT_EQ(of("doubtful", true, 0).doubts.size(), 1u);
  EXPECT_EQ(of("doubtful", true, 0).doubts[0].mend, "network.with.coordinates=tested");
  ASSERT_EQ(of("doubtful", false, 0).doubts.size(), 1u);
  EXPECT_EQ(of("doubtful", false, 0).doubts[0].mend, "") << "readings that nothing controls have to be measured again";
  const Trust contradicted = of("doubtful", true, 4);
  EXPECT_TRUE(contradicted.doubts.empty());
  EXPECT_EQ(contradicted.factor, 9);
}

/// A network that is sound but for its known points; statistics of G1 to G4 against 14.3.
Trust with_control(const std::vector<double>& statistics, const std::vector<std::string>& excluded = {}) {
  SurveyNetworkT network;
  network.statistics = std::make_unique<StatisticsT>();
  network.statistics->degrees_of_freedom = 120, network.statistics->sigma0 = 1.02;
  network.tests = std::make_unique<NetworkTestsT>();
  network.validity = "sound", network.verdict = "sound";
  for (std::size_t i = 0; i < statistics.size(); ++i) {
    auto known = std::make_unique<NetworkKnownPointT>();
    known->id = "G" + std::to_string(i + 1), known->rank = 3, known->critical = 14.3, known->statistic = statistics[i];
    known->difference = Eigen::Vector3d(-0.0002, -0.0001, 0.0118), known->sigma.setConstant(0.0005);
    if (known->statistic > 14.3) network.validity = "doubtful";
    network.known_points.push_back(std::move(known));
  }
  network.exclusions = excluded;
  flatbuffers::FlatBufferBuilder made;
  made.Finish(SurveyNetwork::Pack(made, &network));
  return trust_of(nullptr, flatbuffers::GetRoot<SurveyNetwork>(made.GetBufferPointer()));
}

/// Once a control point that was wrong by twelve millimetres made everything 1.96 times less certain, and an anchor
/// that was 6.6 mm out passed.
TEST(Trust, AControlPointThatTheSurveyContradictsIsADoubtWithTheCommandThatMendsIt) {
  EXPECT_TRUE(with_control({2, 3, 14, 1}).doubts.empty());
  const Trust trust = with_control({371, 40, 2, 1});
  ASSERT_EQ(trust.doubts.size(), 1u);
  EXPECT_EQ(trust.doubts[0].part, MeasurementPart::survey);
  EXPECT_EQ(trust.doubts[0].grade, DoubtGrade::doubt);
  EXPECT_EQ(trust.doubts[0].reason,
            "known points contradict it and each other, as measured minus as known: G1 E -0.2, N -0.1, H +11.8 mm; "
            "less so, and perhaps because of it: G2");
  EXPECT_EQ(trust.doubts[0].mend, "network.with.exclude=[control G1: contradicts the survey]");
  EXPECT_NE(with_control({17, 16.9, 2, 1}).doubts[0].reason.find("does not tell which of them is wrong: G2"),
            std::string::npos);
  EXPECT_EQ(
      with_control({371, 40, 2, 1}, {"control G7: moved", "line job.gsi:57: read twice, once wrong"}).doubts[0].mend,
      "network.with.exclude=[control G7: moved, 'line job.gsi:57: read twice, once wrong', control G1: contradicts "
      "the survey]")
      << "one more command must not bring back what was left out before";
  EXPECT_EQ(with_control({371, 40, 2, 1}, {"control G[7]: moved", "control 8#2: moved"}).doubts[0].mend,
            "network.with.exclude=['control G[7]: moved', 'control 8#2: moved', control G1: contradicts the survey]")
      << "what is typed is read as a list";
}

/// Of two readings that only control each other one went by chance: nothing rests on the point until it is out.
TEST(Trust, WhereNothingTellsWhichOfTwoReadingsIsWrongNothingIsDecided) {
  const auto with = [](const std::vector<std::string>& points) {
    SurveyNetworkT network;
    network.statistics = std::make_unique<StatisticsT>(), network.tests = std::make_unique<NetworkTestsT>();
    network.statistics->degrees_of_freedom = 120, network.statistics->sigma0 = 0.98;
    network.validity = "doubtful", network.verdict = "doubtful: 1 of 2 readings is wrong";
    network.exclusions = {"point M9: knocked over"};
    network.set_ups.push_back(std::make_unique<NetworkSetUpT>());
    network.set_ups.back()->id = network.set_ups.back()->station = "S1";
    network.findings.push_back(std::make_unique<NetworkFindingT>());
    network.findings.back()->severity = "warning", network.findings.back()->text = "1 of 2 readings is wrong";
    network.findings.back()->subject = "either", network.findings.back()->points = points;
    flatbuffers::FlatBufferBuilder made;
    made.Finish(SurveyNetwork::Pack(made, &network));
    return trust_of(nullptr, flatbuffers::GetRoot<SurveyNetwork>(made.GetBufferPointer()));
  };
  const Trust trust = with({"M1"});
  ASSERT_EQ(trust.doubts.size(), 1u);
  EXPECT_TRUE(trust.misfits.empty());
  EXPECT_EQ(trust.doubts[0].mend,
            "network.with.exclude=[point M9: knocked over, point M1: one of its readings is wrong]");
  EXPECT_EQ(with({"S1"}).doubts.at(0).mend, "") << "others hang on a station";
}

/// Known points that hold a survey (statistics against 14.3), and those that were left out of it, in height.
Trust after_exclusion(const std::vector<double>& holding, const std::vector<double>& left_out) {
  SurveyNetworkT network;
  network.statistics = std::make_unique<StatisticsT>(), network.tests = std::make_unique<NetworkTestsT>();
  network.validity = "sound", network.verdict = "sound";
  const auto add = [](const std::string& id, double statistic, auto& to) {
    auto known = std::make_unique<NetworkKnownPointT>();
    known->id = id, known->rank = 3, known->critical = 14.3, known->statistic = statistic;
    known->difference = Eigen::Vector3d(0.0002, 0.0001, 0.012), known->sigma.setConstant(0.0005);
    to.push_back(std::move(known));
  };
  for (std::size_t i = 0; i < holding.size(); ++i) add("G" + std::to_string(i + 1), holding[i], network.known_points);
  for (std::size_t i = 0; i < left_out.size(); ++i)
    add("X" + std::to_string(i + 1), left_out[i], network.left_out_known);
  flatbuffers::FlatBufferBuilder made;
  made.Finish(SurveyNetwork::Pack(made, &network));
  return trust_of(nullptr, flatbuffers::GetRoot<SurveyNetwork>(made.GetBufferPointer()));
}

/// Once two bench marks that had settled with the building stayed, the two sound ones were left out by the commands
/// that the program itself had given, and a building 12 mm low was ready to install.
TEST(Trust, WhatWasLeftOutSpeaksAgainstTheResultWhereItIsAsManyAsWhatHoldsIt) {
  EXPECT_TRUE(after_exclusion({1, 1, 1}, {520}).doubts.empty()) << "three against one";
  EXPECT_TRUE(after_exclusion({1, 1}, {9, 8}).doubts.empty()) << "those that were left out agree with it";
  const Trust split = after_exclusion({1, 1}, {527, 480});
  ASSERT_EQ(split.doubts.size(), 1u);
  EXPECT_EQ(split.doubts[0].reason,
            "known points that were left out contradict it, and are as many as those that hold it: X1, X2; as measured "
            "minus as known: X1 E +0.2, N +0.1, H +12.0 mm");
  EXPECT_EQ(split.doubts[0].mend, "") << "no command decides what the survey does not show";
  EXPECT_NE(split.doubts[0].mend_note.find("measure a further known point"), std::string::npos);
  EXPECT_EQ(after_exclusion({1}, {527}).doubts.size(), 1u) << "of two known points each is as good as the other";
}

TEST(Trust, NoCommandIsGivenWhereTheTestDoesNotTellWhichKnownPointIsWrong) {
  EXPECT_NE(with_control({371, 40, 2, 1}).doubts[0].mend, "");
  EXPECT_EQ(with_control({371, 370, 2, 1}).doubts[0].mend, "") << "as much";
  EXPECT_EQ(with_control({371, 40}).doubts[0].mend, "") << "one would be left, which nothing else confirms";
  const Trust second = after_exclusion({40, 30, 527}, {480});
  EXPECT_EQ(second.doubts[0].mend, "") << "with the one left out before it would be two against two";
  EXPECT_NE(second.doubts[0].reason.find("; and so do those that were left out: X1"), std::string::npos)
      << second.doubts[0].reason;
}

/// Anchors in a row, two metres apart, that were measured to 0.3 mm beside control of 0.5 mm.
struct OnDesign {
  SurveyNetworkT network;
  std::vector<AnchorCase> anchors;
  PointSet model;

  explicit OnDesign(const std::string& datum, int count = 4) {
    network.statistics = std::make_unique<StatisticsT>(), network.tests = std::make_unique<NetworkTestsT>();
    network.datum = datum;
    for (int i = 0; i < count; ++i) {
      AnchorCase& anchor = anchors.emplace_back();
      anchor.id = "A" + std::to_string(i + 1), anchor.design = {2.0 * i, 0, 3};
      model.ids.push_back(anchor.id), model.positions.push_back(anchor.design + Eigen::Vector3d(0.003, 0, 0));
    }
  }
  void know(const std::string& id, const Eigen::Vector3d& at, double sigma = 0.0005) {
    auto known = std::make_unique<NetworkKnownPointT>();
    known->id = id, known->difference.setZero(), known->sigma.setConstant(sigma);
    network.known_points.push_back(std::move(known));
    for (int axis = 0; axis < 3; ++axis) {
      auto row = std::make_unique<NetworkObservationT>();
      row->kind = "coordinate", row->to = id, row->detail = std::string(1, "ENH"[axis]);
      row->value = at[axis], row->sigma = sigma;
      network.observations.push_back(std::move(row));
    }
  }
  DesignedControl found(const FrameLink& link = {}) {
    // Rigid readings: all anchors move with the mean of the known points, each of 0.5 mm.
    const auto n = static_cast<double>(network.known_points.size());
    const auto points = static_cast<Eigen::Index>(model.ids.size());
    Eigen::MatrixXd common = Eigen::MatrixXd(Eigen::Matrix3d::Identity() * 0.25e-6 / n).replicate(points, points);
    if (!link.covariance.isZero(0))  // a shift that all have in common
      common += Eigen::MatrixXd(link.covariance(3, 3) * Eigen::Matrix3d::Identity()).replicate(points, points);
    model.covariance = common;
    flatbuffers::FlatBufferBuilder made;
    made.Finish(SurveyNetwork::Pack(made, &network));
    return designed_control(*flatbuffers::GetRoot<SurveyNetwork>(made.GetBufferPointer()), link, anchors, model);
  }
};

/// Once a building 30 mm out and 30 mm low was ready to install, because control.csv had four anchors as designed.
TEST(Trust, ControlWithTheCoordinatesOfTheDesignIsAFitToIt) {
  OnDesign made("weighted");
  for (int i : {0, 3}) {
    made.anchors[i].design += Eigen::Vector3d(0.0004, 0, -0.0004);
    made.know(made.anchors[i].id, Eigen::Vector3d(2.0 * i, 0, 3));  // written in whole millimetres
  }
  const DesignedControl control = made.found();
  EXPECT_EQ(control.ids, (std::vector<std::string>{"A1", "A4"}));
  EXPECT_NEAR(control.hidden, 1, 1e-9);
  EXPECT_TRUE(control.holds_the_datum());
  const MeasurementDoubtT doubt = doubt_of(control);
  EXPECT_EQ(doubt.part, MeasurementPart::datum);
  EXPECT_EQ(doubt.reason,
            "the survey hangs on anchors that are to be judged, at the coordinates of their design: A1, A4; of a shift "
            "or turn of all anchors together 100 % cannot be seen");
  EXPECT_EQ(doubt.mend, "") << "a placeholder is no command";
  EXPECT_NE(doubt.mend_note.find("frames.with.datum_sigma=0.005 where they do to 5 mm"), std::string::npos);

  OnDesign measured("weighted");
  for (int i : {0, 3})
    measured.know(measured.anchors[i].id, measured.model.positions[i] + Eigen::Vector3d(0, 0.002, -0.002));
  EXPECT_TRUE(measured.found().ids.empty()) << "3 mm from the design at 0.5 mm: somebody measured it";
  OnDesign elsewhere("weighted");
  for (int i = 0; i < 4; ++i) elsewhere.know("G" + std::to_string(i), {0, -8.0 - i, 0});
  EXPECT_TRUE(elsewhere.found().ids.empty());
  OnDesign free("inner");
  free.know("A1", free.anchors[0].design);
  EXPECT_TRUE(free.found().ids.empty()) << "nothing that was known holds a free network";
}

/// Once the same bolts were sighted as targets, too, and known as T1 and T4 where the anchors were designed.
TEST(Trust, ControlAtTheDesignedPlaceOfAnAnchorIsAFitUnderAnyName) {
  OnDesign made("weighted");
  for (const std::size_t i : {0u, 3u}) {
    const std::string name = "T" + std::to_string(i + 1);
    made.know(name, made.anchors[i].design);
    made.model.ids.push_back(name), made.model.positions.push_back(made.model.positions[i]);
  }
  const DesignedControl control = made.found();
  EXPECT_EQ(control.ids, (std::vector<std::string>{"T1 (A1)", "T4 (A4)"}));
  EXPECT_NEAR(control.hidden, 1, 1e-9);
  EXPECT_TRUE(control.holds_the_datum());
}

TEST(Trust, WhereOtherControlHoldsTheDatumOneAnchorOfTheDesignIsNoDoubt) {
  const auto hidden = [](int others) {
    OnDesign made("weighted");
    made.know("A1", made.anchors[0].design);
    for (int i = 0; i < others; ++i) made.know("G" + std::to_string(i), {0, -8.0 - i, 0});
    const DesignedControl control = made.found();
    EXPECT_EQ(control.holds_the_datum(), control.hidden > 0.1);
    return control.hidden;
  };
  EXPECT_GT(hidden(3), 0.24);
  EXPECT_NEAR(hidden(3), 0.25, 0.1);
  EXPECT_LT(hidden(39), 0.1);
}

/// Plan from the drawing and heights from the level: once no word, and a building that stood 30 mm aside was ready.
TEST(Trust, PlanAndHeightThatAreTheDesignsAreLookedAtApart) {
  const auto known = [](int copied, const Eigen::Vector3d& off, int measured = 0) {
    OnDesign made("weighted", 6);
    for (int i = 0; i < copied; ++i) made.know(made.anchors[i].id, made.anchors[i].design + off);
    for (int i = copied; i < copied + measured; ++i)
      made.know(made.anchors[i].id, made.anchors[i].design + Eigen::Vector3d(0.003, 0.002, 0.003));
    return made.found();
  };
  const DesignedControl plan = known(4, {0, 0.00004, 0.0041});
  EXPECT_TRUE(plan.holds_the_datum());
  EXPECT_NE(doubt_of(plan).reason.find("at the plan coordinates of their design: A1, A2, A3, A4"), std::string::npos)
      << doubt_of(plan).reason;
  const DesignedControl height = known(4, {0.0041, 0.003, 0});
  EXPECT_TRUE(height.holds_the_datum());
  EXPECT_NE(doubt_of(height).reason.find("at the heights of their design"), std::string::npos);
  EXPECT_TRUE(known(3, {0.0041, 0.003, 0}).ids.empty()) << "of three points heights may be right by themselves";
  EXPECT_TRUE(known(4, {0.0041, 0.003, 0}, 2).ids.empty()) << "and of four in six";
  EXPECT_EQ(known(4, {0.0001, 0, 0.0041}, 1).ids.size(), 0u) << "written in tenths, and a tenth off: measured";
  EXPECT_EQ(known(4, {0, 0, 0.0041}, 1).ids.size(), 4u);
}

/// What the link is uncertain by is in the covariance of all anchors: once control counted by number for that.
TEST(Trust, WhatTheLinkIsUncertainByHidesNothingMore) {
  FrameLink link;
  link.to = "building", link.from = "survey";
  for (int axis = 3; axis < 6; ++axis) link.covariance(axis, axis) = 0.003 * 0.003;
  OnDesign made("weighted");
  made.know("A1", made.anchors[0].design);
  for (int i = 0; i < 39; ++i) made.know("G" + std::to_string(i), {0, -8.0 - i, 0});
  EXPECT_NEAR(made.found(link).hidden, made.found().hidden, 1e-6);
  EXPECT_FALSE(made.found(link).holds_the_datum());
}

TEST(Trust, HeldControlWithTheCoordinatesOfTheDesignCountsByNumber) {
  OnDesign made("fixed");
  for (const char* id : {"A1", "A2", "G1", "G2"}) made.network.datum_points.push_back(id);
  for (int i = 0; i < 2; ++i) {
    auto point = std::make_unique<PointT>();
    point->id = made.anchors[i].id, point->position = made.anchors[i].design, point->sigma.setZero();
    made.network.points.push_back(std::move(point));
  }
  EXPECT_EQ(made.found().hidden, 0.5);
}

/// Fitted to the anchors themselves: once every anchor of a building that stood 30 mm out passed, "ready to install".
TEST(Trust, AFrameThatIsFittedToTheAnchorsIsADoubtUntilSomebodySaysWhatElseShowsIt) {
  const auto about = [](bool fitted, double sigma) {
    flatbuffers::FlatBufferBuilder made;
    TransformT transform;
    transform.origin = "fitted to 24 anchors", transform.fitted_to_design = fitted, transform.datum_sigma = sigma;
    made.Finish(Transform::Pack(made, &transform));
    const auto* packed = flatbuffers::GetRoot<Transform>(made.GetBufferPointer());
    flatbuffers::FlatBufferBuilder of_points;
    of_points.Finish(Points::Pack(of_points, std::make_unique<PointsT>().get()));
    const auto datum = fitted_datum(*flatbuffers::GetRoot<Points>(of_points.GetBufferPointer()), packed);
    if (!datum) return std::pair{std::optional<MeasurementDoubtT>(), std::string()};
    return std::pair{doubt_of_datum(*datum), about_best_fit(*datum)};
  };
  const double nan = std::nan("");
  const auto [doubt, silent] = about(true, nan);
  ASSERT_TRUE(doubt);
  EXPECT_EQ(doubt->part, MeasurementPart::datum);
  EXPECT_EQ(doubt->grade, DoubtGrade::doubt);
  EXPECT_EQ(doubt->mend, "");
  EXPECT_NE(ifc::in_words(*doubt).find("cannot be seen; to decide it, say how well other measurements (main axes, a "
                                       "benchmark) show that the whole stands as designed: "
                                       "frames.with.datum_sigma=0.005 where they do to 5 mm, 0 by agreement"),
            std::string::npos);
  EXPECT_EQ(silent, "");
  EXPECT_FALSE(about(true, 0.0).first);
  EXPECT_NE(about(true, 0.0).second.find("as agreed (datum_sigma): where the whole stands is not judged"),
            std::string::npos);
  EXPECT_NE(about(true, 0.003).second.find("known to 3.0 mm"), std::string::npos);
  EXPECT_FALSE(about(false, nan).first);
  EXPECT_EQ(about(false, nan).second, "");
}

/// Where a pipeline connects no transform the points say it themselves: once nobody did, and all passed.
TEST(Trust, PointsCarryTheMarkOfAFit) {
  PointsT points;
  points.fitted_to_design = std::make_unique<FittedDatumT>();
  points.fitted_to_design->origin = "fitted to 24 anchors";
  const auto packed_datum = [&] {
    flatbuffers::FlatBufferBuilder made;
    made.Finish(Points::Pack(made, &points));
    return fitted_datum(*flatbuffers::GetRoot<Points>(made.GetBufferPointer()), nullptr);
  };
  ASSERT_TRUE(packed_datum());
  const auto doubt = doubt_of_datum(*packed_datum());
  ASSERT_TRUE(doubt);
  EXPECT_NE(doubt->reason.find("the measurement was fitted to 24 anchors"), std::string::npos);
  points.fitted_to_design->datum_sigma = 0.003;
  EXPECT_FALSE(doubt_of_datum(*packed_datum()));
  EXPECT_NE(about_best_fit(*packed_datum()).find("known to 3.0 mm"), std::string::npos);
  points.fitted_to_design.reset();
  EXPECT_FALSE(packed_datum()) << "as points of before are read";
}

}  // namespace test_trust
}  // namespace plumbline::judgement

// A survey in a frame of its own: what is handed out is where the control is, what comes back is where the design is.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numbers>

#include "artifacts/frame_artifact.hpp"
#include "loop/exchange/vda5050.hpp"
#include "loop/job/layout_files.hpp"
#include "loop/state/machine.hpp"
#include "loop/state/plan_artifact.hpp"
#include "released.hpp"
#include "test_support.hpp"

namespace plumbline::loop {
namespace test_survey_frame {

using test::Released, test::is_valid_job;

Job released_job() {
  const Released r;
  return make_job(r.plan, r.state, 0, "", "");
}

using nlohmann::json;

/// building_from_survey, of the design's origin in the survey, the turn of the design there, and the map's scale.
FrameLink link_of(const Eigen::Vector3d& origin, double degrees, double scale) {
  FrameLink link;
  link.to = "building", link.from = "survey", link.origin = "a map", link.scale = 1 / scale, link.plan_only = true;
  const double half = -0.5 * degrees * std::numbers::pi / 180;
  link.to_from_from.rotation = Eigen::Quaterniond(std::cos(half), 0, 0, std::sin(half));
  link.to_from_from.translation = -(link.linear() * origin);
  return link;
}

/// Turned and shifted by millimetres, which no one sees, and in a map.
const std::vector<FrameLink>& links() {
  static const std::vector<FrameLink> two = {link_of({0.030, -0.045, 0.020}, 0.5, 1),
                                             link_of({500000, 5700000, 432.1}, 217, 0.9996)};
  return two;
}

TEST(SurveyFrame, AJobIsWhereTheControlIsAndSaysHowTheDesignLiesThere) {
  const Released r;
  const Job designed = make_job(r.plan, r.state, 0, "", "");
  ASSERT_FALSE(designed.items.empty());
  for (const FrameLink& link : links()) {
    const Job job = in_survey(designed, link);
    EXPECT_EQ(job.frame, "survey");
    EXPECT_EQ(job.id, designed.id) << "the state knows it by that";
    const Job back = read_job(job_json(job));
    EXPECT_EQ(job_json(back), job_json(job));
    ASSERT_TRUE(back.building_from_job);
    for (std::size_t i = 0; i < back.items.size(); ++i) {
      const JobItem &here = back.items[i], &there = designed.items[i];
      EXPECT_LT(here.target.head<2>().norm(), 1500) << "the large offset is the frame's";
      EXPECT_LT((link.apply(here.target + back.origin) - there.target - designed.origin).norm(), 3e-9);
      EXPECT_LT((back.building_from_job->apply(here.design) - there.design - designed.origin).norm(), 3e-9);
      EXPECT_LT((link.to_from_from.rotation * here.target_rotation).angularDistance(there.target_rotation), 1e-12);
      EXPECT_EQ(here.setting, there.setting) << "along the bracket's own axes";
    }
  }
}

TEST(SurveyFrame, AJobWithoutHowItsFrameLiesIsNone) {
  const Released r;
  json job = json::parse(job_json(in_survey(make_job(r.plan, r.state, 0, "", ""), links()[0])));
  EXPECT_TRUE(is_valid_job(job));
  json without = job;
  without["frames"][0].erase("buildingFromFrame");
  EXPECT_FALSE(is_valid_job(without));
  EXPECT_THROW(read_job(without.dump()), std::runtime_error);
  json both = job;
  both["frames"][0]["name"] = "building";
  for (auto& item : both["items"]) item["frame"] = "building";
  EXPECT_FALSE(is_valid_job(both));
  EXPECT_THROW(read_job(both.dump()), std::runtime_error);
}

/// What the link is uncertain by, as any point there has it: the design's origin may be far away.
TEST(SurveyFrame, TheCovarianceIsThatOfThePlaceAtTheJobsOrigin) {
  FrameLink link = links()[1];
  const Eigen::Vector3d far = link.to_from_from.translation;  // a turn of 1e-5 about the survey's origin moves all
  Eigen::Matrix<double, 6, 4> rows = Eigen::Matrix<double, 6, 4>::Zero();
  rows(2, 0) = -1, rows.block<3, 1>(3, 0) = Eigen::Vector3d(far.y(), -far.x(), 0);
  rows.block<3, 3>(3, 1) = -link.linear();
  const Eigen::Vector4d sigmas(1e-5, 0.002, 0.002, 0.001);
  link.covariance.topLeftCorner<6, 6>() = rows * sigmas.cwiseAbs2().asDiagonal() * rows.transpose();
  const Job job = read_job(job_json(in_survey(released_job(), link)));
  FrameGraph graph;
  graph.add(link);
  const FramePoints at = graph.express({{job.origin}, Eigen::MatrixXd::Zero(3, 3)}, "building", "survey");
  const Eigen::Matrix3d place = job.building_from_job->covariance.block<3, 3>(3, 3);
  EXPECT_LT((place - at.covariance).norm(), 1e-9);
  EXPECT_NEAR(std::sqrt(place(2, 2)), 0.001, 1e-6);
  EXPECT_LT(std::sqrt(place(0, 0)), 0.02) << "not the 57 m of the survey's origin";
  EXPECT_NEAR(std::sqrt(job.building_from_job->covariance(2, 2)), 1e-5, 1e-9);
}

TEST(SurveyFrame, StakedPointsComeBackToTheDesign) {
  const Released r;
  const Job designed = make_job(r.plan, r.state, 0, "", "");
  for (const FrameLink& link : links()) {
    const auto points = layout_points(in_survey(designed, link));
    ASSERT_EQ(points.size(), layout_points(designed).size());
    for (const LayoutFormat format : {LayoutFormat::hilti, LayoutFormat::trimble, LayoutFormat::leica}) {
      const ActualsT back = read_staked(layout_csv(points, format), format, "staked.csv", link);
      ASSERT_EQ(back.items.size(), points.size());
      for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_LT((back.items[i]->measured - layout_points(designed)[i].position).norm(), 1e-4);
    }
    const ActualsT lost = read_staked(layout_csv(points, LayoutFormat::hilti), LayoutFormat::hilti, "staked.csv");
    EXPECT_GT((lost.items[0]->measured - layout_points(designed)[0].position).norm(), 0.03);
  }
}

/// Places of a drawing, by its group codes.
std::vector<Eigen::Vector3d> places_of(const std::string& dxf) {
  std::vector<Eigen::Vector3d> places;
  std::istringstream lines(dxf);
  Eigen::Vector3d at;
  for (std::string code, value; std::getline(lines, code) && std::getline(lines, value);) {
    if (code == "10") at.x() = std::stod(value);
    if (code == "20") at.y() = std::stod(value);
    if (code == "30") at.z() = std::stod(value), places.push_back(at);
  }
  return places;
}

TEST(SurveyFrame, ADrawingHasPanelsBracketsAndControlInOne) {
  const Released r;
  const auto designed = places_of(layout_dxf(r.plan, make_job(r.plan, r.state, 0, "", ""), {}));
  for (const FrameLink& link : links()) {
    const auto drawn = places_of(layout_dxf(r.plan, in_survey(make_job(r.plan, r.state, 0, "", ""), link), {}, link));
    ASSERT_EQ(drawn.size(), designed.size());
    for (std::size_t i = 0; i < drawn.size(); ++i)
      if (!designed[i].isZero(0)) {  // the head of a polyline has no place
        EXPECT_LT((link.apply(drawn[i]) - designed[i]).norm(), 2e-4) << i;
      }
  }
}

TEST(SurveyFrame, AReportSaysItsFrameWhereThereAreTwo) {
  const FrameLink& link = links()[1];
  const Eigen::Vector3d in_survey_frame(500003, 5700002, 440), in_building = link.apply(in_survey_frame);
  const auto read = [&](const std::string& file, const std::string& entry, const Eigen::Vector3d& p,
                        const SurveyLink& survey) {
    return read_actuals_json("{" + file + R"("items": [{"item": "A", "outcome": "done", "measured": [)" +
                                 std::to_string(p.x()) + "," + std::to_string(p.y()) + "," + std::to_string(p.z()) +
                                 R"(], "sigma": [0.001, 0.002, 0.003])" + entry + "}]}",
                             "a.json", survey);
  };
  for (const auto& [file, entry] : {std::pair(R"("frame": "survey", )", ""), std::pair("", R"(, "frame": "survey")")}) {
    const ActualsT said = read(file, entry, in_survey_frame, link);
    ASSERT_EQ(said.items.size(), 1u);
    EXPECT_LT((said.items[0]->measured - in_building).norm(), 1e-6);
    EXPECT_NEAR(said.items[0]->sigma.z(), 0.003, 1e-12);
    EXPECT_NEAR(said.items[0]->sigma.head<2>().norm(), std::hypot(0.001, 0.002) / 0.9996, 1e-9);
  }
  EXPECT_LT(
      (read("", R"(, "frame": "building")", {1, 2, 3}, link).items.at(0)->measured - Eigen::Vector3d(1, 2, 3)).norm(),
      1e-9);
  const ActualsT mute = read("", "", in_survey_frame, link);
  EXPECT_TRUE(mute.items.empty());
  EXPECT_NE(mute.refused.at(0).find("a.json: items[0]: 'measured' is in a frame that is not said"), std::string::npos)
      << mute.refused.at(0);
  // One frame has two names.
  for (const char* entry : {"", R"(, "frame": "survey")", R"(, "frame": "building")"})
    EXPECT_EQ(read("", entry, {1, 2, 3}, {}).items.at(0)->measured, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(read_actuals_json(R"({"items": [{"item": "A", "outcome": "done"}]})", "a.json", link).items.size(), 1u);
}

TEST(SurveyFrame, OrdersAreInTheJobsFrameAndWhatRobotsAnswerComesBack) {
  const Released r;
  const Job designed = make_job(r.plan, r.state, 0, "", "");
  for (const FrameLink& link : links()) {
    const Job job = in_survey(designed, link);
    const VdaRobot robot{VdaVersion::v2_0, "Acme", "R2D2", 7, "2026-05-02T08:00:00Z", std::nullopt};
    const json order = json::parse(vda_order(job, robot));
    std::map<std::string, json> parameters;
    for (const json& one : order["nodes"][0]["actions"][0]["actionParameters"]) parameters[one["key"]] = one["value"];
    EXPECT_EQ(parameters.at("frame"), "survey");
    const json& p = parameters.at("targetPosition");
    const Eigen::Vector3d target(p[0], p[1], p[2]);
    EXPECT_LT((link.apply(target) - designed.items[0].target - designed.origin).norm(), 3e-9);
    const Eigen::Vector2d out = (job.items[0].design_rotation * Eigen::Vector3d::UnitZ()).head<2>().normalized();
    const double stand = (job.items[0].design + job.origin).x() + robot.stand_off * out.x();
    EXPECT_NEAR(order["nodes"][0]["nodePosition"]["x"].get<double>(), stand, 1e-9);
    const json result = {{"measured", p}, {"frame", "survey"}};
    const json state = {{"headerId", 1},
                        {"timestamp", "2026-05-02T09:00:00Z"},
                        {"version", "2.0.0"},
                        {"manufacturer", "Acme"},
                        {"serialNumber", "R2D2"},
                        {"orderId", job.id},
                        {"actionStates",
                         {{{"actionId", vda_action_id(job, job.items[0])},
                           {"actionStatus", "FINISHED"},
                           {"resultDescription", result.dump()}}}}};
    const ActualsT back = vda_actuals(state.dump(), job, "states.jsonl", link);
    ASSERT_EQ(back.items.size(), 1u) << (back.refused.empty() ? "" : back.refused[0]);
    EXPECT_LT((back.items[0]->measured - designed.items[0].target - designed.origin).norm(), 3e-9);
    EXPECT_THROW(vda_actuals(state.dump(), job, "states.jsonl"), std::runtime_error);
    EXPECT_EQ(vda_actuals(state.dump(), designed, "states.jsonl", link).items.size(), 0u) << "it says another frame";
  }
}

/// A copied target proves nothing, whichever frame it was copied in.
TEST(SurveyFrame, ACopiedTargetShowsNoPanel) {
  const FrameLink& link = links()[1];
  const auto is_seen = [&](const Eigen::Vector3d& off, double step) {
    LoopStateT state;
    state.items.push_back(std::make_unique<LoopItemT>());
    LoopItemT& panel = *state.items[0];
    panel.id = "p", panel.kind = "panel", panel.status = ItemStatus::released, panel.revision = 1;
    panel.expected = {1.23456789, 2.3456789, 3.456789};
    const Eigen::Vector3d target = link.apply_inverse(panel.expected) + off;
    ActualsT reports;
    reports.items.push_back(std::make_unique<ActualT>());
    ActualT& report = *reports.items[0];
    report.item = "p", report.outcome = "done", report.revision = 1, report.by = "robot";
    report.sigma.setConstant(std::nan("")), report.setting.setConstant(std::nan(""));
    report.measured = step > 0 ? Eigen::Vector3d(step * (target / step).array().round()) : target;
    bring_to_building(report, link);
    apply_actuals(state, reports);
    return state.items[0]->seen;
  };
  for (const double step : {0.0, 1e-4, 1e-3}) {
    EXPECT_FALSE(is_seen({0, 0, 0}, step)) << step;
    EXPECT_TRUE(is_seen({0.002, 0, 0.001}, step)) << step;
  }
}

/// In whole millimetres a place that was measured is often the target's own number; once a good one was taken for a
/// copy if it was within 0.87 mm. The report as a whole tells.
TEST(SurveyFrame, InWholeMillimetresTheWholeReportTellsWhatWasCopied) {
  const auto seen = [&](const std::vector<Eigen::Vector3d>& off, const SurveyLink& survey, std::size_t panels = 9) {
    LoopStateT state;
    ActualsT reports;
    reports.sources = {"a.csv"};
    for (std::size_t i = 0; i < off.size(); ++i) {
      state.items.push_back(std::make_unique<LoopItemT>());
      LoopItemT& panel = *state.items.back();
      panel.id = "p" + std::to_string(i), panel.kind = i < panels ? "panel" : "bracket";
      panel.status = ItemStatus::released, panel.revision = 1;
      panel.expected = Eigen::Vector3d(1.23456789 + 2 * static_cast<double>(i), 2.3456789, 3.456789);
      const Eigen::Vector3d target = survey ? survey->apply_inverse(panel.expected) : panel.expected;
      auto report = std::make_unique<ActualT>();
      report->item = panel.id, report->outcome = "done", report->revision = 1;
      report->source = "a.csv:" + std::to_string(i);
      report->sigma.setConstant(std::nan("")), report->setting.setConstant(std::nan(""));
      report->measured = 1e-3 * (1e3 * (1e-3 * (1e3 * target).array().round().matrix() + off[i])).array().round();
      bring_to_building(*report, survey);
      reports.items.push_back(std::move(report));
    }
    std::vector<std::string> doubted;
    apply_actuals(state, reports, &doubted);
    for (const std::string& words : doubted)
      EXPECT_NE(words.find("is the number that was asked for, in whole millimetres"), std::string::npos) << words;
    return state.items.size() - doubted.size();
  };
  const Eigen::Vector3d same(0, 0, 0), beside(-0.001, 0, 0);
  for (const SurveyLink& survey : {SurveyLink(), SurveyLink(links()[1])}) {
    EXPECT_EQ(seen({same}, survey), 0u);
    EXPECT_EQ(seen({beside}, survey), 1u) << "within a millimetre of the target, and no copy of it";
    EXPECT_EQ(seen({same, same, beside}, survey), 1u) << "copied, but for one";
    EXPECT_EQ(seen({same, beside, beside}, survey), 3u) << "measured, and one is just right";
    EXPECT_EQ(seen({same, same, beside, beside}, survey, 2), 2u) << "brackets that were set say nothing of panels";
    EXPECT_EQ(seen({same, same}, survey, 1), 1u) << "of brackets nothing is doubted";
  }
}

TEST(SurveyFrame, OneFrameIsNoLinkAndOneThatLeansIsRefused) {
  EXPECT_FALSE(survey_link(transform_artifact(link_of({0, 0, 0}, 0, 1))));
  EXPECT_TRUE(survey_link(transform_artifact(links()[0])));
  FrameLink leans = links()[0];
  leans.plan_only = false;
  leans.to_from_from.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(0.001, Eigen::Vector3d::UnitX()));
  EXPECT_THROW(survey_link(transform_artifact(leans)), std::runtime_error);
}

}  // namespace test_survey_frame
}  // namespace plumbline::loop

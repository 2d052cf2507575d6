// Jobs out, reports in.
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "loop/job/job.hpp"
#include "loop/state/machine.hpp"
#include "loop/state/plan_artifact.hpp"
#include "random_facade.hpp"
#include "released.hpp"
#include "released_far_off.hpp"
#include "test_support.hpp"

namespace plumbline::loop {
namespace test_job {

using nlohmann::json;
using test::ReleasedFarOff;

std::string fault_of(const json& document) {
  try {
    read_job(document.dump());
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

TEST(Job, ComesBackAsItWasWritten) {
  const ReleasedFarOff r;
  const Job job = make_job(r.plan, r.state, 1, "2026-05-02T08:00:00Z", "2026-05-03T08:00:00Z");
  ASSERT_FALSE(job.items.empty());
  const std::string text = job_json(job);
  EXPECT_TRUE(test::is_valid_job(json::parse(text)));
  const Job back = read_job(text);
  EXPECT_EQ(job_json(back), text);
  EXPECT_EQ(back.origin, Eigen::Vector3d(432000, 5812000, 0));
  for (const JobItem& item : back.items) {
    EXPECT_LT(item.design.head<2>().cwiseAbs().maxCoeff(), 1000);
    // Design plus as-built deviation plus setting is the target, to the last digit that matters.
    EXPECT_LT((item.target - item.design).norm(), 0.03);
  }
}

/// Both facades, every panel released as it would be when its brackets are verified.
struct TwoFacades {
  InstallationPlanT plan;
  LoopStateT state;
  TwoFacades() {
    TowerOptions options{1, 1};
    options.facades = 2;
    const Facade facade = test::random_facade(options, 4, 0.002, 0.0003, 0.0004);
    const Fit fit = plan_settings(facade);
    plan = plan_artifact(facade, fit, judge_plan(facade, fit));
    apply_plan(state, plan, {});
    for (auto& item : state.items) item->status = ItemStatus::released, item->revision = 1;
  }
};

TEST(Job, EachPanelHasTheOrientationOfItsOwnFacade) {
  const TwoFacades two;
  const json orders = json::parse(job_json(make_job(two.plan, two.state, 0, "", "")));
  std::map<std::string, Eigen::Vector3d> out;
  for (const auto& item : orders["items"]) {
    const auto& q = item["designPose"]["orientation"];
    out[item["id"]] = Eigen::Quaterniond(q[3], q[0], q[1], q[2]) * Eigen::Vector3d::UnitZ();
  }
  EXPECT_LT((out.at("F01-P01") + Eigen::Vector3d::UnitY()).norm(), 1e-9);
  EXPECT_LT((out.at("EF01-P01") - Eigen::Vector3d::UnitX()).norm(), 1e-9);
  EXPECT_LT((out.at("EF01-C01-R1") - Eigen::Vector3d::UnitX()).norm(), 1e-9);
}

TEST(Job, APanelThatIsNotGoOrFacesNobodyKnowsWhereIsNoJob) {
  TwoFacades two;
  two.plan.panels[0]->gate = GateDecision::hold;
  EXPECT_THROW(make_job(two.plan, two.state, 0, "", ""), std::runtime_error);
  two.plan.panels[0]->gate = GateDecision::go, two.plan.panels[0]->corners.clear();
  EXPECT_THROW(make_job(two.plan, two.state, 0, "", ""), std::runtime_error);
}

TEST(Job, AnotherContentIsAnotherJobAndReleasedItemsKnowTheirs) {
  ReleasedFarOff r;
  const std::string before = make_job(r.plan, r.state, 1, "2026-05-02T08:00:00Z", "").id;
  EXPECT_EQ(make_job(r.plan, r.state, 1, "2026-05-02T09:00:00Z", "").id, before);
  note_jobs(r.plan, r.state);
  for (const auto& item : r.state.items) {
    if (item->status != ItemStatus::released) continue;
    EXPECT_EQ(std::count(item->jobs.begin(), item->jobs.end(), before), 1) << item->id;
    item->pending.z() += 0.001;
  }
  EXPECT_NE(make_job(r.plan, r.state, 1, "", "").id, before);
}

TEST(Job, OnlyWhatIsReleasedIsInIt) {
  ReleasedFarOff r;
  for (const JobItem& item : make_job(r.plan, r.state, 0, "", "").items) EXPECT_EQ(item.floor, 1);
  recall(r.state, {}, "control moved");
  EXPECT_TRUE(make_job(r.plan, r.state, 0, "", "").items.empty());
  r.state.basis = "another";
  EXPECT_THROW(make_job(r.plan, r.state, 0, "", ""), std::runtime_error);
}

TEST(Job, WhatIsWrongIsNamedAndFailsTheSchema) {
  const ReleasedFarOff r;
  const json good = json::parse(job_json(make_job(r.plan, r.state, 0, "2026-05-02T08:00:00Z", "")));
  const auto broken = [&](auto&& change) {
    json document = good;
    change(document);
    EXPECT_FALSE(test::is_valid_job(document)) << document.dump().substr(0, 200);
    return fault_of(document);
  };
  EXPECT_EQ(broken([](json& j) { j.erase("revision"); }), "job: the file lacks 'revision'");
  EXPECT_EQ(broken([](json& j) { j["units"]["length"] = "ft"; }), "job: units.length is \"ft\", expected m");
  EXPECT_EQ(broken([](json& j) { j["items"][0]["gate"]["verdict"] = "HOLD"; }),
            "job: items[0].gate.verdict is \"HOLD\", expected GO");
  EXPECT_EQ(broken([](json& j) {
              j["items"][0]["targetPose"]["orientation"] = {0, 0, 1};
            }),
            "job: items[0].targetPose.orientation is [0,0,1], expected a quaternion x, y, z, w");
  EXPECT_EQ(broken([](json& j) { j["items"][0].erase("setting"); }), "job: items[0] lacks 'setting'");
  EXPECT_EQ(broken([](json& j) { j["items"][0]["toleranceZone"]["up"] = 0; }).substr(0, 40),
            "job: items[0].toleranceZone.up is 0, exp");
  EXPECT_EQ(broken([](json& j) { j["items"][0]["kind"] = "window"; }),
            "job: items[0].kind is \"window\", expected bracket or panel");
}

TEST(Job, WhatNoSchemaSeesIsNamedToo) {
  const ReleasedFarOff r;
  const json good = json::parse(job_json(make_job(r.plan, r.state, 0, "", "")));
  json twice = good;
  twice["items"].push_back(twice["items"][0]);
  EXPECT_NE(fault_of(twice).find("occurs twice"), std::string::npos);
  json circle = good;
  circle["items"][0]["dependsOn"] = {good["items"][1]["id"]},
  circle["items"][1]["dependsOn"] = {good["items"][0]["id"]};
  EXPECT_NE(fault_of(circle).find("dependsOn goes in a circle"), std::string::npos);
  json far = good;
  far["items"][0]["targetPose"]["position"][0] = good["items"][0]["targetPose"]["position"][0].get<double>() / 0.3048;
  EXPECT_NE(fault_of(far).find("from its design; expected 0.5 m or less"), std::string::npos);
  EXPECT_EQ(fault_of("nonsense"), "job: the file is \"nonsense\", expected an object");
}

/// A drill that knows a part of what it is told does not drill.
TEST(Job, WhatNobodyReadsIsNotCarriedOut) {
  const ReleasedFarOff r;
  const json good = json::parse(job_json(make_job(r.plan, r.state, 0, "", "")));
  const auto changed = [&](auto&& change) {
    json document = good;
    change(document);
    EXPECT_FALSE(test::is_valid_job(document)) << document.dump().substr(0, 200);
    return fault_of(document);
  };
  EXPECT_EQ(changed([](json& j) { j["validUntill"] = "2026-05-03T08:00:00Z"; }),
            "job: the file has 'validUntill', which is no key; 'validUntil' is");
  EXPECT_EQ(changed([](json& j) { j["items"][0]["mirror"] = true; }),
            "job: items[0] has 'mirror', which is no key: what it asks for would not be done");
  EXPECT_EQ(changed([](json& j) { j["items"][0]["setting"]["turn"] = 0.1; }).substr(0, 36),
            "job: items[0].setting has 'turn', wh");
  EXPECT_EQ(changed([](json& j) { j["units"]["mass"] = "kg"; }).substr(0, 25), "job: units has 'mass', wh");
  EXPECT_EQ(changed([](json& j) { j["assumedRobot"]["reach"] = 2; }).substr(0, 32), "job: assumedRobot has 'reach', w");
  json turned = good;
  turned["frames"][0]["orientation"] = {0, 0, 1, 0};
  EXPECT_NE(fault_of(turned).find("the root frame is not turned"), std::string::npos) << fault_of(turned);
  json other = good;
  other["items"][0]["revision"] = 7;
  EXPECT_NE(fault_of(other).find("is of revision 7, its job of 1: it is of another job"), std::string::npos)
      << fault_of(other);
  for (const char* place : {"/jobId", "/items/0/id"}) {
    json nameless = good;
    nameless[json::json_pointer(place)] = "";
    EXPECT_NE(fault_of(nameless).find("is \"\", expected a name"), std::string::npos) << fault_of(nameless);
  }
  json zones = good;
  zones["items"][0]["forbiddenZones"] = {{{"centre", {0, 0, 0}}, {"halfWidths", {0.1, 0.1, 0.1}}}};
  EXPECT_TRUE(test::is_valid_job(zones)) << "others may write them";
  EXPECT_NE(fault_of(zones).find("does not keep a tool out of zones"), std::string::npos) << fault_of(zones);
}

TEST(Job, AnOldOneIsRefused) {
  const ReleasedFarOff r;
  Job job = make_job(r.plan, r.state, 0, "2026-05-02T08:00:00Z", "2026-05-03T08:00:00Z");
  EXPECT_TRUE(job_objections(job, 1, "2026-05-02T12:00:00Z", job.basis).empty());
  const auto all = job_objections(job, 4, "2026-05-04T12:00:00Z", std::string(64, 'a'));
  ASSERT_EQ(all.size(), 3u);
  EXPECT_NE(all[0].find("revision 4 is out: fetch that one"), std::string::npos) << all[0];
  EXPECT_NE(all[1].find("was valid until 2026-05-03T08:00:00Z"), std::string::npos) << all[1];
  // In whatever zone it is said.
  EXPECT_TRUE(job_objections(job, 1, "2026-05-03T09:59:59+02:00", job.basis).empty());
  EXPECT_EQ(job_objections(job, 1, "2026-05-03T10:00:01+02:00", job.basis).size(), 1u);
  // Where the clock is behind nobody knows when that is.
  EXPECT_TRUE(job_objections(job, 1, "2026-05-02T07:56:00Z", job.basis).empty()) << "clocks differ by minutes";
  EXPECT_NE(job_objections(job, 1, "2025-05-02T12:00:00Z", job.basis).at(0).find("by the clock of this machine"),
            std::string::npos);
  job.created_at = job.valid_until;
  EXPECT_NE(job_objections(job, 1, "2026-05-02T12:00:00Z", job.basis).at(0).find("and was made later, at"),
            std::string::npos);
  job.created_at = "yesterday";
  EXPECT_NE(job_objections(job, 1, "2026-05-02T12:00:00Z", job.basis).at(0).find("was made at 'yesterday', expected"),
            std::string::npos);
  job.created_at.clear();
  job.valid_until = "next Tuesday";
  EXPECT_NE(job_objections(job, 1, "2026-05-02T12:00:00Z", job.basis)
                .at(0)
                .find("is valid until 'next Tuesday', expected ISO 8601 with a zone"),
            std::string::npos);
  job.valid_until.clear();
  EXPECT_TRUE(job_objections(job, 1, "2027-05-02T12:00:00Z", job.basis).empty()) << "nobody said until when";
  EXPECT_NE(job_objections(job, 1, "noon", job.basis).at(0).find("the date of today, 'noon', is none"),
            std::string::npos);
}

}  // namespace test_job
}  // namespace plumbline::loop

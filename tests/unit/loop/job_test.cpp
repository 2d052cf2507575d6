// Jobs out, reports in.
#include "loop/job/job.hpp"

#include <gtest/gtest.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "loop/job/layout_files.hpp"
#include "loop/job/signature.hpp"
#include "loop/state/machine.hpp"
#include "loop/state/plan_artifact.hpp"
#include "random_facade.hpp"
#include "released.hpp"
#include "test_support.hpp"

namespace plumbline::loop {
namespace job_test {

using nlohmann::json;

/// A plan with its state after the first release.
struct Released {
  InstallationPlanT plan;
  LoopStateT state;
  Released() {
    Facade facade = test::random_facade({2, 2}, 4, 0.004, 0.0003, 0.0004);
    for (Bracket& bracket : facade.brackets) bracket.design += Eigen::Vector3d(432100, 5812300, 30);
    for (Panel& panel : facade.panels) {
      panel.centre += Eigen::Vector3d(432100, 5812300, 30);
      for (auto& corner : panel.corners) corner += Eigen::Vector3d(432100, 5812300, 30);
    }
    for (Joint& joint : facade.joints)
      for (auto* places : {&joint.on_a, &joint.on_b})
        for (auto& place : *places) place += Eigen::Vector3d(432100, 5812300, 30);
    const Fit fit = plan_settings(facade);
    plan = plan_artifact(facade, fit, judge_plan(facade, fit));
    apply_plan(state, plan, {});
  }
};

std::string fault_of(const json& document) {
  try {
    read_job(document.dump());
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

TEST(Job, ComesBackAsItWasWritten) {
  const Released r;
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
  Released r;
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
  Released r;
  for (const JobItem& item : make_job(r.plan, r.state, 0, "", "").items) EXPECT_EQ(item.floor, 1);
  recall(r.state, {}, "control moved");
  EXPECT_TRUE(make_job(r.plan, r.state, 0, "", "").items.empty());
  r.state.basis = "another";
  EXPECT_THROW(make_job(r.plan, r.state, 0, "", ""), std::runtime_error);
}

TEST(Job, WhatIsWrongIsNamedAndFailsTheSchema) {
  const Released r;
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
  const Released r;
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
  const Released r;
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
  json zones = good;
  zones["items"][0]["forbiddenZones"] = {{{"centre", {0, 0, 0}}, {"halfWidths", {0.1, 0.1, 0.1}}}};
  EXPECT_TRUE(test::is_valid_job(zones)) << "others may write them";
  EXPECT_NE(fault_of(zones).find("does not keep a tool out of zones"), std::string::npos) << fault_of(zones);
}

TEST(Job, AnOldOneIsRefused) {
  const Released r;
  Job job = make_job(r.plan, r.state, 0, "2026-05-02T08:00:00Z", "2026-05-03T08:00:00Z");
  EXPECT_TRUE(job_objections(job, 1, "2026-05-02T12:00:00Z", job.basis).empty());
  const auto all = job_objections(job, 4, "2026-05-04T12:00:00Z", std::string(64, 'a'));
  ASSERT_EQ(all.size(), 3u);
  EXPECT_NE(all[0].find("revision 4 is out: fetch that one"), std::string::npos) << all[0];
  EXPECT_NE(all[1].find("was valid until 2026-05-03T08:00:00Z"), std::string::npos) << all[1];
  // In whatever zone it is said.
  EXPECT_TRUE(job_objections(job, 1, "2026-05-03T09:59:59+02:00", job.basis).empty());
  EXPECT_EQ(job_objections(job, 1, "2026-05-03T10:00:01+02:00", job.basis).size(), 1u);
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

std::string pem(EVP_PKEY* key, bool is_private) {
  BIO* memory = BIO_new(BIO_s_mem());
  if (is_private)
    PEM_write_bio_PrivateKey(memory, key, nullptr, nullptr, 0, nullptr, nullptr);
  else
    PEM_write_bio_PUBKEY(memory, key);
  char* data = nullptr;
  const long size = BIO_get_mem_data(memory, &data);
  std::string text(data, static_cast<std::size_t>(size));
  BIO_free(memory);
  return text;
}

TEST(Signature, HoldsForTheseBytesAndThisKeyOnly) {
  EVP_PKEY* key = EVP_PKEY_Q_keygen(nullptr, nullptr, "ED25519");
  EVP_PKEY* other = EVP_PKEY_Q_keygen(nullptr, nullptr, "ED25519");
  const std::string job = "{\"jobId\": \"job-1\"}", signature = sign_bytes(job, pem(key, true));
  EXPECT_EQ(signature_fault(job, signature, pem(key, false)), "");
  EXPECT_NE(signature_fault(job + " ", signature, pem(key, false)).find("the job was changed"), std::string::npos);
  EXPECT_NE(signature_fault(job, signature, pem(other, false)), "");
  EXPECT_NE(signature_fault(job, "", pem(key, false)).find("carries no signature"), std::string::npos);
  EXPECT_NE(signature_fault(job, signature.substr(1), pem(key, false)).find("has 63 bytes"), std::string::npos);
  EXPECT_THROW(sign_bytes(job, pem(key, false)), std::runtime_error);
  EVP_PKEY_free(key), EVP_PKEY_free(other);
}

TEST(LayoutFiles, AreReadBackAsTheyWereWritten) {
  const Released r;
  const auto points = layout_points(make_job(r.plan, r.state, 0, "", ""));
  ASSERT_FALSE(points.empty());
  for (const LayoutFormat format : {LayoutFormat::hilti, LayoutFormat::trimble, LayoutFormat::leica}) {
    const ActualsT back = read_staked(layout_csv(points, format), format, "staked.csv");
    ASSERT_EQ(back.items.size(), points.size());
    EXPECT_TRUE(back.refused.empty());
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_EQ(back.items[i]->item, points[i].name);
      EXPECT_LT((back.items[i]->measured - points[i].position).cwiseAbs().maxCoeff(), 5.1e-5);
    }
  }
}

/// A tool stakes whatever is in its file: a bracket that waits or stands already would be set once more.
TEST(LayoutFiles, HoldWhatTheJobSetsAndNothingElse) {
  Released r;
  const auto named = [](const std::vector<LayoutPoint>& points) {
    std::set<std::string> names;
    for (const LayoutPoint& point : points) names.insert(point.name);
    return names;
  };
  std::string waits, stands;
  for (auto& item : r.state.items) {
    if (item->kind != "bracket" || item->status != ItemStatus::released) continue;
    if (waits.empty())
      waits = item->id, item->status = ItemStatus::planned;
    else if (stands.empty())
      stands = item->id, item->status = ItemStatus::verified;
  }
  ASSERT_FALSE(stands.empty());
  const Job job = make_job(r.plan, r.state, 0, "", "");
  std::set<std::string> of_job;
  for (const JobItem& item : job.items) of_job.insert(item.id);
  const auto points = layout_points(job);
  ASSERT_FALSE(points.empty());
  EXPECT_EQ(named(points), of_job);
  EXPECT_LT(points.size(), r.plan.brackets.size());
  EXPECT_FALSE(named(points).contains(waits) || named(points).contains(stands));
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LT((points[i].position - job.items[i].target - job.origin).norm(), 1e-9) << "the place that the job says";
  const std::string dxf = layout_dxf(r.plan, job, {});
  EXPECT_EQ(dxf.find("\n" + waits + "\n"), std::string::npos);
  EXPECT_EQ(dxf.find("\n" + stands + "\n"), std::string::npos);
  EXPECT_NE(dxf.find("\n" + points[0].name + "\n"), std::string::npos);
  // Of two floors the upper one's turn has not come.
  std::size_t outlines = 0;
  for (std::size_t at = 0; (at = dxf.find("POLYLINE", at)) != std::string::npos; ++at) ++outlines;
  EXPECT_EQ(outlines, 2u);
  EXPECT_TRUE(layout_points(make_job(r.plan, r.state, 2, "", "")).empty());
}

TEST(LayoutFiles, AHeadSaysWhichColumnIsWhat) {
  const auto place = [](const std::string& text, LayoutFormat format) {
    const ActualsT back = read_staked(text, format, "staked.csv");
    return back.items.size() == 1 ? back.items[0]->measured : Eigen::Vector3d::Zero().eval();
  };
  const Eigen::Vector3d p(401.25, 77.5, 12.125);
  EXPECT_EQ(place("A;401,25;77,5;12,125\n", LayoutFormat::hilti), p);
  EXPECT_EQ(place("A,77.5,401.25,12.125,GO\n", LayoutFormat::trimble), p);
  EXPECT_EQ(place("Name,Easting,Northing,Elev\nA,401.25,77.5,12.125\n", LayoutFormat::trimble), p);
  EXPECT_EQ(place("PtID;Code;N [m];E [m];Höhe\nA;x;77.5;401.25;12.125\n", LayoutFormat::hilti), p);
  // What X and Y are nobody says: the tool's own order counts.
  EXPECT_EQ(place("PtID,X,Y,Z\nA,401.25,77.5,12.125\n", LayoutFormat::leica), p);
  EXPECT_EQ(read_staked("PtID,E,N,H,Timestamp\nA,1,2,3,2026-05-02T08:00:00Z\n", LayoutFormat::leica, "s").items[0]->at,
            "2026-05-02T08:00:00Z");
  EXPECT_THROW(read_staked("PtID;E [mm];N [mm];H [mm]\nA;1;2;3\n", LayoutFormat::hilti, "s"), std::runtime_error);
  EXPECT_THROW(read_staked("Name,Northing (usft),Easting (usft),Elev (usft)\n", LayoutFormat::trimble, "s"),
               std::runtime_error);
  // "Ortho" is no name of a height that is known: then north and east would be taken for each other.
  EXPECT_THROW(read_staked("PtID;N;E;Ortho\nA;77.5;401.25;12.125\n", LayoutFormat::hilti, "s"), std::runtime_error);
  EXPECT_EQ(place("PtID;E;N;Ortho\nA;401.25;77.5;12.125\n", LayoutFormat::hilti), p);
}

TEST(LayoutFiles, ColumnsThatNobodyReadsAreNamed) {
  const auto ignored = [](const std::string& text) {
    const ActualsT back = read_staked(text, LayoutFormat::hilti, "s.csv");
    EXPECT_EQ(back.items.size(), 1U);
    std::string words;
    for (const std::string& line : back.ignored) words += line + "\n";
    return words;
  };
  EXPECT_EQ(ignored("PtID;E;N;H;Code;Timestamp\nA;1;2;3;x;\n"), "");
  EXPECT_EQ(ignored("A;1;2;3\n"), "");
  EXPECT_EQ(ignored("PtID;E;N;H;Remark;Setting\nA;1;2;3;bolt stuck;0.004\n"),
            "s.csv: 'Remark' and 'Setting' are not read\n");
  EXPECT_NE(ignored("PtID;Grid E;Grid N;Grid H\nA;1;2;3\n")
                .find("what its column 'Grid E' is nobody knows here; it is taken for the easting"),
            std::string::npos);
  // Where it was to be and where it is: the first would be an echo of the design.
  EXPECT_THROW(ignored("PtID;E;N;H;East;North;Height\nA;1;2;3;4;5;6\n"), std::runtime_error);
}

/// Machine control exports put comments before their head: easting and northing were exchanged then.
TEST(LayoutFiles, AHeadMayStandBehindComments) {
  const std::string begin = "# Export, Trimble compatible CSV\n# Format: Name,Easting,Northing,Elevation,Code\n",
                    date = "# Points: 1\n\n",
                    points = "Name,Easting,Northing,Elevation,Code,Description\nA,401.25,77.5,12.125,GO,\n\n# End\n";
  const ActualsT back = read_staked(begin + "# Units: metres\n" + date + points, LayoutFormat::trimble, "staked.csv");
  ASSERT_EQ(back.items.size(), 1u);
  EXPECT_TRUE(back.refused.empty());
  EXPECT_EQ(back.items[0]->measured, Eigen::Vector3d(401.25, 77.5, 12.125));
  EXPECT_EQ(read_staked("# Topcon\nPoint ID,E,N,EL,Code\nA,1,2,3,\n", LayoutFormat::trimble, "s").items.at(0)->measured,
            Eigen::Vector3d(1, 2, 3));
  try {
    read_staked(begin + "# Units: US survey feet\n" + date + points, LayoutFormat::trimble, "staked.csv");
    ADD_FAILURE() << "feet are taken for metres";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("staked.csv:3: its units are 'us survey feet'"), std::string::npos)
        << error.what();
  }
}

TEST(LayoutFiles, UnitsAreReadHoweverACommentSaysThem) {
  const auto read = [](const std::string& comment) {
    return read_staked("# " + comment + "\nName,Easting,Northing,Elevation,Code\nA,1,2,3,GO\n", LayoutFormat::trimble,
                       "staked.csv")
        .items.size();
  };
  for (const char* metres : {"Units: [m]", "Units = metres", "units (m)", "Total station unit: TS16", "community: x",
                             "coordinates in units of meters"})
    EXPECT_EQ(read(metres), 1u) << metres;
  for (const char* others :
       {"Units = feet", "units feet", "Units [ft]", "Coordinate units: US survey feet", "unit mm", "Units: cubits"})
    EXPECT_THROW(read(others), std::runtime_error) << others;
  EXPECT_EQ(read(std::string(1000000, 'x') + " units: feet"), 1u) << "a line of any length is read";
}

TEST(LayoutFiles, AFirstPointThatCannotBeReadIsNoHead) {
  const ActualsT back = read_staked("A;401.25;77.5;\nB;401.25;77.5;12.125\n", LayoutFormat::hilti, "staked.csv");
  ASSERT_EQ(back.items.size(), 1u);
  EXPECT_EQ(back.refused, std::vector<std::string>{"staked.csv:1: the coordinates of 'A' are no numbers"});
}

TEST(LayoutFiles, WhatIsNoPointIsRefusedWithItsLine) {
  const ActualsT back = read_staked("PtID;E;N;H\nF01-C01-R1;1.0;2.0;3.0\nx;1;2\ny;a;b;c\nF01-C01-R1;1;2;3\n",
                                    LayoutFormat::hilti, "staked.csv");
  EXPECT_EQ(back.items.size(), 1u);
  EXPECT_EQ(back.refused,
            (std::vector<std::string>{"staked.csv:3: found 3 columns, expected a name and three coordinates",
                                      "staked.csv:4: the coordinates of 'y' are no numbers",
                                      "staked.csv:5: 'F01-C01-R1' stands in line 2 too, 0.0 mm from here; line 2 is "
                                      "taken, they say the same"}));
}

/// Which of two rows is the correction nobody can tell but by a date.
TEST(LayoutFiles, OfAPointThatWasStakedTwiceTheLastCountsOrNone) {
  const auto read = [](const std::string& rows) {
    return read_staked("PtID;E;N;H;Timestamp\n" + rows, LayoutFormat::hilti, "s.csv");
  };
  const std::string first = "A;3.0119;0;1;2026-05-05T07:00:00Z\n", second = "A;3.0019;0;1;2026-05-05T09:00:00+02:00\n",
                    third = "A;3.0020;0;1;2026-05-05T08:00:00Z\n", other = "B;1;2;3;2026-05-05T07:00:00Z\n";
  for (const std::string& rows : {first + other + third, third + first + other}) {
    const ActualsT back = read(rows);
    ASSERT_EQ(back.items.size(), 2u);
    const ActualT& a = *back.items[back.items[0]->item == "A" ? 0 : 1];
    EXPECT_EQ(a.measured.x(), 3.0020) << rows;
    ASSERT_EQ(back.refused.size(), 1u);
    EXPECT_NE(back.refused[0].find("9.9 mm from here; line " + a.source.substr(6) + " is taken, the last by its date"),
              std::string::npos)
        << back.refused[0];
  }
  for (const std::string& rows :
       {first + second + other, std::string("A;3.0119;0;1\nA;3.0019;0;1\nB;1;2;3\n"),
        std::string("A;3.0119;0;1;2026-05-05T07:00:00Z\nA;3.0019;0;1;05.05.2026 09:00\nB;1;2;3\n")}) {
    const ActualsT back = read(rows);
    ASSERT_EQ(back.items.size(), 1u) << rows;
    EXPECT_EQ(back.items[0]->item, "B");
    EXPECT_EQ(back.refused, std::vector<std::string>{"s.csv:3: 'A' stands in line 2 too, 10.0 mm from here; no date "
                                                     "says which is the last one, and none is taken: keep that row "
                                                     "alone"});
  }
}

/// Layout tools write where a point was to be beside where it is.
TEST(LayoutFiles, WhereAPointWasToBeIsNotWhereItIs) {
  const Eigen::Vector3d staked(401.25, 77.5, 12.125);
  const auto read = [](const std::string& head, const std::string& row) {
    return read_staked(head + "\nA;" + row + "\n", LayoutFormat::hilti, "s.csv");
  };
  for (const char* head : {"PtID;Design E;Design N;Design H;Staked E;Staked N;Staked H",
                           "PtID;E;N;H;E staked;N staked;H staked", "PtID;E_soll;N_soll;H_soll;E_ist;N_ist;H_ist [m]",
                           "Name;Design Easting;Design Northing;Design Elevation;As-staked Easting;As-staked "
                           "Northing;As-staked Elevation"}) {
    const ActualsT back = read(head, "1;2;3;401.25;77.5;12.125");
    ASSERT_EQ(back.items.size(), 1u) << head;
    EXPECT_EQ(back.items[0]->measured, staked) << head;
    EXPECT_EQ(back.ignored.size(), 1u) << head;
  }
  EXPECT_EQ(
      read("PtID;Design E;Design N;Design H;E;N;H;dE;Delta N", "1;2;3;401.25;77.5;12.125;0;0").items.at(0)->measured,
      staked);
  const auto fault = [&](const std::string& head) {
    try {
      read(head, "1;2;3;4;5;6");
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(fault("PtID;Design E;Design N;Design H").find("names where points were to be, and not where they were"),
            std::string::npos);
  EXPECT_NE(fault("PtID;E;N;H;Staked E;Staked N").find("names some coordinates of where they were staked"),
            std::string::npos);
  EXPECT_NE(fault("PtID;Grid E;Grid N;Grid H;Local E;Local N;Local H").find("'Grid E' and 'Local E' say the same"),
            std::string::npos);
  EXPECT_EQ(fault("PtID;E;N;H;Target Height;Instrument Height"), "");
}

TEST(LayoutFiles, ANameWithASeparatorIsRefused) {
  EXPECT_THROW(layout_csv({{"a;b", {0, 0, 0}, "GO"}}, LayoutFormat::hilti), std::runtime_error);
}

TEST(LayoutFiles, TheDrawingHasALayerForEachGate) {
  const Released r;
  const std::string dxf = layout_dxf(r.plan, make_job(r.plan, r.state, 0, "", ""), {{"CP1", {1, 2, 3}, "control"}});
  for (const char* layer : {"BRACKET_GO", "PANEL_GO", "CONTROL"})
    EXPECT_NE(dxf.find(layer), std::string::npos) << layer;
  EXPECT_NE(dxf.find("AC1009"), std::string::npos);
}

/// What a command prints; empty if it fails.
std::string printed(const std::string& command) {
  std::string text;
  std::FILE* pipe = popen(command.c_str(), "r");
  char buffer[4096];
  for (std::size_t n; pipe && (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) text.append(buffer, n);
  return pipe && pclose(pipe) == 0 ? text : std::string();
}

/// GDAL's reader of DXF, which is none of ours: layers, places to a tenth of a millimetre, closed outlines.
TEST(LayoutFiles, AnotherProgramOpensTheDrawing) {
  if (printed("ogrinfo --version 2> /dev/null").empty()) GTEST_SKIP() << "ogrinfo (gdal-bin) is not installed";
  const Released r;
  const std::string path =
      (std::filesystem::temp_directory_path() / ("plumbline_layout_" + std::to_string(getpid()) + ".dxf")).string();
  std::ofstream(path) << layout_dxf(r.plan, make_job(r.plan, r.state, 0, "", ""),
                                    {{"CP1", {350001.1234, 5800002.5678, 103.9}, "control"}});
  const std::string told = printed("ogrinfo -al '" + path + "' 2>&1");
  std::filesystem::remove(path);
  EXPECT_NE(told.find("Layer (String) = CONTROL"), std::string::npos) << told;
  EXPECT_NE(told.find("POINT Z (350001.1234 5800002.5678 103.9)"), std::string::npos) << told;
  std::size_t panels = 0, brackets = 0;
  for (std::size_t at = 0; (at = told.find("Layer (String) = PANEL_GO", at)) != std::string::npos; ++at) ++panels;
  for (std::size_t at = 0; (at = told.find("Layer (String) = BRACKET_GO", at)) != std::string::npos; ++at) ++brackets;
  EXPECT_EQ(panels, 2U) << told;  // of the lower floor
  EXPECT_GE(brackets, layout_points(make_job(r.plan, r.state, 0, "", "")).size()) << told;
  // Four corners and the first again.
  const auto line = told.find("LINESTRING Z (");
  ASSERT_NE(line, std::string::npos) << told;
  const std::string outline = told.substr(line, told.find(')', line) - line);
  EXPECT_EQ(std::count(outline.begin(), outline.end(), ','), 4) << outline;
}

TEST(Actuals, SingleEntriesThatAreWrongAreRefusedByName) {
  const ActualsT actuals = read_actuals_json(
      R"({"items": [{"item": "F01-C01-R1", "outcome": "done", "revision": 2, "measured": [1, 2, 3]}, {"item": 7}]})",
      "a.json");
  ASSERT_EQ(actuals.items.size(), 1u);
  EXPECT_EQ(actuals.items[0]->measured, Eigen::Vector3d(1, 2, 3));
  ASSERT_EQ(actuals.refused.size(), 1u);
  EXPECT_EQ(actuals.refused[0].substr(0, 17), "a.json: items[1]:");
  EXPECT_EQ(actuals.refused[0], "a.json: items[1]: 'item' is 7, expected text");
  const auto refused = [](const std::string& entry) {
    return read_actuals_json(R"({"items": [)" + entry + "]}", "a.json").refused.at(0);
  };
  EXPECT_EQ(refused(R"({"itme": "A", "outcome": "done"})"), "a.json: items[0]: has 'itme', which is no key; 'item' is");
  EXPECT_EQ(refused(R"({"outcome": "done"})"), "a.json: items[0]: has no 'item'");
  EXPECT_EQ(refused(R"({"item": "A", "outcome": "done", "revision": "1"})"),
            "a.json: items[0]: 'revision' is \"1\", expected a whole number");
  EXPECT_EQ(refused(R"({"item": "A", "outcome": "done", "measured": [1, 2]})"),
            "a.json: items[0]: 'measured' is [1,2], expected [E, N, H] in metres");
  EXPECT_NE(refused(R"({"item": "A", "outcome": "done", "setting": [1, 2, 3]})").find("\"right\""), std::string::npos);
  // No job has it, and none said would answer any job.
  for (const char* none : {"0", "-1"})
    EXPECT_EQ(refused(R"({"item": "A", "outcome": "done", "revision": )" + std::string(none) + "}"),
              "a.json: items[0]: 'revision' is " + std::string(none) + ", expected that of the job, 1 or more");
}

/// A key that nobody reads is named; one that seems to mean another key is not taken, because what it says would be
/// lost: a report without its revision answers any job.
TEST(Actuals, KeysThatNobodyReadsAreNamed) {
  const auto read = [](const std::string& entry, const std::string& beside = "") {
    return read_actuals_json("{" + beside + R"("items": [{"item": "A", "outcome": "done")" + entry + "}]}", "a.json");
  };
  EXPECT_TRUE(read(R"(, "revision": 2, "units": "m", "frame": "building")").ignored.empty());
  for (const auto& [wrong, meant] : {std::pair{"revison", "revision"},
                                     {"Revision", "revision"},
                                     {"sgima", "sigma"},
                                     {"mesured", "measured"},
                                     {"settings", "setting"},
                                     {"jobb", "job"},
                                     {"not", "note"}}) {
    const ActualsT actuals = read(", \"" + std::string(wrong) + "\": 1");
    ASSERT_EQ(actuals.refused.size(), std::string(meant).size() < 4 ? 0U : 1U) << wrong;
    if (actuals.refused.empty()) {
      EXPECT_EQ(actuals.ignored.at(0), "a.json: '" + std::string(wrong) + "' is not read") << "too short to guess";
    } else {
      EXPECT_EQ(actuals.refused[0],
                "a.json: items[0]: has '" + std::string(wrong) + "', which is no key; '" + meant + "' is");
    }
  }
  const ActualsT other = read(R"(, "temperature": 21, "robot": {"speed": 3})", R"("project": "tower", )");
  ASSERT_EQ(other.items.size(), 1U);
  ASSERT_EQ(other.ignored.size(), 1U);
  EXPECT_EQ(other.ignored[0], "a.json: 'project', 'robot' and 'temperature' are not read");
  EXPECT_THROW(read("", R"("unit": "in", )"), std::runtime_error);
  EXPECT_THROW(read("", R"("units": {"length": "ft", "angle": "rad"}, )"), std::runtime_error);
  EXPECT_THROW(read("", R"("frame": "floor 3", )"), std::runtime_error);
  EXPECT_NE(read(R"(, "units": "mm")").refused.at(0).find("lengths are in metres"), std::string::npos);
  EXPECT_NE(read(R"(, "measured": [1, 2, 3, 4])").refused.at(0).find("[E, N, H]"), std::string::npos);
  EXPECT_NE(read(R"(, "setting": {"right": 0, "up": 0, "out": 0, "turn": 1})").refused.at(0).find("'setting'"),
            std::string::npos);
  EXPECT_NE(read(R"(, "revision": 4294967298)").refused.at(0).find("expected that of the job"), std::string::npos);
  EXPECT_NE(read(R"(, "sigma": [0.001, 0, 0.001])").refused.at(0).find("each above 0"), std::string::npos);
  try {
    read(R"(, "outcome": "failed")");
    ADD_FAILURE() << "done or failed?";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("a.json: has 'outcome' twice"), std::string::npos) << error.what();
  }
}

TEST(Actuals, WhatIsNoFileOfReportsIsSaid) {
  const auto words = [](const std::string& text) {
    try {
      read_actuals_json(text, "a.json");
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(words("").find("a.json: is empty"), std::string::npos);
  EXPECT_NE(words("[]").find("has no list 'items'"), std::string::npos);
  EXPECT_NE(words("{\"items\": [\n{\"item\": }]}").find("is no JSON: parse error at line 2, column 10"),
            std::string::npos)
      << words("{\"items\": [\n{\"item\": }]}");
  EXPECT_NE(words(R"({"jobId": "1", "items": []})").find("is a job"), std::string::npos);
}

}  // namespace job_test
}  // namespace plumbline::loop

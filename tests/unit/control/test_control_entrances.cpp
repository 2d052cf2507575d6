// The same table through every entrance that takes control: it has to be the same points, or refused by all.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <optional>

#include "campaign_folder.hpp"
#include "control/points/control_files.hpp"
#include "photo/block/control_list.hpp"
#include "survey/files/survey_csv.hpp"
#include "test_support.hpp"

namespace plumbline {
namespace test_control_entrances {

struct Known {
  Eigen::Vector3d position, sigma;  ///< nan where not given
};
using Read = std::optional<std::map<std::string, Known>>;  ///< empty: refused

/// read.points, adjust.colmap_control, read.gcp.
Read by_points(const std::string& text) {
  try {
    std::map<std::string, Known> all;
    for (const auto& p : control::parse_control(text, "c.csv").points) all[p.name] = {p.position, p.sigma};
    return all;
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
}

/// read.campaign, read.photo_campaign, read.survey_campaign.
Read by_campaign(const std::string& text) {
  try {
    std::map<std::string, Known> all;
    for (const auto& p : campaign::parse_control(text, "c.csv")) all[p.name] = {p.position, p.sigma};
    return all;
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
}

/// read.photomodeler, read.bal, read.image_block.
Read by_block(const std::string& text) {
  const test::TemporaryFolder folder;
  std::ofstream(folder.path() / "c.csv", std::ios::binary) << text;
  block::ReadBlock read;
  for (const char* name : {"A", "B", "7"}) read.block.points.push_back({name, {0, 0, 0}});
  try {
    block::add_control(folder.path() / "c.csv", {}, read);
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
  std::map<std::string, Known> all;
  const auto& control = read.block.control;
  for (std::size_t k = 0; k < control.points.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(3 * k);
    all[read.block.points[control.points[k]].name] = {control.position.segment<3>(at),
                                                      control.covariance.diagonal().segment<3>(at).cwiseSqrt()};
  }
  return all;
}

/// read.survey_csv, survey files of a campaign.
Read by_survey(const std::string& text) {
  try {
    const survey::SurveyObservations survey = survey::read_survey_csv(text, "c.csv");
    if (!survey.skipped.empty()) return std::nullopt;
    std::map<std::string, Known> all;
    for (const auto& p : survey.points) all[p.id] = {p.coordinates, Eigen::Vector3d::Constant(std::nan(""))};
    for (const auto& group : survey.coordinates)
      for (std::size_t i = 0; i < group.components.size(); ++i) {
        const auto k = static_cast<Eigen::Index>(i);
        all[group.components[i].point].sigma(group.components[i].axis) = std::sqrt(group.covariance(k, k));
      }
    return all;
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
}

struct Table {
  const char* text;
  Eigen::Vector3d a;      ///< of point A
  Eigen::Vector3d sigma;  ///< nan: not given
};

const double nan = std::nan("");
const Eigen::Vector3d none = Eigen::Vector3d::Constant(nan);
const Eigen::Vector3d five = Eigen::Vector3d::Constant(0.005);

const std::vector<Table> same = {
    {"id,E,N,H\nA,1.5,2.5,3.5\nB,4,5,6\n", {1.5, 2.5, 3.5}, none},
    {"name,x,y,z\nA,1.5,2.5,3.5\nB,4,5,6\n", {1.5, 2.5, 3.5}, none},
    {"id,E,N,H,sigma\nA,1.5,2.5,3.5,0.005\nB,4,5,6,0.005\n", {1.5, 2.5, 3.5}, five},
    {"id,E,N,H,sigma [mm]\nA,1.5,2.5,3.5,5\nB,4,5,6,5\n", {1.5, 2.5, 3.5}, five},
    {"id,E,N,H,sigma_mm\nA,1.5,2.5,3.5,5\nB,4,5,6,5\n", {1.5, 2.5, 3.5}, five},
    {"id,E,N,H,sE,sN,sH\nA,1.5,2.5,3.5,0.001,0.002,0.003\nB,4,5,6,.1,.1,.1\n", {1.5, 2.5, 3.5}, {0.001, 0.002, 0.003}},
    {"id,E,N,H,sE_mm,sN_mm,sH_mm\nA,1.5,2.5,3.5,1,2,3\nB,4,5,6,1,1,1\n", {1.5, 2.5, 3.5}, {0.001, 0.002, 0.003}},
    {"id,E,N,H,sd_mm\nA,1.5,2.5,3.5,5\nB,4,5,6,5\n", {1.5, 2.5, 3.5}, five},
    {"id,east_mm,north_mm,height_mm\nA,1500,2500,3500\nB,4,5,6\n", {1.5, 2.5, 3.5}, none},
    {"Punktnummer;Rechtswert;Hochwert;H\xC3\xB6he;sigma_mm\nA;1,5;2,5;3,5;5\nB;4;5;6;5\n", {1.5, 2.5, 3.5}, five},
    {"Matricule;Est;Nord;Altitude\nA;1,5;2,5;3,5\nB;4;5;6\n", {1.5, 2.5, 3.5}, none},
    {"Punto;Este;Norte;Cota\nA;1,5;2,5;3,5\nB;4;5;6\n", {1.5, 2.5, 3.5}, none},
    {"name,y,x,h\nA,3400200.5,5400100.25,300\nB,3400210,5400110,301\n", {3400200.5, 5400100.25, 300}, none},
    {"Punkt;X;Y;H\nA;5400100,25;3400200,5;300\nB;5400110;3400210;301\n", {3400200.5, 5400100.25, 300}, none},
    {"name,y,x,h,sx_mm,sy_mm,sh_mm\nA,3400200.5,5400100.25,300,1,2,3\nB,3400210,5400110,301,1,2,3\n",
     {3400200.5, 5400100.25, 300},
     {0.002, 0.001, 0.003}},
    {"A,1.5,2.5,3.5\nB,4,5,6\n", {1.5, 2.5, 3.5}, none},
    {"A,1.5,2.5,3.5,bolt\nB,4,5,6,\n", {1.5, 2.5, 3.5}, none},
    {"A;1,5;2,5;3,5\nB;4,5;5;6\n", {1.5, 2.5, 3.5}, none},
    {"Name;E;N;H;;\n;;;;;\nA;1,5;2,5;3,5;;\nB;4;5;6;;\n;;;;;\n", {1.5, 2.5, 3.5}, none},
    {"id,E,N,H,code,date\nA,1.5,2.5,3.5,bolt,2026\nB,4,5,6,bolt,2026\n", {1.5, 2.5, 3.5}, none},
};

const std::vector<const char*> refused = {
    "Punkt;X;Y;Z\nA;1;2;3\nB;4;5;6\n",                                    // X may be north or east
    "name,y,x,h\nA,1,2,3\nB,4,5,6\n",                                     // likewise
    "id,E,N,H,RMS\nA,1,2,3,0.1\nB,4,5,6,0.1\n",                           // an accuracy, but of what
    "id,E,N,H,sigma_km\nA,1,2,3,5\nB,4,5,6,5\n",                          // a unit of nothing
    "Name;E;N;H\nA;345678,1;5,41E+06;12,1\nB;345678,1;5412345,6;12,1\n",  // shortened by a spreadsheet
    "id,lat,lon,H\nA,48.1,8.2,300\nB,48.1,8.2,300\n",                     // degrees
    "id,E,N,H\n#A,1,2,3\nB,4,5,6\n",                                      // a comment, or a name
    "A,32,386930.017,7327717.501\nB,32,386931,7327718\n",                 // a zone in front
    "id,E,N,H,sigma\nA,1,2,3,-1\nB,4,5,6,1\n",                            // negative
};

bool equal(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  for (int k = 0; k < 3; ++k)
    if (std::isnan(a(k)) != std::isnan(b(k)) || std::abs(a(k) - b(k)) > 1e-9) return false;
  return true;
}

TEST(ControlEntrances, ReadTheSameTablesAlike) {
  for (const Table& table : same) {
    const Read points = by_points(table.text), campaign = by_campaign(table.text), block = by_block(table.text),
               survey = by_survey(table.text);
    for (const auto& [who, read] :
         {std::pair{"points", points}, {"campaign", campaign}, {"block", block}, {"survey", survey}}) {
      ASSERT_TRUE(read.has_value()) << who << " refuses\n" << table.text;
      ASSERT_EQ(read->count("A"), 1u) << who << "\n" << table.text;
      EXPECT_TRUE(equal(read->at("A").position, table.a))
          << who << " has " << read->at("A").position.transpose() << " in\n"
          << table.text;
      // Without standard deviations a campaign assumes 1 mm and says so, and a block holds the points.
      Eigen::Vector3d expected = table.sigma;
      if (expected.array().isNaN().all() && std::string(who) == "campaign") expected.setConstant(0.001);
      if (expected.array().isNaN().all() && std::string(who) == "block") expected.setZero();
      EXPECT_TRUE(equal(read->at("A").sigma, expected))
          << who << " has sigma " << read->at("A").sigma.transpose() << " in\n"
          << table.text;
    }
  }
}

TEST(ControlEntrances, RefuseTheSameTables) {
  for (const char* text : refused) {
    EXPECT_FALSE(by_points(text).has_value()) << "points\n" << text;
    EXPECT_FALSE(by_campaign(text).has_value()) << "campaign\n" << text;
    EXPECT_FALSE(by_block(text).has_value()) << "block\n" << text;
    EXPECT_FALSE(by_survey(text).has_value()) << "survey\n" << text;
  }
}

/// 1 mm was assumed for a column that the reader knew from another kind of table.
TEST(ControlEntrances, ACampaignSaysWhatItAssumes) {
  std::vector<std::string> warnings;
  campaign::parse_control("id,E,N,H,sigma_mm\nA,1,2,3,5\n", "c.csv", &warnings);
  EXPECT_TRUE(warnings.empty());
  campaign::parse_control("id,E,N,H,code\nA,1,2,3,bolt\n", "c.csv", &warnings);
  EXPECT_THAT(warnings, testing::ElementsAre(testing::HasSubstr("1 mm in E, N and H is assumed"),
                                             testing::HasSubstr("not used: 'code'")));
}

}  // namespace test_control_entrances
}  // namespace plumbline

// deviations.dxf as CAD programs read it: groups in pairs, layers by verdict, texts upright on their facade.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <tuple>
#include <vector>

#include "building/ifc/facade_artifact.hpp"
#include "building/judgement/deviation_dxf.hpp"
#include "building/judgement/facade_order.hpp"
#include "test_support.hpp"

namespace plumbline::judgement {
namespace test_dxf {

using Entity = std::multimap<int, std::string>;

/// Entities by kind: group codes with their values. Fails for a line that is no group code.
std::vector<std::pair<std::string, Entity>> entities_of(const std::string& dxf) {
  std::vector<std::pair<std::string, Entity>> all;
  std::istringstream lines(dxf);
  for (std::string code, value; std::getline(lines, code) && std::getline(lines, value);) {
    EXPECT_FALSE(code.empty() || code.find_first_not_of("0123456789") != std::string::npos) << code << ": " << value;
    if (code == "0") all.push_back({value, {}});
    if (!all.empty()) all.back().second.emplace(std::atoi(code.c_str()), value);
  }
  return all;
}

double number(const Entity& entity, int code) { return std::atof(entity.find(code)->second.c_str()); }

DeviationT example() {
  DeviationT deviation;
  const auto add = [&](const std::string& id, double azimuth, bool confirmed, ToleranceVerdict verdict) {
    auto anchor = std::make_unique<AnchorDeviationT>();
    ifc::FacadeFrame frame = ifc::frame_facing(ifc::facing(azimuth), ifc::FacadeSource::rule, confirmed);
    anchor->id = id, anchor->verdict = verdict;
    anchor->facade = ifc::to_artifact(frame);
    anchor->design = {10, 20, 3};
    anchor->deviation = verdict == ToleranceVerdict::not_measured
                            ? Eigen::Vector3d::Constant(NAN)
                            : Eigen::Vector3d(0.002 * frame.right + 0.003 * frame.up - 0.004 * frame.out);
    deviation.anchors.push_back(std::move(anchor));
  };
  add("Nord-\xc3\x9f\n0", 0, true, ToleranceVerdict::pass);
  add("East \xff", M_PI / 2, true, ToleranceVerdict::fail);
  add("Open", M_PI, false, ToleranceVerdict::undecided);
  add("None", M_PI, true, ToleranceVerdict::not_measured);
  auto panel = std::make_unique<PanelDeviationT>();
  panel->verdict = ToleranceVerdict::fail;
  const std::vector<std::tuple<const char*, double, double>> corners = {
      {"top_left", 0, 3}, {"bottom_left", 0, 0}, {"bottom_right", 2, 0}, {"top_right", 2, 3}};
  for (const auto& [name, x, z] : corners) {
    panel->corners.push_back(std::make_unique<PanelCornerT>());
    panel->corners.back()->name = name, panel->corners.back()->design = {x, 0, z};
  }
  deviation.panels.push_back(std::move(panel));
  return deviation;
}

TEST(DeviationDxf, SaysWhereEverythingIsInTheFrameOfItsFacade) {
  const auto entities = entities_of(deviation_dxf(example(), 50));
  std::vector<std::string> texts;
  int points = 0, lines = 0;
  std::vector<Eigen::Vector3d> corners;
  for (const auto& [kind, entity] : entities) {
    if (kind == "POINT") ++points;
    if (kind == "VERTEX") corners.emplace_back(number(entity, 10), number(entity, 20), number(entity, 30));
    if (kind == "LINE") {
      ++lines;
      EXPECT_NEAR(number(entity, 31) - number(entity, 30), 50 * 0.003, 1e-9);
    }
    if (kind != "TEXT") continue;
    texts.push_back(entity.find(8)->second + ": " + entity.find(1)->second);
    if (!entity.contains(210)) continue;
    // The standard's arbitrary axis algorithm: Ax = Wz x N, Ay = N x Ax for a direction that is not near z.
    const Eigen::Vector3d n(number(entity, 210), number(entity, 220), number(entity, 230));
    const Eigen::Vector3d ax = Eigen::Vector3d::UnitZ().cross(n).normalized(), ay = n.cross(ax);
    const Eigen::Vector3d at = number(entity, 10) * ax + number(entity, 20) * ay + number(entity, 30) * n;
    EXPECT_LT((at - Eigen::Vector3d(10, 20, 3)).norm(), 1e-5) << texts.back();
    EXPECT_LT((ay - Eigen::Vector3d::UnitZ()).norm(), 1e-9) << "upright";
  }
  EXPECT_EQ(points, 4);
  EXPECT_EQ(lines, 3) << "what was not measured has no deviation";
  ASSERT_EQ(texts.size(), 4u);
  EXPECT_EQ(texts[0], "ANCHOR_PASS: Nord-\\U+00DF0 right +2.0 up +3.0 out -4.0 mm");
  EXPECT_EQ(texts[1], "ANCHOR_FAIL: East ? right +2.0 up +3.0 out -4.0 mm");
  EXPECT_EQ(texts[2].substr(0, 26), "ANCHOR_UNDECIDED: Open x +") << "nobody is told right or out there";
  EXPECT_EQ(texts[3], "ANCHOR_NOT_MEASURED: None not measured");
  ASSERT_EQ(corners.size(), 4u);
  EXPECT_LT((corners[1] - Eigen::Vector3d(2, 0, 0)).norm(), 1e-9) << "around, whatever their order";
  EXPECT_LT((corners[2] - Eigen::Vector3d(2, 0, 3)).norm(), 1e-9);
}

/// Four facades on one layer are four elevations in one heap.
TEST(DeviationDxf, OfSeveralFacadesEachHasItsLayers) {
  DeviationT deviation = example();
  for (const char* name : {"A (180°)", "A 180", "Süd"}) {
    deviation.facades.push_back(std::make_unique<FacadeT>());
    deviation.facades.back()->name = name;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (!deviation.anchors[i]->facade) deviation.anchors[i]->facade = std::make_unique<FacadeFrameT>();
    deviation.anchors[i]->facade->facade = deviation.facades[i]->name;
  }
  const auto codes = facade_codes(deviation);
  EXPECT_EQ(codes.at("A (180°)"), "A_180");
  EXPECT_EQ(codes.at("A 180"), "A_180_2");
  EXPECT_EQ(codes.at("Süd"), "S_D");
  const std::string dxf = deviation_dxf(deviation);
  for (const auto& [layer, colour] :
       {std::pair{"ANCHOR_PASS_A_180", 3}, std::pair{"ANCHOR_FAIL_A_180_2", 1}, std::pair{"ANCHOR_UNDECIDED_S_D", 2}})
    EXPECT_NE(dxf.find("LAYER\n2\n" + std::string(layer) + "\n70\n0\n62\n" + std::to_string(colour) + "\n"),
              std::string::npos)
        << layer;
}

/// GDAL, another reader, where it is installed.
TEST(DeviationDxf, IsReadByAnother) {
  if (std::system("ogrinfo --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "ogrinfo is not installed";
  const plumbline::test::TemporaryFolder folder;
  const auto file = folder.path() / "d.dxf", out = folder.path() / "out.txt";
  std::ofstream(file) << deviation_dxf(example());
  ASSERT_EQ(std::system(("ogrinfo -ro -al " + file.string() + " > " + out.string() + " 2>&1").c_str()), 0);
  const std::string told = plumbline::test::read_file(out);
  EXPECT_NE(told.find("Feature Count: 12"), std::string::npos) << told;  // 4 points, 4 texts, 3 lines, an outline
  for (const char* layer : {"ANCHOR_FAIL", "ANCHOR_NOT_MEASURED", "DEVIATION_100_TIMES_AS_LONG", "PANEL_FAIL"})
    EXPECT_NE(told.find(layer), std::string::npos) << layer;
}

/// A third, which audits what it opens.
TEST(DeviationDxf, EzdxfFindsTheLayersAndNothingToMend) {
  if (std::system("/usr/bin/python3 -c 'import ezdxf' > /dev/null 2>&1") != 0) GTEST_SKIP() << "ezdxf is not installed";
  const plumbline::test::TemporaryFolder folder;
  const auto file = folder.path() / "d.dxf", out = folder.path() / "out.txt", script = folder.path() / "read.py";
  std::ofstream(file) << deviation_dxf(example());
  std::ofstream(script) << "import ezdxf, sys\nd = ezdxf.readfile(sys.argv[1])\na = d.audit()\n"
                           "print(d.dxfversion, len(a.errors), len(a.fixes), len(d.modelspace()))\n"
                           "layers = {l.dxf.name for l in d.layers}\n"
                           "print(*sorted({e.dxf.layer for e in d.modelspace()} - layers), 'undeclared')\n"
                           "print(*layers)\n";
  ASSERT_EQ(std::system(("/usr/bin/python3 " + script.string() + " " + file.string() + " > " + out.string()).c_str()),
            0);
  const std::string told = plumbline::test::read_file(out);
  EXPECT_EQ(told.find("AC1009 0 0 12\nundeclared\n"), 0u) << told;
  for (const char* layer : {"ANCHOR_FAIL", "ANCHOR_NOT_MEASURED", "DEVIATION_100_TIMES_AS_LONG", "PANEL_FAIL"})
    EXPECT_NE(told.find(layer), std::string::npos) << layer;
}

}  // namespace test_dxf
}  // namespace plumbline::judgement

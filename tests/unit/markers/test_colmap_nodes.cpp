// adjust.colmap_control and colmap.sfm: that they can be stopped.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>

#include "control_site.hpp"
#include "photo/cameras/colmap_files.hpp"
#include "stopping.hpp"
#include "test_support.hpp"

namespace plumbline::markers {
namespace test_colmap_nodes {

namespace fs = std::filesystem;

TEST(ColmapControl, CanBeStopped) {
  const Site s = site(1);
  const test::TemporaryFolder folder;
  fs::create_directories(folder.path() / "model");
  for (const auto& [name, text] : cameras::colmap_text(s.model)) std::ofstream(folder.path() / "model" / name) << text;
  std::ofstream control(folder.path() / "control.csv"), seen(folder.path() / "seen.csv");
  control.precision(12), seen.precision(12);
  control << "name,x,y,z,sigma,role\n", seen << "image,point,x,y,sigma\n";
  for (const ControlPoint& point : s.control)
    control << point.name << "," << point.position.x() << "," << point.position.y() << "," << point.position.z() << ","
            << point.sigma.x() << "," << (point.check ? "check" : "control") << "\n";
  for (const ImagePoint& p : s.measured)
    seen << p.image << "," << p.point << "," << p.pixel.x() << "," << p.pixel.y() << "," << p.sigma << "\n";
  control.close(), seen.close();
  EXPECT_EQ(test::stopping_at_fault([&] {
              test::NodeHarness node("adjust.colmap_control");
              node.set("model", (folder.path() / "model").string());
              node.set("control", (folder.path() / "control.csv").string());
              node.set("observations", (folder.path() / "seen.csv").string());
              return node;
            }),
            "");
}

/// A reconstruction takes minutes in a program of its own, which ends with the node.
TEST(ColmapSfm, EndsTheProgramWhenItIsStopped) {
  const test::TemporaryFolder folder;
  const fs::path program = folder.path() / "colmap", began = folder.path() / "began";
  std::ofstream(program) << "#!/bin/sh\ncase \"$1\" in *extractor*) echo $$ > " << began.string()
                         << "; exec sleep 600;; *) echo 'COLMAP 3.9 -- Structure-from-Motion';; esac\n";
  fs::permissions(program, fs::perms::owner_all);
  std::ofstream(folder.path() / "a.jpg") << "x", std::ofstream(folder.path() / "b.jpg") << "x";
  test::NodeHarness node("colmap.sfm");
  node.set("photographs", folder.path().string()), node.set("program", program.string());
  node.stop_after(20);
  const auto start = std::chrono::steady_clock::now();
  const std::string outcome = node.outcome();
  EXPECT_EQ(outcome.rfind("failed: stopped", 0), 0u) << outcome;
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60));
  std::ifstream file(began);
  int pid = 0;
  ASSERT_TRUE(file >> pid) << "it never began";
  EXPECT_FALSE(fs::exists("/proc/" + std::to_string(pid))) << "it goes on without anybody waiting for it";
}

}  // namespace test_colmap_nodes
}  // namespace plumbline::markers

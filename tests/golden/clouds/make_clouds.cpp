// make_clouds FOLDER LISTING FIXTURES: writes LAS and E57 files into FOLDER, and into LISTING what our reader finds in
// them and in those of FIXTURES.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <vector>

#include "e57_bytes.hpp"
#include "surface/cloud/cloud_file.hpp"
#include "surface/cloud/cloud_writer.hpp"

namespace {

namespace fs = std::filesystem;
using namespace plumbline::cloud;
using Places = std::vector<Eigen::Vector3d>;

Places places() {
  Places points;
  for (int i = 0; i < 1500; ++i)
    points.push_back({352118.25 + 1e-4 * (7 * i % 9001), 5810443.5 - 1e-4 * i, 34 + 1e-4 * (i * i % 997)});
  return points;
}

void save(const fs::path& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

void make(const fs::path& folder) {
  const Places points = places();
  CloudWriter writer((folder / "written_las.las").string(), CloudFormat::las, points.size(), points.front(), "survey");
  for (const Eigen::Vector3d& point : points) writer.add(point, 0.0005f);
  writer.finish();
  // As the tests of our reader have them made: what they hold it against are files that others read, too.
  for (const int minor : {2, 4})
    for (const int format : {0, 1, 3, 6, 7}) {
      if (minor < 4 && format > 3) continue;
      plumbline::cloud_bytes::LasFile file;
      file.minor = minor, file.format = format, file.offset = {352000, 5810000, 0};
      save(folder / ("las_1_" + std::to_string(minor) + "_" + std::to_string(format) + ".las"),
           plumbline::cloud_bytes::las_file(file, points));
    }
  Places near;
  for (const Eigen::Vector3d& point : points) near.push_back(point - Eigen::Vector3d(352000, 5810000, 0));
  for (const char* kind : {"scaled", "single", "double", "spherical"}) {
    plumbline::cloud_bytes::E57ScanBytes scan;
    scan.points = near, scan.kind = kind, scan.index = false;  // which the other reader does not step over
    save(folder / (std::string("e57_") + kind + ".e57"), plumbline::cloud_bytes::e57_file({scan}));
  }
}

nlohmann::json found_in(const fs::path& path) {
  nlohmann::json entry{{"file", path.filename().string()}, {"refused", ""}};
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  try {
    const CloudSummary read = read_cloud(path.string(), [&](const Places& some, double, int) {
      for (const Eigen::Vector3d& point : some) sum += point;
    });
    const auto list = [](const Eigen::Vector3d& v) { return nlohmann::json{v.x(), v.y(), v.z()}; };
    // What LAS withholds or calls noise our reader leaves out, and the other does not know it.
    entry["points"] = read.points + read.withheld;
    entry["low"] = list(read.low), entry["high"] = list(read.high);
    entry["mean"] = list(sum / static_cast<double>(read.points));

  } catch (const CloudError& error) {
    entry["refused"] = error.what();
  }
  return entry;
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 4) return 2;
  make(arguments[1]);
  nlohmann::json listing = nlohmann::json::array();
  for (const char* folder : {arguments[1], arguments[3]})
    for (const auto& file : fs::directory_iterator(folder))
      if (file.path().extension() == ".las" || file.path().extension() == ".e57")
        listing.push_back(found_in(file.path()));
  std::ofstream(arguments[2]) << listing.dump(1);
  return 0;
}

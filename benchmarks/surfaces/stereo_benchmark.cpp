// dense.plane_sweep and dense.sgm side by side, on the same photographs with the same cells.
//   stereo_benchmark pair LEFT RIGHT TRUTH [SCALE]  a rectified pair with published disparities (Middlebury)
//   stereo_benchmark fountain FOLDER [DISTANCE SEARCH UP TURN]   fountain-P11 or Herz-Jesus-P8: photographs of even
//   numbers
//       against those of odd ones, on the plane DISTANCE m before the middle camera, UP m above it, turned by TURN
//       degrees
//   stereo_benchmark locking                        bias by the fraction of a disparity, on a simulated wall
#include <array>
#include <cstdio>
#include <cstring>

#include "both_kinds.hpp"
#include "facade_scene.hpp"
#include "fountain.hpp"
#include "published_pair.hpp"

namespace {

using namespace plumbline;
using namespace plumbline::surface;

void fountain(const std::string& folder, double distance, double search, double above, double turn) {
  const Fountain set = read_fountain(folder);
  const CellGrid grid = [&] {
    CellGrid wall;
    wall.plane = set.wall(distance, above, turn), wall.area = {{-1.6, -1.2}, {1.6, 1.2}}, wall.columns = 71,
    wall.rows = 53;
    return wall;
  }();
  FacetOptions sweep;
  sweep.search = search, sweep.max_sigma = 0.01;
  SemiGlobalOptions sgm;
  sgm.pair.search = search, sgm.pair.max_sigma = 0.01;
  for (const char* name : {"dense.plane_sweep", "dense.sgm", "dense.sgm refine=false"}) {
    sgm.pair.refine = std::strcmp(name, "dense.sgm") == 0;
    sgm.pair.matching_sigma = sgm.pair.refine ? 0.02 : 0.12;
    std::array<Heights, 2> found;
    for (const size_t half : {0, 1}) {
      const std::vector<FacetView> views = set.every(half, 2);
      std::vector<View> oriented;
      for (const FacetView& view : views) oriented.push_back(*view.view);
      found[half] = name[6] == 'p' ? swept(grid, views, sweep)
                                   : matched(grid, views, pairs_for(grid.plane, {0, 0}, oriented, 2, 10), sgm);
    }
    std::vector<double> differences, ratios;
    size_t count[2] = {0, 0}, within = 0;
    for (size_t cell = 0; cell < grid.size(); ++cell) {
      for (const size_t half : {0, 1}) count[half] += !std::isnan(found[half].height[cell]);
      const double difference = std::abs(found[0].height[cell] - found[1].height[cell]);
      if (std::isnan(difference)) continue;
      differences.push_back(difference);
      ratios.push_back(difference / std::hypot(found[0].sigma[cell], found[1].sigma[cell]));
      within += ratios.back() < 3;
    }
    const double both = static_cast<double>(differences.size());
    std::array<std::vector<double>, 4> parts;  // left, right, below, above: whether the plane is the wall's
    for (size_t cell = 0; cell < grid.size(); ++cell)
      if (const Eigen::Vector2d at = grid.middle(cell); !std::isnan(found[0].height[cell]))
        parts[at.x() > 0].push_back(found[0].height[cell]), parts[2 + (at.y() > 0)].push_back(found[0].height[cell]);
    std::printf("median height left %+.3f, right %+.3f, below %+.3f, above %+.3f m\n", quantile(parts[0], 0.5),
                quantile(parts[1], 0.5), quantile(parts[2], 0.5), quantile(parts[3], 0.5));
    std::printf(
        "%-22s of %zu cells even %zu, odd %zu, both %.0f; |difference| median %.2f mm, 90 %% below %.2f mm, above 20 "
        "mm "
        "%.1f %%; over its sigma median %.2f, within 3 sigma %.1f %%; %.1f s\n",
        name, grid.size(), count[0], count[1], both, 1e3 * quantile(differences, 0.5), 1e3 * quantile(differences, 0.9),
        100 *
            static_cast<double>(
                std::count_if(differences.begin(), differences.end(), [](double d) { return d > 0.02; })) /
            both,
        quantile(ratios, 0.5), 100 * static_cast<double>(within) / both, found[0].seconds + found[1].seconds);
  }
}

/// A wall that leans slowly, so that its disparity goes through many whole pixels: what is found by the fraction.
void locking() {
  plumbline::testing::FacadeScene scene;
  scene.plane = facade_plane({0, 0, 0}, {0, -1, 0});
  scene.height = [](double u, double) { return 0.02 * u; };
  std::vector<View> views(3);
  std::vector<Pyramid> images;
  for (size_t k = 0; k < 3; ++k) {
    views[k].camera.width = 1600, views[k].camera.height = 400;
    views[k].camera.fx = views[k].camera.fy = 4000, views[k].camera.cx = 800, views[k].camera.cy = 200;
    // All parallel: rectified pairs are then the photographs themselves, and nothing is smoothed on the way.
    views[k].cam_from_world =
        plumbline::testing::looking(scene.plane.world({0.4 * (static_cast<double>(k) - 1), 0, 3}),
                                    scene.plane.world({0.4 * (static_cast<double>(k) - 1), 0, 0}));
    images.push_back(pyramid_of(plumbline::testing::exposed(
        plumbline::testing::photograph(scene, views[k].camera, views[k].cam_from_world), 1600, 400, 1.5, k)));
  }
  std::vector<FacetView> all;
  for (size_t k = 0; k < 3; ++k) all.push_back({&views[k], &images[k]});
  CellGrid grid;
  grid.plane = scene.plane, grid.area = {{-0.18, -0.1}, {0.18, 0.1}}, grid.columns = 45, grid.rows = 25;
  const auto pair = rectified_pair(grid.plane, {0, 0}, views, 0, 1);
  for (const char* name : {"dense.plane_sweep", "dense.sgm", "dense.sgm refine=false"}) {
    SemiGlobalOptions sgm;
    sgm.pair.search = 0.03, sgm.pair.max_sigma = 1, sgm.pair.refine = std::strcmp(name, "dense.sgm") == 0;
    FacetOptions sweep;
    sweep.search = 0.03, sweep.max_sigma = 1;
    const Heights found = name[6] == 'p' ? swept(grid, all, sweep) : matched(grid, all, {*pair}, sgm);
    std::array<double, 8> sum{};
    std::array<int, 8> count{};
    double squares = 0, mean = 0;
    int cells = 0;
    for (size_t cell = 0; cell < grid.size(); ++cell) {
      if (std::isnan(found.height[cell])) continue;
      const Eigen::Vector2d at = grid.middle(cell);
      const double true_height = 0.02 * at.x();
      const double truth = pair->rectified(grid.plane.world({at.x(), at.y(), true_height})).z(),
                   here = pair->rectified(grid.plane.world({at.x(), at.y(), found.height[cell]})).z();
      const auto bin = static_cast<size_t>(8 * (truth - std::floor(truth)));
      sum[bin] += here - truth, ++count[bin], squares += (here - truth) * (here - truth), mean += here - truth, ++cells;
    }
    std::printf("%-22s %d cells, rms %.4f px, mean %+.4f px; mean by eighths of a disparity:", name, cells,
                std::sqrt(squares / cells), mean / cells);
    for (size_t bin = 0; bin < 8; ++bin) std::printf(" %+.3f", count[bin] ? sum[bin] / count[bin] : kNan);
    std::printf("\n");
  }
}

}  // namespace

int main(int count, char** arguments) try {
  const std::string what = count > 1 ? arguments[1] : "";
  if (what == "pair" && (count == 5 || count == 6))
    compare_on_published_pair(arguments[2], arguments[3], arguments[4], count == 6 ? std::atof(arguments[5]) : 1);
  else if (what == "fountain" && (count == 3 || count == 7))
    count == 3 ? fountain(arguments[2], 8, 0.4, 0, 0)
               : fountain(arguments[2], std::atof(arguments[3]), std::atof(arguments[4]), std::atof(arguments[5]),
                          std::atof(arguments[6]));
  else if (what == "locking" && count == 2)
    locking();
  else
    throw std::runtime_error(
        "usage: stereo_benchmark pair LEFT RIGHT TRUTH [SCALE] | fountain FOLDER [DISTANCE SEARCH UP TURN] | locking");
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}

// dense.plane_sweep and dense.sgm side by side, on the same photographs with the same cells.
//   stereo_benchmark pair LEFT RIGHT TRUTH.pfm   a rectified pair with published disparities (Middlebury)
//   stereo_benchmark fountain FOLDER             fountain-P11: photographs of even numbers against those of odd ones
//   stereo_benchmark locking                     bias by the fraction of a disparity, on a simulated wall
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <limits>

#include "facade_scene.hpp"
#include "fountain.hpp"
#include "semi_global.hpp"

namespace {

using namespace plumbline;
using namespace plumbline::surface;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

double seconds_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double quantile(std::vector<double>& values, double share) {
  if (values.empty()) return kNan;
  const auto at = static_cast<size_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  return values[at];
}

struct Kinds {
  SemiGlobalOptions semi_global;
  FacetOptions sweep;
};

/// Heights of all cells by one kind; nan: a hole.
struct Heights {
  std::vector<double> height, sigma;
  double seconds = 0;
};

Heights swept(const CellGrid& grid, const std::vector<FacetView>& views, const FacetOptions& options) {
  Heights result;
  result.height.assign(grid.size(), kNan), result.sigma = result.height;
  result.seconds = seconds_of([&] {
    for (size_t cell = 0; cell < grid.size(); ++cell) {
      const Eigen::Vector2d at = grid.middle(cell);
      double spacing = 0;
      for (const FacetView& view : views)
        if (const auto map = map_at(*view.view, grid.plane, {at.x(), at.y(), 0}, 8))
          spacing = std::max(spacing, map->ground_pixel());
      if (!(spacing > 0)) continue;
      bool two = false;
      Facet best;
      for (const double start : search_heights(grid.plane, at, spacing, views, options, 2, &two)) {
        Facet facet = match_facet(grid.plane, at, spacing, start, views, options);
        if (facet.outcome == FacetOutcome::measured && facet.correlation > best.correlation) best = std::move(facet);
      }
      if (best.outcome == FacetOutcome::measured && !two)
        result.height[cell] = best.height, result.sigma[cell] = best.sigma;
    }
  });
  return result;
}

Heights matched(const CellGrid& grid, const std::vector<FacetView>& views, const std::vector<RectifiedPair>& pairs,
                const SemiGlobalOptions& options) {
  Heights result;
  result.height.assign(grid.size(), kNan), result.sigma = result.height;
  result.seconds = seconds_of([&] {
    std::vector<std::vector<PairHeight>> all;
    for (const RectifiedPair& pair : pairs) all.push_back(semi_global_heights(pair, grid, views, options));
    for (size_t cell = 0; cell < grid.size(); ++cell) {
      if (pairs.size() == 1) {  // nobody to agree with
        if (all[0][cell].state == PairHeight::State::found)
          result.height[cell] = all[0][cell].height, result.sigma[cell] = all[0][cell].sigma;
        continue;
      }
      std::vector<PairHeight> said;
      for (const auto& of_pair : all) said.push_back(of_pair[cell]);
      const Facet facet = agreed_facet(grid, cell, pairs, said, views, options.pair);
      if (facet.outcome == FacetOutcome::measured) result.height[cell] = facet.height, result.sigma[cell] = facet.sigma;
    }
  });
  return result;
}

/// Cells of about `edge` on the plane z = depth before the left camera of a rectified pair.
CellGrid grid_before(const BrownCamera& camera, double depth, double edge) {
  CellGrid grid;
  grid.plane.origin = {0, 0, depth};
  grid.plane.axes << 1, 0, 0, 0, -1, 0, 0, 0, -1;  // right, up, towards the camera
  const double left = -camera.cx / camera.fx * depth, right = (camera.width - 1 - camera.cx) / camera.fx * depth;
  const double top = camera.cy / camera.fy * depth, bottom = -(camera.height - 1 - camera.cy) / camera.fy * depth;
  grid.area = {{left, bottom}, {right, top}};
  grid.columns = static_cast<int>((right - left) / edge), grid.rows = static_cast<int>((top - bottom) / edge);
  return grid;
}

/// Disparities of a PFM file, from the top; inf or 0: unknown.
std::vector<float> read_pfm(const std::string& path, int& width, int& height) {
  std::ifstream stream(path, std::ios::binary);
  std::string kind;
  double scale = 0;
  if (!(stream >> kind >> width >> height >> scale) || kind != "Pf" || scale >= 0)
    throw std::runtime_error(path + " is no little-endian grey PFM");
  stream.get();
  std::vector<float> values(static_cast<size_t>(width) * static_cast<size_t>(height)), turned(values.size());
  stream.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(4 * values.size()));
  if (!stream) throw std::runtime_error(path + " ends early");
  for (int y = 0; y < height; ++y)
    std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(y) * width, width,
                turned.begin() + static_cast<std::ptrdiff_t>(height - 1 - y) * width);
  return turned;
}

void pair(const std::string& left, const std::string& right, const std::string& truth_path) {
  int width = 0, height = 0;
  const std::vector<float> truth = read_pfm(truth_path, width, height);
  std::vector<View> views(2);
  std::vector<Pyramid> images = {pyramid_of(read_grey_image(left)), pyramid_of(read_grey_image(right))};
  for (View& view : views) {
    view.camera.width = width, view.camera.height = height;
    view.camera.fx = view.camera.fy = 3.0 * width, view.camera.cx = 0.5 * width, view.camera.cy = 0.5 * height;
  }
  views[1].cam_from_world.translation = {-1, 0, 0};  // a metre to the right
  std::vector<FacetView> both = {{&views[0], &images[0]}, {&views[1], &images[1]}};
  std::vector<double> known;
  for (const float d : truth)
    if (d > 0 && std::isfinite(d)) known.push_back(static_cast<double>(d));
  const double low = quantile(known, 0), high = quantile(known, 1), f = views[0].camera.fx;
  const double depth = 2 * f / (low + high), reach = std::max(f / low - depth, depth - f / high) * 1.02;
  std::printf("%d x %d pixels, disparities %.1f to %.1f px known in %.1f %%\n", width, height, low, high,
              100 * static_cast<double>(known.size()) / static_cast<double>(truth.size()));
  const CellGrid grid = grid_before(views[0].camera, depth, 6 * depth / f);
  FacetOptions sweep;
  sweep.search = reach, sweep.min_views = 2, sweep.max_sigma = 1e3;
  SemiGlobalOptions sgm;
  sgm.pair.search = reach, sgm.pair.max_sigma = 1e3, sgm.pair.matching_sigma = 0.05;
  std::optional<RectifiedPair> rectified = rectified_pair(grid.plane, {0, 0}, views, 0, 1);
  if (!rectified) throw std::runtime_error("the pair cannot be rectified");
  const auto hypotheses = disparity_range(*rectified, grid, reach)->count;
  const auto tell = [&](const char* name, const Heights& found) {
    std::vector<double> errors;
    size_t all = 0, bad = 0, far = 0;
    double within = 0;
    for (size_t cell = 0; cell < grid.size(); ++cell) {
      const Eigen::Vector2d at = grid.middle(cell);
      if (std::isnan(found.height[cell])) {
        const auto map = map_at(views[0], grid.plane, {at.x(), at.y(), 0}, 8);
        if (map && truth[static_cast<size_t>(std::lround(map->pixel.y())) * static_cast<size_t>(width) +
                         static_cast<size_t>(std::lround(map->pixel.x()))] > 0)
          ++all;
        continue;
      }
      const Eigen::Vector3d point = grid.plane.world({at.x(), at.y(), found.height[cell]});
      const auto seen = project(views[0].camera, point);
      if (!seen || seen->x() < 0 || seen->y() < 0 || seen->x() > width - 1 || seen->y() > height - 1) continue;
      const auto d =
          static_cast<double>(truth[static_cast<size_t>(std::lround(seen->y())) * static_cast<size_t>(width) +
                                    static_cast<size_t>(std::lround(seen->x()))]);
      if (!(d > 0) || !std::isfinite(d)) continue;
      ++all;
      const double here = f / point.z(), error = std::abs(here - d);
      errors.push_back(error), bad += error > 1, far += error > 2;
      within += error < 3 * found.sigma[cell] * here / point.z();
    }
    const double count = static_cast<double>(errors.size());
    std::printf(
        "%-22s complete %5.1f %%, |error| median %.3f px, 90 %% below %.2f px, above 1 px %4.1f %%, above 2 px %4.1f "
        "%%, "
        "within 3 sigma %4.1f %%; %.2f s, %.1f ns a pixel and hypothesis\n",
        name, 100 * count / static_cast<double>(all), quantile(errors, 0.5), quantile(errors, 0.9),
        100 * static_cast<double>(bad) / count, 100 * static_cast<double>(far) / count, 100 * within / count,
        found.seconds, 1e9 * found.seconds / (static_cast<double>(width) * height * hypotheses));
  };
  tell("dense.plane_sweep", swept(grid, both, sweep));
  tell("dense.sgm", matched(grid, both, {*rectified}, sgm));
  sgm.pair.refine = false, sgm.pair.matching_sigma = 0.12;
  tell("dense.sgm refine=false", matched(grid, both, {*rectified}, sgm));
}

void fountain(const std::string& folder) {
  const Fountain set = read_fountain(folder);
  const CellGrid grid = [&] {
    CellGrid wall;
    wall.plane = set.wall(8), wall.area = {{-1.6, -1.2}, {1.6, 1.2}}, wall.columns = 71, wall.rows = 53;
    return wall;
  }();
  FacetOptions sweep;
  sweep.search = 0.4, sweep.max_sigma = 0.01;
  SemiGlobalOptions sgm;
  sgm.pair.search = 0.4, sgm.pair.max_sigma = 0.01;
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
    std::printf(
        "%-22s of %zu cells even %zu, odd %zu, both %.0f; |difference| median %.2f mm, 90 %% below %.2f mm, above 20 "
        "mm "
        "%.1f %%; over its sigma median %.2f, within 3 sigma %.0f %%; %.1f s\n",
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
  if (what == "pair" && count == 5)
    pair(arguments[2], arguments[3], arguments[4]);
  else if (what == "fountain" && count == 3)
    fountain(arguments[2]);
  else if (what == "locking" && count == 2)
    locking();
  else
    throw std::runtime_error("usage: stereo_benchmark pair LEFT RIGHT TRUTH.pfm | fountain FOLDER | locking");
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}

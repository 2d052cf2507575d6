#include "published_pair.hpp"

#include <cstdio>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <stdexcept>

#include "both_kinds.hpp"

namespace plumbline::surface {
namespace {

/// Disparities of the left photograph [px]; nan: unknown, or the place is hidden in the right one.
struct Truth {
  int width = 0, height = 0;
  std::vector<double> disparity;
  size_t known = 0, hidden = 0;
  double low = 1e300, high = 0;
  double step = 1e300;  ///< between the values that it is written in [px]
  double at(long x, long y) const {
    if (x < 0 || y < 0 || x >= width || y >= height) return kNan;
    return disparity[static_cast<size_t>(y) * width + x];
  }
  /// Between the four pixels around, or of the nearest one where they lie more than a pixel of disparity apart.
  double at(const Eigen::Vector2d& pixel) const {
    const double nearest = at(std::lround(pixel.x()), std::lround(pixel.y()));
    const double left = std::floor(pixel.x()), top = std::floor(pixel.y()), a = pixel.x() - left, b = pixel.y() - top;
    double sum = 0;
    for (const long j : {0, 1})
      for (const long i : {0, 1}) {
        const double value = at(static_cast<long>(left) + i, static_cast<long>(top) + j);
        if (!(std::abs(value - nearest) <= 1)) return nearest;
        sum += (i == 0 ? 1 - a : a) * (j == 0 ? 1 - b : b) * value;
      }
    return sum;
  }
};

/// Leaves out what a nearer place hides in the right photograph: two that fall on one of its columns.
void leave_out_hidden(Truth& truth) {
  std::vector<double> nearest(static_cast<size_t>(truth.width));
  for (int y = 0; y < truth.height; ++y) {
    double* row = truth.disparity.data() + static_cast<size_t>(y) * truth.width;
    std::fill(nearest.begin(), nearest.end(), 0);
    const auto column = [&](int x) { return std::lround(x - row[x]); };
    for (int x = 0; x < truth.width; ++x)
      if (row[x] > 0 && column(x) >= 0) {
        double& other = nearest[column(x)];
        other = std::max(other, row[x]);
      }
    for (int x = 0; x < truth.width; ++x)
      if (row[x] > 0 && (column(x) < 0 || nearest[column(x)] > row[x] + 1)) row[x] = kNan, ++truth.hidden;
  }
}

Truth read_truth(const std::string& path, double scale) {
  const cv::Mat read = cv::imread(path, cv::IMREAD_UNCHANGED);
  if (read.empty() || read.channels() != 1) throw std::runtime_error(path + " is no image of one channel");
  cv::Mat values;
  read.convertTo(values, CV_64F, 1 / scale);
  Truth truth;
  truth.width = values.cols, truth.height = values.rows;
  for (int y = 0; y < values.rows; ++y)
    for (int x = 0; x < values.cols; ++x) {
      const double d = std::abs(values.at<double>(y, x));
      const bool known = d > 0 && std::isfinite(d);
      truth.disparity.push_back(known ? d : kNan);
      if (known) ++truth.known, truth.low = std::min(truth.low, d), truth.high = std::max(truth.high, d);
    }
  if (truth.known == 0) throw std::runtime_error(path + " has no disparity");
  std::set<double> written;
  for (const double d : truth.disparity)
    if (std::isfinite(d)) written.insert(d);
  double before = -1e300;
  for (const double d : written) truth.step = std::min(truth.step, d - before), before = d;
  leave_out_hidden(truth);
  return truth;
}

/// Cells of `edge` on the plane z = depth before the left camera of a rectified pair.
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

/// A disparity that was measured somewhere in the left photograph, or a hole there.
struct Found {
  Eigen::Vector2d pixel;
  double disparity = kNan, sigma = kNan;  ///< [px]
};

void tell(const char* name, const std::vector<Found>& found, const Truth& truth, double seconds, double reference,
          int hypotheses) {
  std::vector<double> errors, ratios;
  const double rounding = truth.step / std::sqrt(12.0);  // of the published disparities
  size_t all = 0, bad1 = 0, bad2 = 0, within = 0;
  for (const Found& one : found) {
    const double known = truth.at(one.pixel);
    if (std::isnan(known)) continue;
    ++all;
    if (std::isnan(one.disparity)) continue;
    const double error = std::abs(one.disparity - known);
    errors.push_back(error), bad1 += error > 1, bad2 += error > 2;
    ratios.push_back(error / std::hypot(one.sigma, rounding)), within += ratios.back() < 3;
  }
  const auto percent = [](size_t part, size_t whole) {
    return 100 * static_cast<double>(part) / static_cast<double>(std::max<size_t>(1, whole));
  };
  std::printf(
      "%-24s %6zu places, density %5.1f %%, bad-1.0 %5.2f %%, bad-2.0 %5.2f %%, |error| median %.3f px, 90 %% below "
      "%.2f "
      "px, over sigma median %.2f, within 3 "
      "sigma %5.1f %%; %.2f s = %.2f of StereoSGBM, %.1f ns a pixel and hypothesis\n",
      name, all, percent(errors.size(), all), percent(bad1, errors.size()), percent(bad2, errors.size()),
      quantile(errors, 0.5), quantile(errors, 0.9), quantile(ratios, 0.5), percent(within, errors.size()), seconds,
      seconds / reference, 1e9 * seconds / (static_cast<double>(truth.width) * truth.height * hypotheses));
}

/// Heights of the wanted cells as disparities of the left photograph; a hole counts where the cell's middle is.
void add_disparities(const CellGrid& grid, const View& left, const std::vector<char>& wanted, const Heights& heights,
                     std::vector<Found>& all) {
  for (size_t cell = 0; cell < grid.size(); ++cell) {
    if (!wanted[cell]) continue;
    const Eigen::Vector2d at = grid.middle(cell);
    const bool hole = std::isnan(heights.height[cell]);
    const Eigen::Vector3d point = grid.plane.world({at.x(), at.y(), hole ? 0 : heights.height[cell]});
    const auto pixel = project(left.camera, point);
    if (!pixel) continue;
    Found found{*pixel};
    if (!hole)
      found.disparity = left.camera.fx / point.z(), found.sigma = heights.sigma[cell] * found.disparity / point.z();
    all.push_back(found);
  }
}

/// OpenCV's matcher as its own example sets it, on the pair as it is, at the middles of the wanted cells.
void add_opencv_alone(const cv::Mat& left, const cv::Mat& right, const CellGrid& grid, const View& view,
                      const std::vector<char>& wanted, int least, int count, double& seconds, std::vector<Found>& all) {
  constexpr int block = 5;
  const auto matcher = cv::StereoSGBM::create(least, count, block, 8 * block * block, 32 * block * block, 1, 63, 10,
                                              100, 32, cv::StereoSGBM::MODE_SGBM);
  cv::Mat disparity;
  seconds += seconds_of([&] { matcher->compute(left, right, disparity); });
  for (size_t cell = 0; cell < grid.size(); ++cell) {
    if (!wanted[cell]) continue;
    const Eigen::Vector2d at = grid.middle(cell);
    const auto pixel = project(view.camera, grid.plane.world({at.x(), at.y(), 0}));
    const int x = static_cast<int>(std::lround(pixel->x())), y = static_cast<int>(std::lround(pixel->y()));
    Found found{Eigen::Vector2d(x, y)};
    if (disparity.at<std::int16_t>(y, x) > 16 * (least - 1)) found.disparity = disparity.at<std::int16_t>(y, x) / 16.0;
    all.push_back(found);
  }
}

struct Kind {
  const char* name;
  std::vector<Found> found = {};
  double seconds = 0;
};

}  // namespace

void compare_on_published_pair(const std::string& left, const std::string& right, const std::string& truth_path,
                               double scale) {
  cv::setNumThreads(1);
  const Truth truth = read_truth(truth_path, scale);
  std::vector<View> views(2);
  std::vector<Pyramid> images = {pyramid_of(read_grey_image(left)), pyramid_of(read_grey_image(right))};
  const double focal =
      4 * (truth.low + truth.high);  // any will do: rays that meet at some 7° in the middle of the range
  for (size_t k = 0; k < 2; ++k) {
    BrownCamera& camera = views[k].camera;
    camera.width = truth.width, camera.height = truth.height;
    if (images[k].level[0].width != truth.width || images[k].level[0].height != truth.height)
      throw std::runtime_error((k == 0 ? left : right) + " has another size than " + truth_path);
    camera.fx = camera.fy = focal, camera.cx = 0.5 * truth.width, camera.cy = 0.5 * truth.height;
  }
  views[1].cam_from_world.translation = {-1, 0, 0};  // a metre to the right
  const std::vector<FacetView> both = {{&views[0], &images[0]}, {&views[1], &images[1]}};
  const cv::Mat l = cv::imread(left, cv::IMREAD_GRAYSCALE), r = cv::imread(right, cv::IMREAD_GRAYSCALE);
  std::printf("%d x %d pixels, disparities %.1f to %.1f px known in %.1f %%, %.1f %% hidden in the right photograph\n",
              truth.width, truth.height, truth.low, truth.high,
              100 * static_cast<double>(truth.known) / static_cast<double>(truth.disparity.size()),
              100 * static_cast<double>(truth.hidden) / static_cast<double>(truth.disparity.size()));
  // A facade is where it should be to a few hundredths of its distance; such sets reach over a factor of ten. So they
  // are measured in bands of disparity, and every kind is told the band of a place.
  Kind opencv{"StereoSGBM alone"}, sweep{"dense.plane_sweep"}, sgm{"dense.sgm"}, coarse{"dense.sgm refine=false"};
  double hypotheses = 0;
  int bands = 0;
  std::array<int, 6> outcomes{};
  for (double low = truth.low; low < truth.high; low *= 1.25) {
    const double high = std::min(1.25 * low, truth.high * 1.001);
    // Some pixels more than the band, so that nobody is cut at its border.
    const double near = focal / (high + 3), far = focal / std::max(1.0, low - 3);
    const CellGrid grid = grid_before(views[0].camera, 0.5 * (near + far), 3 * (near + far) / focal);
    std::vector<char> wanted(grid.size());
    for (size_t cell = 0; cell < grid.size(); ++cell) {
      const Eigen::Vector2d at = grid.middle(cell);
      const auto map = map_at(views[0], grid.plane, {at.x(), at.y(), 0}, 8);
      const double d = map ? truth.at(map->pixel) : kNan;
      wanted[cell] = d >= low && d < high;
    }
    const auto pair = rectified_pair(grid.plane, {0, 0}, views, 0, 1);
    if (!pair) continue;
    ++bands;
    FacetOptions options;
    options.search = 0.5 * (far - near), options.min_views = 2, options.max_sigma = 1e3;
    SemiGlobalOptions pairs;
    pairs.pair.search = options.search, pairs.pair.max_sigma = 1e3, pairs.pair.matching_sigma = 0.05;
    const int least = static_cast<int>(low) - 3, count = (static_cast<int>(high) + 4 - least + 15) / 16 * 16;
    hypotheses += count;
    add_opencv_alone(l, r, grid, views[0], wanted, least, count, opencv.seconds, opencv.found);
    const auto add = [&](Kind& kind, const Heights& heights) {
      kind.seconds += heights.seconds;
      add_disparities(grid, views[0], wanted, heights, kind.found);
    };
    const Heights by_facets = swept(grid, both, options, wanted);
    for (size_t o = 0; o < outcomes.size(); ++o) outcomes[o] += by_facets.outcomes[o];
    add(sweep, by_facets);
    add(sgm, matched(grid, both, {*pair}, pairs));
    pairs.pair.refine = false, pairs.pair.matching_sigma = 0.12;
    add(coarse, matched(grid, both, {*pair}, pairs));
  }
  std::printf("%d bands of disparity, %.0f hypotheses together\n", bands, hypotheses);
  for (const Kind* kind : {&opencv, &sweep, &sgm, &coarse})
    tell(kind->name, kind->found, truth, kind->seconds, opencv.seconds, static_cast<int>(hypotheses));
  std::printf("dense.plane_sweep:");
  for (size_t o = 0; o < outcomes.size(); ++o)
    std::printf("%s %d %s", o == 0 ? "" : ",", outcomes[o], to_string(static_cast<FacetOutcome>(o)));
  std::printf("\n");
}

}  // namespace plumbline::surface

// Whether what camera.yaml states of a calibration is true: photographs of a board in two halves that are calibrated
// apart, each as calibrate_camera does it, the difference of all parameters over both covariances. 1 per parameter is
// right.
//   calibration_benchmark NAME BOARD.yaml PHOTOGRAPH...
#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <numeric>
#include <optional>
#include <random>
#include <sstream>

#include "base/text/name_order.hpp"
#include "photo/detect/board.hpp"
#include "photo/images/grey_image.hpp"
#include "photo/markers/calibration_parts.hpp"

namespace {

using namespace plumbline;
using namespace plumbline::markers;

struct Seen {
  int width = 0, height = 0;
  std::vector<CalibrationView> views;
};

Seen see(const detect::Board& board, const std::vector<std::string>& photographs) {
  Seen seen;
  for (const std::string& path : photographs) {
    const GreyImage image = read_grey_image(path);
    const detect::SeenBoard found = detect::find_board(image, board);
    if (found.points.size() < 6) {
      std::fprintf(stderr, "%s: %s\n", path.c_str(), found.problem.c_str());
      continue;
    }
    if (seen.width == 0) seen.width = image.width, seen.height = image.height;
    if (image.width != seen.width || image.height != seen.height) continue;
    CalibrationView& view = seen.views.emplace_back();
    view.path = path;
    for (const detect::SeenPoint& p : found.points)
      view.points.push_back({p.board, p.pixel, p.sigma > 0 ? p.sigma : 0.1});
  }
  return seen;
}

/// χ² per parameter with the corners' errors alone, with the scatter of the photographs, and as camera.yaml has it.
using Ratios = std::array<double, 3>;

double chi_squared(const Calibration& a, const Calibration& b, const Eigen::MatrixXd& covariance) {
  std::vector<int> estimated;
  for (int k = 0; k < BrownCamera::parameter_count; ++k)
    if (a.covariance(k, k) > 0 && b.covariance(k, k) > 0) estimated.push_back(k);
  const auto first = a.camera.parameters(), second = b.camera.parameters();
  Eigen::VectorXd d(std::ssize(estimated));
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    const auto k = static_cast<std::size_t>(estimated[i]);
    d(i) = first[k] - second[k];
  }
  return d.dot(covariance(estimated, estimated).ldlt().solve(d)) / static_cast<double>(d.size());
}

std::optional<Ratios> between_halves(const Seen& seen, const std::vector<bool>& second, LensModel lens) {
  std::array<std::vector<CalibrationView>, 2> halves;
  for (std::size_t k = 0; k < seen.views.size(); ++k) halves[second[k]].push_back(seen.views[k]);
  CalibrationOptions options;
  options.bend_sigma = 1e-3;
  try {
    const JudgedCalibration a = calibrate_and_judge(halves[0], seen.width, seen.height, options, lens),
                            b = calibrate_and_judge(halves[1], seen.width, seen.height, options, lens);
    const Calibration &one = a.calibration, &two = b.calibration;
    const double fa = std::pow(shown_too_small_by(a.parts), -2), fb = std::pow(shown_too_small_by(b.parts), -2);
    return Ratios{chi_squared(one, two, one.formal_covariance + two.formal_covariance),
                  chi_squared(one, two, fa * one.covariance + fb * two.covariance),
                  chi_squared(one, two, one.covariance + two.covariance)};
  } catch (const std::runtime_error& error) {
    std::fprintf(stderr, "a half is not calibrated: %s\n", error.what());
    return std::nullopt;
  }
}

/// The later half of `order` is the second part.
std::vector<bool> later_half(const std::vector<std::size_t>& order) {
  std::vector<bool> second(order.size());
  for (std::size_t k = order.size() / 2; k < order.size(); ++k) second[order[k]] = true;
  return second;
}

std::vector<std::size_t> all_of(const Seen& seen) {
  std::vector<std::size_t> order(seen.views.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  return order;
}

std::vector<bool> at_random(const Seen& seen, unsigned seed) {
  std::vector<std::size_t> order = all_of(seen);
  std::mt19937_64 random(seed);
  for (std::size_t k = order.size(); k > 1; --k) std::swap(order[k - 1], order[random() % k]);
  return later_half(order);
}

std::vector<bool> by_name(const Seen& seen) {
  std::vector<std::size_t> order = all_of(seen);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return text::before_by_name(seen.views[a].path, seen.views[b].path);
  });
  return later_half(order);
}

/// From the left of the image to the right, by the middle of the board's points.
std::vector<bool> by_place(const Seen& seen) {
  std::vector<double> middle;
  for (const CalibrationView& view : seen.views) {
    double x = 0;
    for (const CalibrationPoint& p : view.points) x += p.pixel.x() / static_cast<double>(view.points.size());
    middle.push_back(x);
  }
  std::vector<std::size_t> order = all_of(seen);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return middle[a] < middle[b]; });
  return later_half(order);
}

}  // namespace

int main(int count, char** arguments) {
  constexpr unsigned random_halves = 6;
  if (count < 4) return std::fputs("calibration_benchmark NAME BOARD.yaml PHOTOGRAPH...\n", stderr), 2;
  std::stringstream text;
  text << std::ifstream(arguments[2]).rdbuf();
  const Seen seen = see(detect::parse_board(text.str(), arguments[2]), {arguments + 3, arguments + count});
  try {
    CalibrationOptions options;
    options.bend_sigma = 1e-3;
    const JudgedCalibration all = calibrate_and_judge(seen.views, seen.width, seen.height, options);
    const LensModel lens = all.calibration.camera.lens;
    std::printf("%-14s %2zu of %2d %4dx%-4d %-7s %.2f px fx %.1f +- %.1f |", arguments[1], seen.views.size(), count - 3,
                seen.width, seen.height, lens == LensModel::fisheye ? "fisheye" : "brown", all.calibration.rms,
                all.calibration.camera.fx, std::sqrt(all.calibration.covariance(0, 0)));
    const auto print = [&](const std::vector<std::vector<bool>>& splits) {
      Ratios mean{};
      double good = 0;
      for (const auto& second : splits)
        if (const auto ratios = between_halves(seen, second, lens)) {
          for (std::size_t k = 0; k < mean.size(); ++k) mean[k] += (*ratios)[k];
          good += 1;
        }
      if (good > 0)
        std::printf("  %5.2f (%.2f; %.1f)", mean[2] / good, mean[1] / good, mean[0] / good);
      else
        std::printf("  -");
      std::fflush(stdout);
    };
    std::vector<std::vector<bool>> random;
    for (unsigned k = 0; k < random_halves; ++k) random.push_back(at_random(seen, k + 1));
    print(random), print({by_name(seen)}), print({by_place(seen)});
    std::printf("\n");
  } catch (const std::runtime_error& error) {
    std::printf("%-14s %2zu of %2d: %s\n", arguments[1], seen.views.size(), count - 3, error.what());
  }
  return 0;
}

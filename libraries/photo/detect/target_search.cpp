#include "photo/detect/target_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "photo/images/grey_image.hpp"

namespace plumbline::detect {
namespace {

constexpr int kAngles = 24, kRings = 4, kSamples = kAngles * kRings;
constexpr double kRadii[] = {5, 8, 13, 21};  // sizes that are tried [px]
constexpr double kLeastLikeness = 0.7, kLeastSymmetry = 0.5;
constexpr std::size_t kMost = 8;

using Profile = std::array<float, kSamples>;

double angle_of(int k) { return 2 * M_PI * k / kAngles; }
double ring_of(int r, double radius) { return radius * (r + 1.0) / kRings; }

/// Subtracts the mean and divides by the norm; the standard deviation that it had.
double normalise(Profile& p) {
  float mean = 0, square = 0;
  for (const float v : p) mean += v;
  mean /= kSamples;
  for (float& v : p) v -= mean, square += v * v;
  const float norm = std::sqrt(square);
  if (norm > 0)
    for (float& v : p) v /= norm;
  return norm / std::sqrt(static_cast<float>(kSamples));
}

struct Template {
  TargetKind kind;
  double first, second, half_width;  // the last as a share of the radius
  Profile profile;
};

Template drawn(TargetKind kind, double first, double second, double half_width) {
  Template t{kind, first, second, half_width, {}};
  for (int r = 0; r < kRings; ++r)
    for (int k = 0; k < kAngles; ++k) {
      const double rho = ring_of(r, 1);
      const double a = rho * std::sin(angle_of(k) - first), b = rho * std::sin(angle_of(k) - second);
      constexpr double soft = 0.1;  // of an edge, as a share of the radius
      const auto bar = [&](double d) { return std::clamp(0.5 + (half_width - std::abs(d)) / (2 * soft), 0.0, 1.0); };
      t.profile[r * kAngles + k] = static_cast<float>(
          kind == TargetKind::quadrants ? std::clamp(a / soft, -1.0, 1.0) * std::clamp(b / soft, -1.0, 1.0)
                                        : 1 - (1 - bar(a)) * (1 - bar(b)));
    }
  normalise(t.profile);
  return t;
}

/// Both kinds in all directions; lines nearer than 30 degrees to each other are no target that one would measure.
const std::vector<Template>& templates() {
  static const std::vector<Template> all = [] {
    std::vector<Template> result;
    constexpr int steps = 24;
    for (int i = 0; i < steps; ++i)
      for (int j = i + 4; j < steps && j <= i + steps - 4; ++j) {
        const double first = M_PI * i / steps, second = M_PI * j / steps;
        result.push_back(drawn(TargetKind::quadrants, first, second, 0));
        for (const double width : {0.1, 0.2, 0.35})
          result.push_back(drawn(TargetKind::crosshair, first, second, width));
      }
    return result;
  }();
  return all;
}

float grey_at(const GreyImage& image, double x, double y) {
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const float u = static_cast<float>(x - i), v = static_cast<float>(y - j);
  const std::uint8_t* p = &image.pixels[static_cast<std::size_t>(j) * image.width + i];
  const std::uint8_t* q = p + image.width;
  return (1 - v) * ((1 - u) * p[0] + u * p[1]) + v * ((1 - u) * q[0] + u * q[1]);
}

Profile profile_at(const GreyImage& image, const Eigen::Vector2d& centre, double radius) {
  Profile p;
  for (int r = 0; r < kRings; ++r)
    for (int k = 0; k < kAngles; ++k)
      p[r * kAngles + k] = grey_at(image, centre.x() + ring_of(r, radius) * std::cos(angle_of(k)),
                                   centre.y() + ring_of(r, radius) * std::sin(angle_of(k)));
  return p;
}

float product(const Profile& a, const Profile& b) {
  float lanes[8] = {};
  for (std::size_t i = 0; i < kSamples; i += 8)
    for (std::size_t l = 0; l < 8; ++l) lanes[l] += a[i + l] * b[i + l];
  float sum = 0;
  for (const float lane : lanes) sum += lane;
  return sum;
}

/// Correlation of a normalised profile with itself after half a turn.
float symmetry_of(const Profile& p) {
  float sum = 0;
  for (std::size_t r = 0; r < kRings; ++r)
    for (std::size_t k = 0; k < kAngles; ++k) sum += p[r * kAngles + k] * p[r * kAngles + (k + kAngles / 2) % kAngles];
  return sum;
}

bool inside(const GreyImage& image, const Eigen::Vector2d& p, double margin) {
  return p.x() >= margin && p.y() >= margin && p.x() < image.width - 1 - margin && p.y() < image.height - 1 - margin;
}

TargetCandidate best_template(const Profile& profile, TargetKind wanted) {
  TargetCandidate best;
  for (const Template& t : templates()) {
    if (wanted != TargetKind::any && t.kind != wanted) continue;
    const double likeness = product(profile, t.profile);
    if (std::abs(likeness) <= std::abs(best.likeness)) continue;
    best.kind = t.kind, best.first = t.first, best.second = t.second;
    best.half_width = t.half_width, best.likeness = likeness;
  }
  return best;
}

}  // namespace

TargetSearch search_targets(const GreyImage& image, const Eigen::Vector2d& predicted, const TargetFitOptions& options) {
  TargetSearch result;
  std::vector<TargetCandidate> all;
  const int reach = static_cast<int>(std::ceil(options.search));
  const Eigen::Vector2d middle = predicted.array().round();
  for (const double radius : kRadii) {
    if (radius > options.max_radius) break;
    const int step = std::max(1, static_cast<int>(radius / 6));
    for (int y = -reach; y <= reach; y += step)
      for (int x = -reach; x <= reach; x += step) {
        const Eigen::Vector2d centre = middle + Eigen::Vector2d(x, y);
        if (!inside(image, centre, radius + 1)) continue;
        Profile profile = profile_at(image, centre, radius);
        if (normalise(profile) < 0.25 * options.min_contrast) continue;
        result.contrast_seen = true;
        if (symmetry_of(profile) < kLeastSymmetry) continue;
        TargetCandidate c = best_template(profile, options.kind);
        c.centre = centre, c.radius = radius, c.half_width *= radius;
        if (std::abs(c.likeness) > kLeastLikeness) all.push_back(c);
      }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return std::abs(a.likeness) > std::abs(b.likeness); });
  for (const TargetCandidate& c : all) {
    const bool near_another =
        std::any_of(result.candidates.begin(), result.candidates.end(), [&](const TargetCandidate& other) {
          return other.kind == c.kind && (other.centre - c.centre).norm() < 0.6 * std::min(c.radius, other.radius);
        });
    if (!near_another) result.candidates.push_back(c);
    if (result.candidates.size() == kMost) break;
  }
  return result;
}

}  // namespace plumbline::detect

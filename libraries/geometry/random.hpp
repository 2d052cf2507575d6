// A small seeded generator whose numbers are the same with every compiler and library, which std::normal_distribution
// does not promise. Not for cryptography.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string_view>

namespace plumbline {

/// One step of SplitMix64 (Steele, Lea and Flood 2014): a bijection of 64-bit words that passes for a hash.
constexpr std::uint64_t mix_bits(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// The seed of a sub-stream: one for every purpose and item ("survey", "image 7"), so that what one draws does not
/// shift another.
constexpr std::uint64_t derive_seed(std::uint64_t seed, std::string_view purpose, std::uint64_t index = 0) {
  std::uint64_t hash = mix_bits(seed);
  for (const char c : purpose) hash = mix_bits(hash ^ static_cast<std::uint64_t>(static_cast<unsigned char>(c)));
  return mix_bits(hash ^ index);
}

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  Random(std::uint64_t seed, std::string_view purpose, std::uint64_t index = 0)
      : state_(derive_seed(seed, purpose, index)) {}

  std::uint64_t bits() {
    const std::uint64_t value = mix_bits(state_);
    state_ += 0x9e3779b97f4a7c15ULL;
    return value;
  }

  /// In [0, 1), 53 bits.
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }
  double uniform(double lower, double upper) { return lower + (upper - lower) * uniform(); }

  /// Standard normal, by Box and Muller (1958).
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));  // 1 - u lies in (0, 1]
    const double angle = 2.0 * std::numbers::pi * uniform();
    spare_ = radius * std::sin(angle);
    has_spare_ = true;
    return radius * std::cos(angle);
  }
  double normal(double sigma) { return sigma * normal(); }
  Eigen::Vector3d normal3(double sigma) {
    const double x = normal(sigma), y = normal(sigma), z = normal(sigma);  // in this order: arguments have none
    return {x, y, z};
  }

 private:
  std::uint64_t state_;
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace plumbline

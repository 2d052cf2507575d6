// The grey values of a strip along an edge, as columns that loops run through.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace plumbline {
struct GreyImage;
}

namespace plumbline::detect {

/// A straight line that edges are measured from.
struct EdgeFrame {
  Eigen::Vector2d centre, along, across;  ///< [px], unit vectors
  double half_length = 0;                 ///< [px]
  double box = 1;                         ///< width of the pixel's box across the edge [px]
};

EdgeFrame edge_frame(const Eigen::Vector2d& start, const Eigen::Vector2d& end);

/// Where columns and rows lie that do not lie on an even grid (sampling_grid.hpp): column x at x + columns[x mod
/// period], rows alike [px].
struct SamplingGrid {
  static constexpr int kLargestPeriod = 3;
  int period = 1;
  std::array<double, kLargestPeriod> columns{}, rows{};
  double column(int x) const { return columns[x % period]; }
  double row(int y) const { return rows[y % period]; }
};

/// Grey values and light: light = ((grey + a) / (255 + a))^gamma, a growing with gamma from 0 for linear files to
/// sRGB's own curve (IEC 61966-2-1, without its toe below 10 grey values) at 2.4. Blur mixes light, so it is light that
/// the model is fitted to; a residual counts by the grey values that it is at the recorded one, where the noise is.
class TransferCurve {
 public:
  explicit TransferCurve(double gamma);
  double to_light(double grey) const;
  double to_grey(double light) const;
  /// Light by grey value.
  double light_slope(double grey) const;
  float recorded_light(std::uint8_t grey) const { return light_[grey]; }
  /// Grey values that a unit of light is worth there.
  float recorded_weight(std::uint8_t grey) const { return weight_[grey]; }

 private:
  double share(double grey) const;
  double gamma_, offset_;
  std::array<float, 256> light_{}, weight_{};
};

/// Samples as columns, padded with samples of weight 0 to whole groups of kLanes. Single precision: a position of 20 px
/// is held to 1e-6 px, a grey value to 1e-5.
struct EdgeSamples {
  static constexpr std::size_t kLanes = 8;  ///< samples that are worked on side by side

  std::vector<float> t, d;           ///< along [-1, 1] and across [px]
  std::vector<float> light, weight;  ///< see TransferCurve; of record()
  std::vector<std::uint8_t> grey;
  std::size_t count = 0;

  std::size_t padded() const { return (count + kLanes - 1) / kLanes * kLanes; }

  /// Takes every stride-th pixel within `reach` of the edge a + b t + c t² (`shape` [px]), less `margin` at either end
  /// [px]. None if the strip leaves the image. `origin`: what the grid calls column and row (0, 0) of `image`.
  void collect(const GreyImage& image, const EdgeFrame& frame, const Eigen::Vector3d& shape, double margin,
               double reach, std::size_t stride, const SamplingGrid& grid, const Eigen::Vector2i& origin);

  /// Fills `light` and `weight` and pads the columns.
  void record(const TransferCurve& curve);

  /// Keeps the samples for which `wanted(i)` holds; record() has to follow.
  template <class Wanted>
  void keep(Wanted&& wanted) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (!wanted(i)) continue;
      t[kept] = t[i], d[kept] = d[i], grey[kept] = grey[i];
      ++kept;
    }
    count = kept;
  }
};

}  // namespace plumbline::detect

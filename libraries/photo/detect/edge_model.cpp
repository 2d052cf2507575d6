#include "photo/detect/edge_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>

// Eight lanes in whatever registers there are: the same bits with AVX2 and without.
#define PLUMBLINE_CLONES __attribute__((target_clones("avx2", "default")))

namespace plumbline::detect {
namespace {

constexpr std::size_t kLanes = EdgeSamples::kLanes;
// Single precision is summed over this many samples, double precision over the blocks.
constexpr std::size_t kBlock = 512;

using Lanes = float __attribute__((vector_size(4 * kLanes), aligned(4), may_alias));

inline const Lanes& lanes(const float* at) { return *reinterpret_cast<const Lanes*>(at); }

inline double total(const Lanes& sum) {
  double all = 0;
  for (std::size_t l = 0; l < kLanes; ++l) all += static_cast<double>(sum[l]);
  return all;
}

/// The normal distribution function and its density. Density: exp(x) = exp(x / 64)^64; function: Abramowitz and Stegun
/// 26.2.17, to 7.5e-8; both to 1e-6 in single precision. Plain arithmetic, so that loops are vectorised. `far` (6) is
/// no constant, or the compiler computes both branches, one with powers below what single precision holds, at ten times
/// the cost.
inline void normal(float z, float far, float& value, float& density) {
  const float x = std::abs(z) < far ? std::abs(z) : far;
  const float u = x * x * (-0.5f / 64);
  float e = 1 + u * (1 + u * (0.5f + u * (1.0f / 6 + u * (1.0f / 24 + u * (1.0f / 120)))));
  e *= e, e *= e, e *= e, e *= e, e *= e, e *= e;
  density = e * 0.3989422804f;
  const float k = 1 / (1 + 0.2316419f * x);
  const float tail =
      density * k * (0.319381530f + k * (-0.356563782f + k * (1.781477937f + k * (-1.821255978f + k * 1.330274429f))));
  value = z > 0 ? 1 - tail : tail;
}

/// Residuals and derivatives of all samples.
PLUMBLINE_CLONES void fill(const float* __restrict t, const float* __restrict d, const float* __restrict light,
                           const float* __restrict weight, std::size_t count, const float* __restrict p, float blur,
                           float box, float far, float* __restrict residual, float* __restrict by_position,
                           float* __restrict by_blur, float* __restrict by_low, float* __restrict by_high) {
  // The mean of Φ over the box, by its antiderivative z Φ(z) + φ(z).
  const float inverse = 1 / blur, half = 0.5f * box * inverse, by_box = 1 / box, blur_by_box = blur / box;
  const float p0 = p[0], p1 = p[1], p2 = p[2], p4 = p[4], p5 = p[5], p6 = p[6], p7 = p[7];
  for (std::size_t i = 0; i < count; ++i) {
    const float z = (d[i] - (p0 + t[i] * (p1 + t[i] * p2))) * inverse;
    const float from = z - half, to = z + half;
    float value0, value1, density0, density1;
    normal(from, far, value0, density0);
    normal(to, far, value1, density1);
    const float step = blur_by_box * (to * value1 + density1 - from * value0 - density0);
    const float slope = by_box * (value1 - value0);
    const float slope_blur = blur_by_box * (density1 - density0);
    const float low = p4 + p5 * t[i], contrast = p6 + p7 * t[i] - low, w = weight[i];
    residual[i] = w * (light[i] - low - contrast * step);
    by_position[i] = -w * contrast * slope;
    by_blur[i] = w * contrast * slope_blur;
    by_low[i] = w * (1 - step);
    by_high[i] = w * step;
  }
}

/// Sums of the residual times the eight derivatives and itself.
PLUMBLINE_CLONES void sum_gradient(const float* t, const float* residual, const float* by_position,
                                   const float* by_blur, const float* by_low, const float* by_high, std::size_t count,
                                   double* sums) {
  for (std::size_t block = 0; block < count; block += kBlock) {
    Lanes s0{}, s1{}, s2{}, s3{}, s4{}, s5{}, s6{}, s7{}, s8{};
    for (std::size_t i = block; i < std::min(count, block + kBlock); i += kLanes) {
      const Lanes along = lanes(t + i), r = lanes(residual + i);
      const Lanes position = r * lanes(by_position + i), low = r * lanes(by_low + i), high = r * lanes(by_high + i);
      const Lanes turn = along * position;
      s0 += position, s1 += turn, s2 += along * turn;
      s3 += r * lanes(by_blur + i);
      s4 += low, s5 += along * low;
      s6 += high, s7 += along * high;
      s8 += r * r;
    }
    sums[0] += total(s0), sums[1] += total(s1), sums[2] += total(s2);
    sums[3] += total(s3), sums[4] += total(s4), sums[5] += total(s5);
    sums[6] += total(s6), sums[7] += total(s7), sums[8] += total(s8);
  }
}

// The derivatives by a, b, c are P, P t, P t²; by the plateaus and their slopes L, L t and H, H t; by the blur B. So
// the normal matrix holds thirty sums of products of two of P, B, L, H and a power of t.
constexpr std::size_t kPP = 0, kPB = 5, kBB = 8, kPL = 9, kPH = 13, kBL = 17, kBH = 19, kLL = 21, kLH = 24, kHH = 27,
                      kProducts = 30;

/// `sums`: kProducts sums, powers of t rising.
PLUMBLINE_CLONES void sum_products(const float* t, const float* by_position, const float* by_blur, const float* by_low,
                                   const float* by_high, std::size_t count, double* sums) {
  for (std::size_t block = 0; block < count; block += kBlock) {
    // Three loops, so that the sums of each stay in registers.
    const std::size_t end = std::min(count, block + kBlock);
    Lanes pp0{}, pp1{}, pp2{}, pp3{}, pp4{}, pb0{}, pb1{}, pb2{}, bb{};
    for (std::size_t i = block; i < end; i += kLanes) {
      const Lanes along = lanes(t + i), p = lanes(by_position + i), b = lanes(by_blur + i);
      const Lanes p1 = along * p, p2 = along * p1;
      pp0 += p * p, pp1 += p * p1, pp2 += p1 * p1, pp3 += p1 * p2, pp4 += p2 * p2;
      pb0 += p * b, pb1 += p1 * b, pb2 += p2 * b;
      bb += b * b;
    }
    Lanes pl0{}, pl1{}, pl2{}, pl3{}, ph0{}, ph1{}, ph2{}, ph3{};
    for (std::size_t i = block; i < end; i += kLanes) {
      const Lanes along = lanes(t + i), p = lanes(by_position + i), p1 = along * p, p2 = along * p1;
      const Lanes low = lanes(by_low + i), high = lanes(by_high + i), low1 = along * low, high1 = along * high;
      pl0 += p * low, pl1 += p1 * low, pl2 += p2 * low, pl3 += p2 * low1;
      ph0 += p * high, ph1 += p1 * high, ph2 += p2 * high, ph3 += p2 * high1;
    }
    Lanes bl0{}, bl1{}, bh0{}, bh1{}, ll0{}, ll1{}, ll2{}, lh0{}, lh1{}, lh2{}, hh0{}, hh1{}, hh2{};
    for (std::size_t i = block; i < end; i += kLanes) {
      const Lanes along = lanes(t + i), b = lanes(by_blur + i);
      const Lanes low = lanes(by_low + i), high = lanes(by_high + i), low1 = along * low, high1 = along * high;
      bl0 += b * low, bl1 += b * low1, bh0 += b * high, bh1 += b * high1;
      ll0 += low * low, ll1 += low * low1, ll2 += low1 * low1;
      lh0 += low * high, lh1 += low * high1, lh2 += low1 * high1;
      hh0 += high * high, hh1 += high * high1, hh2 += high1 * high1;
    }
    const Lanes* const all[kProducts] = {&pp0, &pp1, &pp2, &pp3, &pp4, &pb0, &pb1, &pb2, &bb,  &pl0,
                                         &pl1, &pl2, &pl3, &ph0, &ph1, &ph2, &ph3, &bl0, &bl1, &bh0,
                                         &bh1, &ll0, &ll1, &ll2, &lh0, &lh1, &lh2, &hh0, &hh1, &hh2};
    for (std::size_t k = 0; k < kProducts; ++k) sums[k] += total(*all[k]);
  }
}

}  // namespace

EdgeGradient evaluate(const EdgeSamples& samples, const EdgeParameters& p, double box, EdgeColumns& columns) {
  const std::size_t count = samples.padded();
  for (auto* column : {&columns.residual, &columns.position, &columns.blur, &columns.low, &columns.high})
    if (column->size() < count) column->resize(count);
  const Eigen::Matrix<float, 8, 1> single = p.cast<float>();
  fill(samples.t.data(), samples.d.data(), samples.light.data(), samples.weight.data(), count, single.data(),
       static_cast<float>(std::exp(p[3])), static_cast<float>(box), 6.0f, columns.residual.data(),
       columns.position.data(), columns.blur.data(), columns.low.data(), columns.high.data());
  std::array<double, 9> sums{};
  sum_gradient(samples.t.data(), columns.residual.data(), columns.position.data(), columns.blur.data(),
               columns.low.data(), columns.high.data(), count, sums.data());
  EdgeGradient gradient;
  for (int k = 0; k < 8; ++k) gradient.right[k] = sums[k];
  gradient.sum = sums[8];
  return gradient;
}

EdgeNormal normal_matrix(const EdgeSamples& samples, const EdgeColumns& columns) {
  std::array<double, kProducts> sums{};
  sum_products(samples.t.data(), columns.position.data(), columns.blur.data(), columns.low.data(), columns.high.data(),
               samples.padded(), sums.data());
  EdgeNormal normal;
  const auto set = [&](int row, int column, std::size_t product) {
    normal(row, column) = normal(column, row) = sums[product];
  };
  for (int i = 0; i < 3; ++i) {
    const auto power = static_cast<std::size_t>(i);
    for (int k = 0; k <= i; ++k) set(i, k, kPP + power + static_cast<std::size_t>(k));
    set(i, 3, kPB + power);
    for (int k = 0; k < 2; ++k) {
      set(i, 4 + k, kPL + power + static_cast<std::size_t>(k));
      set(i, 6 + k, kPH + power + static_cast<std::size_t>(k));
    }
  }
  set(3, 3, kBB);
  for (int i = 0; i < 2; ++i) {
    const auto power = static_cast<std::size_t>(i);
    set(3, 4 + i, kBL + power);
    set(3, 6 + i, kBH + power);
    for (int k = 0; k < 2; ++k) {
      set(4 + i, 4 + k, kLL + power + static_cast<std::size_t>(k));
      set(4 + i, 6 + k, kLH + power + static_cast<std::size_t>(k));
      set(6 + i, 6 + k, kHH + power + static_cast<std::size_t>(k));
    }
  }
  return normal;
}

}  // namespace plumbline::detect

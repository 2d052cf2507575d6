// Whitened residuals with their derivatives: what a block model is made of. Derivatives of a templated functor come
// from dual numbers (Ceres' Jet, a header): no solver is linked for them.
#pragma once

#include <ceres/jet.h>

#include <algorithm>
#include <array>
#include <memory>
#include <numeric>
#include <utility>

namespace plumbline::block {

class CostFunction {
 public:
  explicit CostFunction(int residual_count) : residual_count_(residual_count) {}
  virtual ~CostFunction() = default;
  CostFunction(const CostFunction&) = delete;
  CostFunction& operator=(const CostFunction&) = delete;

  int residual_count() const { return residual_count_; }
  /// Residuals at `parameters`, an array for each block of them, and where `jacobians` is not null their derivatives by
  /// each block, row by row. False where the function has no value.
  virtual bool evaluate(const double* const* parameters, double* residuals, double* const* jacobians) const = 0;

 private:
  int residual_count_;
};

/// `Functor` has bool operator()(const T* block, ..., T* residuals) const for any number T, with blocks of kSizes
/// values.
template <typename Functor, int kRows, int... kSizes>
class DifferentiatedCost : public CostFunction {
 public:
  /// Takes the functor over.
  explicit DifferentiatedCost(Functor* functor) : CostFunction(kRows), functor_(functor) {}

  bool evaluate(const double* const* parameters, double* residuals, double* const* jacobians) const override {
    constexpr auto blocks = std::make_index_sequence<sizeof...(kSizes)>();
    return jacobians ? with_derivatives(parameters, residuals, jacobians, blocks) : call(parameters, residuals, blocks);
  }

 private:
  static constexpr int kCount = (kSizes + ...);
  using Jet = ceres::Jet<double, kCount>;

  template <typename T, std::size_t... kBlock>
  bool call(const T* const* parameters, T* residuals, std::index_sequence<kBlock...>) const {
    return (*functor_)(parameters[kBlock]..., residuals);
  }

  template <typename Blocks>
  bool with_derivatives(const double* const* parameters, double* residuals, double* const* jacobians,
                        Blocks blocks) const {
    constexpr std::array<int, sizeof...(kSizes)> sizes = {kSizes...};
    std::array<Jet, kCount> values;
    std::array<const Jet*, sizeof...(kSizes)> starts;
    int next = 0;
    for (std::size_t b = 0; b < sizes.size(); ++b) {
      starts[b] = values.data() + next;
      for (int i = 0; i < sizes[b]; ++i, ++next) values[static_cast<std::size_t>(next)] = Jet(parameters[b][i], next);
    }
    std::array<Jet, kRows> rows;
    if (!call(starts.data(), rows.data(), blocks)) return false;
    int first = 0;
    for (std::size_t b = 0; b < sizes.size(); first += sizes[b++])
      for (int r = 0; r < kRows; ++r)
        for (int i = 0; i < sizes[b]; ++i)
          jacobians[b][r * sizes[b] + i] = rows[static_cast<std::size_t>(r)].v[first + i];
    for (int r = 0; r < kRows; ++r) residuals[r] = rows[static_cast<std::size_t>(r)].a;
    return true;
  }

  std::unique_ptr<Functor> functor_;
};

}  // namespace plumbline::block

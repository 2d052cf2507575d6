// Observations as whitened rows with their derivatives in the unknowns of Layout, all written out. Rows are
// "computed minus observed", multiplied by the whitening and divided by their group's sigma factor.
#pragma once

#include <Eigen/Core>

#include "photo/bundle/problem.hpp"

namespace plumbline::bundle {

/// Rows of one observation and their derivatives by up to seven blocks of unknowns, parts side by side in one row-major
/// matrix; parts of held blocks are left out. What is shared by many observations stands side by side.
struct Rows {
  // image 6, camera 12, shift 2, scale, inset, form 5, plate 6; of a point mount 6, bend 2, point 3 behind the shift
  static constexpr int max_rows = 8, max_parts = 7, stride = 36;
  struct Part {
    int block = 0, size = 0;
    int column = 0;
  };
  int rows = 0, parts = 0, columns = 0;
  std::array<Part, max_parts> part;
  std::array<double, max_rows> residual;
  std::array<double, max_rows * stride> storage;

  auto values() const { return Eigen::Map<const Eigen::VectorXd>(residual.data(), rows); }
  auto jacobian(int k) const {
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const Part& p = part[k];
    return Eigen::Map<const RowMajor, 0, Eigen::OuterStride<stride>>(storage.data() + p.column, rows, p.size);
  }
};

/// False if the point is not in front of the camera. Without `jacobians` only the residuals are filled.
bool evaluate(const Problem& problem, const Layout& layout, const State& state, const ImagePoint& term, bool jacobians,
              Rows& rows);
bool evaluate(const Problem& problem, const Layout& layout, const State& state, const ImageTag& term, bool jacobians,
              Rows& rows);
bool evaluate(const Problem& problem, const Layout& layout, const State& state, const Distance& term, bool jacobians,
              Rows& rows);

/// Squared norm of a tag's whitened residuals and half of its derivatives, Jᵀ r: what rows would give, at a third of
/// the work.
struct TagGradient {
  double squares = 0;
  Eigen::Matrix<double, 6, 1> by_image, by_plate;
  Eigen::Matrix<double, max_interior, 1> by_interior;  ///< by all values of the camera
  Eigen::Vector2d by_shift;
  double by_scale = 0, by_inset = 0;
  Eigen::Matrix<double, form_count, 1> by_form;
};
/// False if a corner is not in front of the camera.
bool gradient_of(const Problem& problem, const State& state, const ImageTag& term, TagGradient& gradient);

/// Linear terms have any number of rows: residuals, and the dense Jacobian by the unknowns in `columns`.
struct KnownRows {
  Eigen::VectorXd residual;
  Eigen::MatrixXd jacobian;
  std::vector<int> columns;  ///< unknowns, see Layout
  std::vector<int> blocks;   ///< they belong to
};
KnownRows evaluate(const Problem& problem, const Layout& layout, const State& state, const Known& term);
/// Its parts. Which columns of the whitening belong to which unknowns, and the residuals alone: the derivatives are the
/// same at every state. `whitening` is the term's over its group's factor.
void linear_columns(const Problem& problem, const Layout& layout, const Known& term, std::vector<int>& chosen,
                    std::vector<int>& unknowns);
Eigen::VectorXd residual_of(const Problem& problem, const State& state, const Known& term,
                            const Eigen::MatrixXd& whitening);

/// Image point in the unit of the camera of what lies at `v` in the camera frame, by the brown and balanced models.
Eigen::Vector2d computed_image_point(const Camera& camera, const Interior& interior, const Eigen::Vector3d& v);

}  // namespace plumbline::bundle

#include "photo/block/tag_block_orientations.hpp"

#include <Eigen/SparseCore>
#include <algorithm>
#include <numeric>

namespace plumbline::block {
namespace {

using bundle::Kind;

/// The matrix that turns unknowns of some blocks into orientations, part by part.
struct ByUnknowns {
  std::vector<int> blocks;
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::Index columns = 0;
  void add(int block, Eigen::Index row, const Eigen::MatrixXd& part) {
    for (Eigen::Index r = 0; r < part.rows(); ++r)
      for (Eigen::Index c = 0; c < part.cols(); ++c)
        if (part(r, c) != 0) entries.emplace_back(static_cast<int>(row + r), static_cast<int>(columns + c), part(r, c));
    blocks.push_back(block);
    columns += part.cols();
  }
};

}  // namespace

RigidTransform pose_of(const TagModel& model, size_t image) {
  const bundle::Placement& p = model.state.images[image];
  return {p.rotation, -(p.rotation * (p.position + model.origin))};
}

Matrix6 pose_by_unknowns(const TagModel& model, size_t image) {
  Matrix6 jacobian = Matrix6::Zero();
  jacobian.topRightCorner<3, 3>().setIdentity();
  jacobian.bottomLeftCorner<3, 3>() = -model.state.images[image].matrix;
  jacobian.bottomRightCorner<3, 3>() = -skew(pose_of(model, image).translation);
  return jacobian;
}

Eigen::MatrixXd joint_orientations(const std::vector<int>& images, int cameras, const TagModel& model,
                                   const bundle::Layout& layout, const bundle::Cofactors& cofactors) {
  constexpr Eigen::Index per_image = 8, per_camera = BrownCamera::parameter_count;
  std::vector<size_t> order(images.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return images[a] < images[b]; });
  ByUnknowns by;
  for (size_t k = 0; k < order.size(); ++k) {
    const int image = static_cast<int>(order[k]);
    const Eigen::Index row = per_image * static_cast<Eigen::Index>(k);
    by.add(layout.block({Kind::image, image}), row, pose_by_unknowns(model, order[k]));
    if (model.problem.images[order[k]].shift_free)
      by.add(layout.block({Kind::shift, image}), row + 6, Eigen::Matrix2d::Identity());
  }
  const Eigen::Index of_cameras = per_image * static_cast<Eigen::Index>(images.size());
  for (int c = 0; c < cameras; ++c) {
    const std::vector<int>& values = layout.free_values(c);
    if (values.empty()) continue;
    Eigen::MatrixXd part = Eigen::MatrixXd::Zero(per_camera, static_cast<Eigen::Index>(values.size()));
    for (size_t v = 0; v < values.size(); ++v)  // distance terms have no place among the nine
      if (values[v] < per_camera) part(values[v], static_cast<Eigen::Index>(v)) = 1;
    by.add(layout.block({Kind::camera, c}), of_cameras + per_camera * c, part);
  }
  Eigen::SparseMatrix<double> matrix(of_cameras + per_camera * cameras, by.columns);
  matrix.setFromTriplets(by.entries.begin(), by.entries.end());
  return matrix * cofactors.joint(by.blocks) * matrix.transpose();
}

}  // namespace plumbline::block

// What nodes about the Cramér-Rao bound of images of marker plates are given: ports, parameters, and the problem they
// state (block/tag_bound.hpp).
#pragma once

#include <map>
#include <string>
#include <vector>

#include "artifacts/camera.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "photo/block/tag_bound.hpp"
#include "plumbline/node.hpp"

namespace plumbline::judgement {

std::map<std::string, const PointT*> by_id(const PointsT& points);

/// What a covariance lets one expect of the heights of some anchors.
struct Prospects {
  double drift = 0;                   ///< sigma of D(F), equation (2) [m]
  double relative_drift = 0;          ///< sigma of r_F - r_1 [m]
  std::vector<double> height_sigmas;  ///< [m]

  double within(double tolerance) const;  ///< expected share (10) within the tolerance [m]
};

struct BoundInputs : Node {
  List<ImageTags> observations{"observations", "which tags are in which image, with the covariance of their corners"};
  List<Poses> poses{"poses", frame("frame=?F"), "of the images; true ones, or any good estimate"};
  In<Camera> camera{"camera", "interior orientation; its covariance is the prior"};
  In<Plates> plates{"plates", frame("frame=?F"), "which tag stands for which anchor"};
  In<Points> points{"points", frame("frame=?F"), "the anchors; true ones, or any good estimate; roles say which count"};
  In<Points> control{"control", frame("frame=?F"),
                     "surveyed anchors with their covariance; those with role check are not control"};
  Param<double> corner_sigma{"corner_sigma", 0.1, "px", between(1e-4, 100), "of a corner whose detector gives none"};
  Param<double> tag_scale_sigma{"tag_scale_sigma", 1e-3, "1", at_least(0),
                                "prior of a print batch's relative tag size, as the adjustment has it"};
  Param<std::string> self_calibration{"self_calibration", "prior", one_of("off", "prior", "free"),
                                      "as the adjustment has it"};

 protected:
  block::BoundProblem problem(Context& context) const;

  /// Plates whose anchors have the role check and are in an image, by their index in the problem.
  std::vector<std::size_t> check_anchors(const block::BoundProblem& given, const Eigen::MatrixXd& covariance) const;

  Prospects prospects(const block::BoundProblem& given, const Eigen::MatrixXd& covariance,
                      const std::vector<std::size_t>& wanted) const;

 private:
  void add_tags(Context& context, block::BoundProblem& problem, const PlatesT& table) const;
};

}  // namespace plumbline::judgement

// evaluate.crlb: ports and parameters.
#pragma once

#include "artifacts/camera.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "judgement/tag_bound.hpp"
#include "plumbline/node.hpp"

namespace plumbline::evaluate {

struct EvaluateCrlb : Node {
  static constexpr Info info{"evaluate.crlb", "", 1,
                             "Cramér-Rao bound of anchors in images of marker plates under control: the best that any "
                             "unbiased adjustment of these observations can do"};
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
  Out<Points> bound{"bound", frame("frame=?F"), "the anchors with the bound as their covariance"};

  void run(Context& context) override;

 private:
  BoundProblem problem(Context& context) const;
  void add_tags(Context& context, BoundProblem& problem, const PlatesT& table) const;
  void tell_prospects(Context& context, const BoundProblem& given, const Eigen::MatrixXd& covariance,
                      const PointsT& anchors) const;
};

}  // namespace plumbline::evaluate

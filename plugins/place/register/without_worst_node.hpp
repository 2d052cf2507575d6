// register.without_worst: one step of an iterated search for outliers, see pipelines/outlier_search.yaml.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "artifacts/points.hpp"
#include "artifacts/transform.hpp"
#include "plumbline/node.hpp"

namespace plumbline::registration {

/// Data snooping (Baarda 1968): of the points of a registration the one with the largest residual over its standard
/// deviation is taken out, if that is above a bound. One at a time, because an outlier spoils the residuals of others.
struct WithoutWorst : Node {
  static constexpr Info info{"register.without_worst", "", 1,
                             "Makes the point that a registration contradicts most a check point; the next round "
                             "registers without it"};
  In<Points> points{"points", frame("frame=?T"), "control of the registration"};
  In<Transform> transform{"transform", frame("to=?T,from=?S"), "the registration to it"};
  Out<Points> kept{"points", frame("frame=?T"), "the control; one more of it has the role check, or none"};
  Param<double> above{"above", 3.29, "sigma", at_least(0),
                      "residual of a coordinate over its standard deviation; 3.29: one sound coordinate of 1000"};

  void run(Context& context) override {
    PointsT control = points.unpack();
    const TransformT fit = transform.unpack();
    double largest = 0;
    std::string worst;
    for (const auto& residual : fit.residuals) {
      const double w = residual->w.cwiseAbs().maxCoeff();
      if (w > largest) largest = w, worst = residual->id;  // a w that is nan says nothing
    }
    const bool is_outlier = largest > *above;
    const auto found = std::find_if(control.points.begin(), control.points.end(),
                                    [&](const auto& point) { return point->id == worst; });
    if (is_outlier && found == control.points.end())
      throw std::runtime_error("the registration has the point '" + worst +
                               "', and 'points' has not: connect the points that it was registered to");
    if (is_outlier) {
      (*found)->role = "check";
      context.info("left out: " + worst + ", " + std::to_string(largest) + " sigma");
    }
    context.metric("left_out", is_outlier ? 1 : 0, "1");
    context.metric("largest_w", largest, "1");
    kept.commit(control);
  }
};

}  // namespace plumbline::registration

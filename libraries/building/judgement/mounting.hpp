// Where plates sit on their anchors: survey and photographs see the plate, a tolerance is meant of the anchor. What a
// plate is off by stays unseen; its standard deviation is part of the anchor's, and of nothing that is measured.
#pragma once

#include <Eigen/Geometry>
#include <set>
#include <string>
#include <vector>

#include "building/ifc/selection.hpp"

namespace plumbline::judgement {

/// Standard deviations along the plate's axes: right and up as one looks at it, out of it [m]; nan: left as it was.
struct MountingRule {
  ifc::Selection selection;
  Eigen::Vector3d sigma;
  std::string text;
};

/// "class=IfcMechanicalFastener & batch=march: right=0.3mm, up=0.3mm, out=1mm". Throws std::runtime_error that quotes
/// the rule and says what is expected.
MountingRule parse_mounting(const std::string& text);

struct Mounting {
  double sigma = 0;                 ///< [m] on each axis, where nothing else is said
  std::vector<MountingRule> rules;  ///< go before what the plate table says; later rules before earlier ones

  /// Covariance [m²] in the frame of `frame_from_plate`. `of_plate`: as the plate table gives it, else empty. Plates
  /// are taken as mounted one by one: no correlation between anchors.
  Eigen::Matrix3d covariance(const ifc::ElementFacts& anchor, const std::vector<double>& of_plate,
                             const Eigen::Quaterniond& frame_from_plate) const;
  /// Of the rules that select an anchor, in their order: those that give at least one of its axes.
  std::set<std::size_t> that_hold(const std::vector<std::size_t>& selecting) const;
  /// What was put in, for the reader; empty if that is nothing. `from_table`: plates with values of their own.
  std::string words(std::size_t from_table) const;
};

}  // namespace plumbline::judgement

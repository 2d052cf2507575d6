// One judgement in all its outputs: what tests of agreement share.
#pragma once

#include <array>
#include <string>

#include "building/ifc/design.hpp"
#include "small_building.hpp"

namespace plumbline::judgement {

struct Campaign {
  std::string bytes;
  ifc::Design design;
  AccuracyT accuracy;
  DeviationT deviation;
};

/// That the artifact, metrics.json, metrics.csv, metrics.xml, stake_out.csv, the as-built IFC, the BCF, the summary and
/// the page say the same of every anchor, panel and floor. `seen` counts the anchors' verdicts.
void expect_agreement(const Campaign& campaign, const std::string& epoch, std::array<int, 4>& seen);

}  // namespace plumbline::judgement

// simulate.scan: points of a scanner on panels as they are.
#pragma once

#include "artifacts/file.hpp"
#include "artifacts/surfaces.hpp"
#include "plumbline/node.hpp"

namespace plumbline::simulate {

struct SimulateScan : Node {
  static constexpr Info info{
      "simulate.scan", "", 2,
      "Simulates a scanner's cloud of panels: a beam without extent, noise of the range, a place "
      "that is off as a whole"};
  In<Surfaces> surfaces{"surfaces", frame("frame=?F"),
                        "panels as they are; glass has no points, between panels lies what is behind them"};
  Param<double> pitch{"pitch", 0.003, "m", between(0.0005, 1), "between points"};
  Param<double> noise{"noise", 0.001, "m", between(0, 0.1), "of the range, across the panels"};
  Param<double> place_sigma{"place_sigma", 0.0002, "m", between(0, 0.1), "of the scan's place as a whole, each axis"};
  Param<double> recess{"recess", 0.03, "m", between(0, 1), "of what lies in the joints, behind the design's face"};
  Out<File> scan{"scan", "the cloud, LAS 1.4, by reference"};

  void run(Context& context) override;
};

}  // namespace plumbline::simulate

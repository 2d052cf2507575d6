// Which way facades face where the design leaves it open and plates say it.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "building/ifc/facade_frame.hpp"
#include "building/judgement/deviation.hpp"

namespace plumbline::judgement {

/// What plates say of the facades that they stand on.
class PlateSides {
 public:
  /// A plate has settled which way `anchor` faces; `by_design`: as the design had it.
  void add(const ifc::FacadeFrame& by_design, const ifc::FacadeFrame& anchor) {
    if (anchor.source == ifc::FacadeSource::plate && by_design.known())
      sides_[by_design.facade].push_back(!anchor.confirmed ? 0 : anchor.out.dot(by_design.out));
  }

  /// The plates may have turned what the design left open: facades are grouped anew, and what no plate stands at
  /// follows those of its facade that have one; panels follow their anchors.
  void group(DeviationInputs& inputs) const;

 private:
  void follow_facade(ifc::FacadeFrame& frame) const;

  std::map<std::string, std::vector<double>> sides_;  // by facade of the design: cosines of the plates to it
};

}  // namespace plumbline::judgement

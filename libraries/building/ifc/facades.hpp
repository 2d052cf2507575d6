// Facades as objects: every anchor and panel of a design gets a frame of its own, and those that continue one another
// are one facade. Flat, folded, curved, several, set back, courtyards, soffits.
//
// Each source (FacadeSource) tells the direction, or only the line across the facade, or only on which of its sides the
// outside is. The strongest that fits what is stronger still gives the direction. Where the sources that tell the sides
// apart contradict one another, or only a guess is left, the frame is not confirmed: nobody may be sent the wrong way.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "building/ifc/facade_frame.hpp"
#include "building/ifc/selection.hpp"

namespace plumbline::ifc {

struct Design;

/// One line of the user's: "name~^N-: azimuth=0deg, name=North", "storey=Roof: out=up", "*: confirmed".
struct FacadeRule {
  Selection selection;
  std::optional<Eigen::Vector3d> out;  ///< unit vector, frame of the design
  bool confirmed = false;              ///< what was guessed is right
  std::string name;                    ///< of the facade; empty: it gets one
  std::string text;
};

/// Throws std::runtime_error that quotes the rule and says what is expected: azimuth (clockwise from the y axis of the
/// design, deg or gon) with or without tilt (upward positive), out=up or out=down, name, confirmed.
FacadeRule parse_facade_rule(const std::string& text);

/// A facade: what continues in one direction or bends steadily, without a step of more than kFacadeStep.
struct Facade {
  std::string name;
  Eigen::Vector3d out = Eigen::Vector3d::Zero();     ///< mean of its elements, unit vector
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< of its elements [m]
  double bend = 0;                                   ///< largest angle of an element to `out` [rad]
  int anchors = 0, panels = 0;
  FacadeSource source = FacadeSource::none;  ///< the weakest of its elements
  bool confirmed = true;                     ///< all of them are
  std::string note;                          ///< of the first that is not
};

/// An anchor or panel for the grouping.
struct Facing {
  Eigen::Vector3d position;  ///< [m]
  FacadeFrame* frame;
  bool is_panel;
};

inline constexpr double kFacadeStep = 1.5;  ///< [m]

/// Puts what continues one another into facades, in the order of the first element of each, and writes the names into
/// the frames. Those that a rule has named keep the name. What faces nowhere belongs to none.
std::vector<Facade> group_facades(const std::vector<Facing>& elements);

/// Gives every anchor and panel its frame, and the design its facades. Rules go before everything, later ones before
/// earlier ones. Throws std::runtime_error for a rule that selects no anchor and no panel, unless not `all_select`.
void assign_facades(Design& design, const std::vector<FacadeRule>& rules, bool all_select = true);

/// Takes what the plate at an anchor says into its frame: `out` of the plate, true to a few degrees. It goes before all
/// but rules; what it contradicts is no longer confirmed. Where it would not if its azimuth counted from `true_north`
/// (that of the design, clockwise from y [rad]; nan: not said), it is that of a compass, and the frame stays as it was
/// until somebody confirms it; a mere guess is corrected by a plate that is along or across it, whatever the north.
void add_plate(FacadeFrame& frame, const Eigen::Vector3d& out, double true_north = FacadeFrame::nan);

/// An anchor or panel with the facade that it is in, for a rule that selects all of one facade.
struct FacadeMember {
  std::string facade;  ///< its name
  ElementFacts element;
  const FacadeFrame* frame;
};

/// What a reader must do before orders are given: which facades are not confirmed, why, and the whole command. Empty:
/// all are. `members`: all anchors and panels, those of confirmed facades too. The rule in the command says a direction
/// and selects this facade alone: it acts on the design before any plate is seen, and what it confirmed would be
/// another direction than the one that is told.
std::vector<std::string> facade_warnings(const std::vector<Facade>& facades, const std::vector<FacadeMember>& members);

}  // namespace plumbline::ifc

// Campaigns of one building compared: what was mended, opened again, moved, and what nobody has measured again.
#pragma once

#include <array>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "artifacts/as_built_changes.hpp"
#include "artifacts/deviation.hpp"

namespace plumbline::judgement {

/// An anchor or panel as a campaign left it, or one quantity of a panel's surface or of a joint. Lengths in m, in the
/// frame of the design.
struct EpochItem {
  std::string kind, id, guid, facade;  ///< as in AsBuiltChange
  int floor = 0;
  ToleranceVerdict verdict = ToleranceVerdict::not_measured;
  bool was_open = false;  ///< some campaign up to this one found it failing or undecided
  Eigen::Vector3d design = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  Eigen::Vector3d position = design;                                   ///< nan: not measured, or a panel
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Constant(design.x());  ///< nan: unknown
  std::map<std::string, std::array<double, 2>> limits = {};            ///< by axis: above and below [m]; empty: unknown
  std::string topic = {}, quantity = {};  ///< of a surface or joint; topic: as in AsBuiltChange
  double value = design.x();              ///< of a surface or joint; nan: not judged
  /// Of a panel: its joints that failed or were undecided, by the neighbour's GlobalId.
  std::map<std::string, ToleranceVerdict> open_joints = {};
  std::string guid_before = {};  ///< of one that was found again under another GlobalId: what it was (find_again)
  bool open() const { return verdict == ToleranceVerdict::fail || verdict == ToleranceVerdict::undecided; }
};

/// What a campaign found that is no anchor's or panel's own (ifc/findings.hpp).
struct EpochFinding {
  std::string topic, title, kind, facade;  ///< as in FindingChange
  int floor = 0;
  std::vector<std::string> anchors = {};  ///< that share a shift: GlobalIds, of what has none its id
  bool open = true;                       ///< false: some campaign before this one found it
};

/// What a later campaign needs to know of this one.
struct EpochRecord {
  std::string epoch, design_file;
  double tau = std::numeric_limits<double>::quiet_NaN(), risk = tau;
  std::vector<EpochItem> items;
  std::vector<EpochFinding> findings = {};
};

/// What the design of a campaign has: without it nothing is known to have left the building.
struct DesignElements {
  std::set<std::string> guids, names;
};

/// A design that was exported again may give its elements new GlobalIds. What has one that this campaign does not know,
/// and whose name (or tag, by which its anchor is called) occurs once in both, takes over the new one where the place
/// is the same too: of an anchor the designed one, of a panel its floor and facade.
void find_again(const DeviationT& after, EpochRecord& before, const DesignElements* design = nullptr);

/// What the campaign leaves behind. A panel that passes is left open by a joint that was open and was not judged again,
/// because its neighbour was not measured. What the campaign did not measure keeps the verdict that `before` knew
/// (null: no campaign before), so that nothing open is lost in a campaign that looked at one floor only; and places of
/// a measurement that is not to be trusted are left to `before`: nothing is compared with them.
/// What the design no longer has is forgotten unless it was open, and a joint to it is no joint. Findings of `before`
/// are kept by what compare_findings says of them, those that are settled too, so that one that comes back is known.
/// `changes`: what compare_epochs found between the two: what it keeps open though it passes is left so.
EpochRecord record_of(const DeviationT& deviation, const std::string& epoch, const EpochRecord* before = nullptr,
                      const DesignElements* design = nullptr, const AsBuiltChangesT* changes = nullptr);

/// Compares by GlobalId, else by id. Movements by a chi-squared test of 3 degrees of freedom on the sum of the
/// covariances, at 5 % for all anchors together (Bonferroni). Where more than half have moved, and at least nine tenths
/// of all by the same, that is taken away and told: it is the control or the frame; nothing counts as mended then, as
/// an anchor may pass for the shift alone. Nor does what has moved with its floor, facade, column or the whole, where
/// the anchors that were in order before did so (group_motions.hpp), or what passes by a wider limit. Throws BadInput
/// if no anchor is in both: it is a record of another building. A panel that passes is not mended by it while a joint
/// that was open is not judged again, unless the design has the neighbour no more.
AsBuiltChangesT compare_epochs(const EpochRecord& before, const DeviationT& after, const std::string& epoch,
                               const DesignElements* design = nullptr);

/// Adds to `changes` what became of the findings of the campaign before. One that is there no more is settled; a shift
/// only where the measurement can be trusted, did not move as a whole, and has at least four and half of the anchors
/// that shared it. Called when `after` has all of its requests (leave_open).
void compare_findings(const EpochRecord& before, const DeviationT& after, AsBuiltChangesT& changes);

/// "3 mended, 1 opened again, 2 still open, 1 not measured again"; what does not occur is left out; "nothing has
/// changed".
std::string words_of_changes(const AsBuiltChangesT& changes);
/// "mended", "opened again", ...
const char* words_of(ChangeKind change);

}  // namespace plumbline::judgement

// What a judgement finds that is no anchor's or panel's own: why the measurement proves nothing or is less certain,
// what anchors have in common, what was not judged. A topic of BCF each, and known again by the next campaign.
#pragma once

#include <string>
#include <vector>

#include "artifacts/deviation.hpp"

namespace plumbline::ifc {

/// JudgementRequest.by of requests that name elements, which may be others in the next campaign.
inline constexpr const char* kUnmeasuredPanels = "unmeasured panels";
inline constexpr const char* kCampaignBefore = "campaign before";
inline constexpr const char* kCampaignBeforeJoint = "campaign before, joint";

struct Finding {
  std::string kind;         ///< as FindingChange.kind
  std::string topic;        ///< what it is about, the same in each campaign; of two alike the second ends in "#2"
  std::string title;        ///< in short, with this campaign's figures
  std::string words;        ///< all of it, as sentences
  int floor = 0;            ///< of a shift
  std::string facade = {};  ///< likewise
  std::vector<const AnchorDeviationT*> anchors = {};  ///< that share a shift, what is worst first
};

/// Doubts, misfits, significant shifts of which some anchor is open (that of the whole building first), and what was
/// asked for and not judged. Points into `deviation`.
std::vector<Finding> findings_of(const DeviationT& deviation);

/// The title of the significant shift of this topic, be its anchors in order or not; empty: there is none.
std::string shift_title(const DeviationT& deviation, const std::string& topic);

}  // namespace plumbline::ifc

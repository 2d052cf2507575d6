// Issues for the people who mend them: BCF 2.1, the version that every BIM program reads, or 3.0. Nothing is judged
// here.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "artifacts/deviation.hpp"
#include "building/ifc/facade_frame.hpp"

namespace plumbline {
struct SurfacesT;
struct SurfaceJudgementT;
struct AsBuiltChangesT;
}  // namespace plumbline

namespace plumbline::ifc {

struct Element;

struct BcfOptions {
  bool version_3 = false;                    ///< BCF 3.0, else 2.1
  std::string project_guid;                  ///< IFC GlobalId, the name space of the topics' ids
  std::string epoch;                         ///< that of the as-built file; a label of the topics (ids stay the same)
  std::string date = "1970-01-01T00:00:00";  ///< of the topics, xs:dateTime
  std::string author = "plumbline";
  std::string assigned_to, due_date;        ///< left out where empty
  std::string model_file = "as_built.ifc";  ///< what the topics are about, beside the design file; empty: not named
  const SurfacesT* surfaces = nullptr;      ///< panels and joints as they were measured; null: no topics of surfaces
  const SurfaceJudgementT* surface_judgement = nullptr;  ///< their verdicts; null likewise
  const AsBuiltChangesT* changes = nullptr;  ///< since the campaign before: what was mended is closed; null: none
  /// Of the design: what stands before something, for a view that is free; null: not known.
  const std::vector<Element>* elements = nullptr;
};

/// A .bcf (ZIP): one topic for every failing or undecided anchor, panel, surface of a panel and joint, with a viewpoint
/// that selects and colours it and its solid in the as-built file (camera in metres, project coordinates; panels
/// between it and the camera are hidden, with their solids; of a view that is not from before, and of whatever else had
/// to be hidden, the topic speaks) and a snapshot, and one for everything that was asked for
/// and not judged. Before them stand why the measurement proves nothing or is less certain, and what a floor, a facade,
/// a column or the building has in common, where an anchor of it is open: that topic selects all of them, and those of
/// the single anchors refer to it. Of several facades their names are labels. With `changes`, what was open before and
/// is in order has its topic (of the same id) closed, what opened again says so, and what was open and not measured
/// again stays open. The failing ones come first, and else they stand in the order of `anchors` and `panels`, which are
/// those of `deviation` as they are to be mended (judgement/worst_first.hpp). The same input gives the same bytes.
std::string write_bcf(const DeviationT& deviation, const std::vector<const AnchorDeviationT*>& anchors,
                      const std::vector<const PanelDeviationT*>& panels, const BcfOptions& options);

}  // namespace plumbline::ifc

// One topic of a BCF file, 2.1 or 3.0, whatever it is about; private to ifc/bcf*.cpp and ifc/installation_bcf.cpp.
#pragma once

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "building/ifc/bcf.hpp"
#include "building/ifc/bcf_surroundings.hpp"
#include "building/step/zip_writer.hpp"

namespace plumbline::ifc {

/// What somebody said about a topic.
struct BcfComment {
  std::string date, author, text;  ///< date: xs:dateTime
  std::string key = {};            ///< what its id comes from, beside the topic; empty: its number
};

/// One anchor or panel to be mended, or what several have in common.
struct BcfIssue {
  std::string guid, title, description, storey;
  ToleranceVerdict verdict = ToleranceVerdict::undecided;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double reach = 0;                       ///< half of its size [m]; 0: of the whole, nothing to look at
  FacadeFrame frame;                      ///< of one who stands before it
  std::string about = {};                 ///< what of the element; empty: the whole
  bool closed = false;                    ///< it was mended, and the file says so
  std::vector<BcfComment> comments = {};  ///< oldest first
  std::vector<std::string> members = {};  ///< GlobalIds of what it is about, where that is several; `guid` is no one's
  std::string facade = {};                ///< a label, as the storey
  std::string state = {};                 ///< a label in place of that of its verdict
  std::string key() const { return about.empty() ? guid : guid + "/" + about; }
  double away() const { return std::max(4.0, 4 * reach); }  ///< from it to the camera [m]
};

/// Where nothing says which way it faces it is looked at along y.
FacadeFrame view_of(const std::unique_ptr<FacadeFrameT>& facade);

/// The snapshot: the facade from outside with its panels and anchors, the one meant framed. PNG.
std::string snapshot_png(const BcfSurroundings& surroundings, const Eigen::Vector3d& centre, double reach,
                         const FacadeFrame& facade);

/// Words without their lengths, which are others in each campaign.
std::string without_figures(const std::string& words);

class BcfFile {
 public:
  /// `topics`: how many will come. A ZIP holds 65535 files: of more than 21 844 topics there are no snapshots.
  BcfFile(const BcfOptions& options, const std::string& design_file, std::size_t topics);
  /// `surroundings`: panels and anchors that the snapshot shows, and that are hidden where they hang before the issue.
  void add(const BcfIssue& issue, const BcfSurroundings& surroundings);
  std::string finish();

 private:
  const BcfOptions& options_;
  std::string header_;
  bool snapshots_;
  step::ZipWriter zip_;
  int index_ = 0;
  std::set<std::string> labels_;
};

}  // namespace plumbline::ifc

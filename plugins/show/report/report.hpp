// The report: one HTML file that reads without a network, without scripts, on screen and on A4. It shows verdicts and
// makes none: those of anchors and panels come with the artifact `Deviation`, those of the measurement with `Accuracy`.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "artifacts/accuracy.hpp"
#include "artifacts/as_built_changes.hpp"
#include "artifacts/block.hpp"
#include "artifacts/deviation.hpp"
#include "artifacts/survey_comparison.hpp"
#include "building/ifc/grid.hpp"
#include "show/report/anchor_photographs.hpp"
#include "show/report/building_lines.hpp"
#include "show/report/facade_backdrop.hpp"

namespace plumbline::report {

/// The survey network as its page shows it. Angles in rad, lengths in m.
struct NetworkPage {
  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();

  struct Point {
    std::string id;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Constant(nan);
    bool station = false;  ///< an instrument stood here
    bool datum = false;    ///< carries the datum
    /// [m], in a page about movements; `covariance` is then that of the movement
    Eigen::Vector3d movement = Eigen::Vector3d::Constant(nan);
    bool moved = false;  ///< significantly
  };
  struct Observation {
    std::string kind;  ///< "direction", "zenith_angle", "slope_distance", ...
    std::string from, to;
    bool angular = false;
    double value = nan, residual = nan, sigma = nan, redundancy_number = nan, w = nan, estimated_blunder = nan,
           mdb = nan;
    double external_effect = nan;  ///< [m]
    bool flagged = false, removed = false;
    std::string source;  ///< "file:line"
  };
  struct SetUp {
    std::string id, station;
    double orientation = nan, orientation_sigma = nan;                            ///< [rad]
    double instrument_height = nan, height_correction = nan;                      ///< [m]
    double index = nan, index_sigma = nan;                                        ///< [rad]
    double constant = nan, constant_sigma = nan, scale = nan, scale_sigma = nan;  ///< [m], [1]
    double collimation = nan, collimation_sigma = nan;                            ///< [rad]
  };
  struct Step {
    std::size_t observation = 0;  ///< index into observations
    std::string action;           ///< "removed" or "restored"
    double w = nan, estimated_blunder = nan;
  };
  struct Group {
    std::string name;
    double ratio = nan, redundancy = nan;
    int observations = 0;
    double applied_factor = 1;  ///< on the stated standard deviations
  };
  /// Joint test of direction, zenith angle and distance of one sighting.
  struct Pointing {
    std::string set_up, to;
    double statistic = nan, critical = nan;
    int rank = 0;
    bool flagged = false;
  };
  struct Finding {
    std::string severity, text;
  };

  /// A coordinate row of the page, in the axes that `axis_names` says.
  struct Coordinates {
    std::string id;
    Eigen::Vector3d position = Eigen::Vector3d::Zero(), sigma = Eigen::Vector3d::Constant(nan);
    double plan_95 = nan, height_95 = nan;  ///< largest semi-axis of the ellipse, half length of the interval [m]
  };
  /// Two neighbouring markers, b - a.
  struct Relative {
    std::string from, to;
    double distance = nan, plan_95 = nan, height_95 = nan;  ///< [m]
    double sigma_height = nan;                              ///< [m]
  };

  std::vector<Point> points;
  std::vector<Coordinates> coordinates;
  std::array<std::string, 3> axis_names = {"E", "N", "H"};
  std::vector<Relative> relative;  ///< weakest first; empty: not known
  std::string stochastic_model;
  std::string validity, outcome;  ///< "sound", "doubtful", "invalid"; the same in a sentence
  std::string instrument, date;
  std::vector<std::string> files;
  std::vector<SetUp> set_ups;
  std::vector<Observation> observations;
  std::vector<Step> steps;
  std::vector<Group> groups;
  std::vector<Pointing> pointings;
  std::vector<Finding> findings;
  bool without_readings = false;  ///< a list of coordinates, taken as given
  std::string datum;
  double sigma0 = nan;
  long degrees_of_freedom = 0, unknowns = 0;
  double statistic = nan, lower = nan, upper = nan, alpha = nan;  ///< global test
  std::string verdict;                                            ///< "pass", "low" or "high"
  double critical_w = nan, alpha0 = nan, power = nan;
  /// What the drawings show, and what their ellipses and rings are.
  std::string shown = "the survey network", ellipses = "95\u00A0% confidence", rings = "points that carry the datum";
};

/// A line of the provenance: what it is, and its value or hash.
using Fact = std::pair<std::string, std::string>;

/// A file of the folder the run started from.
struct SourceFile {
  std::string path, sha256;
  std::uint64_t size = 0;  ///< [bytes]
  std::string use;         ///< "photograph", "survey", ...: what it was read as, or looks like; may be empty
};

struct ReportInput {
  std::string title = "Accuracy report";
  std::string subtitle;  ///< site, scenario, date: as the pipeline gives them
  std::string command;   ///< what was typed to run it; empty: not known
  AccuracyT accuracy;
  std::optional<DeviationT> deviation;     ///< as-built minus design; without it the page is about measuring only
  std::optional<AsBuiltChangesT> changes;  ///< since the campaign before
  std::optional<BlockT> block;             ///< the adjustment of the images
  std::optional<SurfacesT> surfaces;       ///< panels as they are, behind the anchors
  std::vector<ifc::GridAxis> grid;         ///< of the design
  BuildingLines building;
  std::vector<FacadePicture> pictures;           ///< of the facades, likewise
  std::optional<AnchorPhotographs> photographs;  ///< of what is not in order
  std::vector<Fact> images;                      ///< what came in from the photographs, and what was left out
  std::optional<NetworkPage> network;
  std::optional<SurveyComparisonT> control_check;
  std::vector<Fact> provenance;
  std::vector<SourceFile> files;      ///< that were read
  std::vector<SourceFile> set_aside;  ///< evidence that lay there and was left out on purpose
  std::vector<SourceFile> unread;     ///< what else lay there
};

/// The whole report as HTML. Deterministic; all text from the input is escaped; the result requests nothing from
/// outside.
std::string render_report(const ReportInput& input);

}  // namespace plumbline::report

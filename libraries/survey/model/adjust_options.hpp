// What an adjustment of a survey network is told, and how it says that it cannot be done.
#pragma once

#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "least_squares/problem/cofactors.hpp"
#include "plumbline/failure.hpp"
#include "survey/model/instrument_profile.hpp"
#include "survey/model/map_frame.hpp"
#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

enum class DatumMode {
  automatic,  ///< weighted if control has a covariance, fixed if it has none, as the file says if it says something,
              ///< else inner
  file,       ///< roles of the points in the file
  fixed,      ///< control points (or `datum_points` with their coordinates in the file) held
  weighted,   ///< control coordinates are observations with their covariance
  inner       ///< free network: inner constraints on `datum_points`, or on all points
};

enum class Switch { automatic, off, on };

/// What the user wants left out, and why; printed with the result.
struct ExcludedItem {
  enum class Kind { point, set_up, line, control } kind = Kind::point;
  std::string what;  ///< name of the point, set-up or control point; "file:line" or "line" of a reading
  std::string reason;
};
/// "point A7: knocked over", "set-up S3: on a moving slab", "line job.gsi:57: read twice", "control G1: it was hit"
/// (the point stays, and what was known of it holds nothing). Throws std::invalid_argument that says what was expected.
ExcludedItem parse_exclusion(const std::string& text);

inline constexpr const char* kPlane = "plane";

struct AdjustOptions {
  InstrumentProfile profile;
  std::map<std::string, InstrumentProfile> instruments;  ///< by the name that the survey has for them; else `profile`
  /// An instrument stands beside its mark by one amount in a set-up: an unknown of the set-up with the centring of the
  /// profile as its prior. false: part of each reading by itself, as STAR*NET has it in direction sets.
  bool centring_per_set_up = true;
  DatumMode datum = DatumMode::automatic;
  std::vector<std::string> datum_points;  ///< empty: all that qualify
  double alpha = 0.05;                    ///< global test
  double alpha0 = 0.001;                  ///< w-tests
  double power = 0.80;                    ///< for MDBs
  /// Mistakes are mended: wrong readings are taken out, errors that a set-up has in common estimated, units and turned
  /// circles put right. Otherwise they are only named.
  bool remove_blunders = false;
  double removal_alpha = 0.003;  ///< chance that a sound network loses a reading, over all its tests (Sidak)
  double largest_removed_share = 0.10;
  bool robust_start =
      false;  ///< Huber weights find the start of data snooping; else only where it ends unclean without
  std::vector<ExcludedItem> exclude;
  bool estimate_variance_components = false;
  Switch scale_with_sigma0 = Switch::automatic;  ///< automatic: as the file asks
  Switch curvature =
      Switch::automatic;  ///< earth curvature and refraction; automatic: not for files of reduced observations
  double refraction_coefficient = 0.13;
  // Optional unknowns; a sigma of 0 leaves them out. Priors are 0 (refraction: refraction_coefficient).
  double scale_sigma = 0;              ///< [1], e.g. 10e-6
  double additive_constant_sigma = 0;  ///< [m]
  double refraction_sigma = 0;         ///< [1], e.g. 0.15
  double vertical_index_sigma = 0;     ///< [rad], one for all set-ups
  double tilt_sigma = 0;               ///< [rad], two per set-up
  double instrument_height_sigma = 0;  ///< [m], one per set-up
  /// Map of E and N ("EPSG:25832", "utm:32"); empty: a plane of its own in which lengths are true; kPlane: likewise,
  /// and coordinates that look like those of a map are none.
  std::string map;
  GeoidChoice geoid;               ///< of the map
  double mean_height = kNotGiven;  ///< of a site none of whose points has a height, above the geoid [m]
  /// Cofactors are one matrix of up to so many unknowns, 8 bytes times their square; beyond, they are found on demand,
  /// and the external effects of readings are those on their own points.
  int largest_whole = least_squares::Cofactors::kLargestWhole;
  bool measure_control = false;  ///< NetworkResult::measured_control is filled
  /// Of a survey without readings, which is a list of coordinates: another program adjusted and tested them.
  bool coordinates_are_tested = false;
  double known_sigma = 1e-4;  ///< [m], each coordinate of points that were keyed in as known, where nothing states it
};

/// Points known beforehand.
struct ControlPoints {
  std::vector<std::string> ids;
  Eigen::VectorXd coordinates;  ///< 3n: E, N, H of each [m]
  Eigen::MatrixXd covariance;   ///< 3n x 3n [m^2]; 0 x 0: without error
};

struct Finding {
  enum class Severity { note, warning, error } severity = Severity::note;
  std::string text;
  std::vector<std::string> points;
  enum class Subject { network, reading, exclusion, left_out, unread, control, either } subject = Subject::network;
  std::string cause = {};  ///< of points that were left out: why they are not determined
};

/// The network cannot be adjusted; what() says why in words, `findings` in detail.
class NetworkError : public Failure {
 public:
  explicit NetworkError(const std::string& message, std::vector<Finding> what_was_found = {},
                        std::vector<std::string> points = {}, plumbline_answer kind = PLUMBLINE_BAD_INPUT)
      : Failure(kind, message), findings(std::move(what_was_found)), undetermined(std::move(points)) {}
  std::vector<Finding> findings;
  std::vector<std::string> undetermined;  ///< points without which the rest might be adjusted; may be empty
};

}  // namespace plumbline::survey

// What any survey file gives, in plain structs: every reader fills a SurveyObservations, the adjustment takes one or
// several. The reader normalises, so that nobody after it has to know the format:
//   lengths in m, angles in rad; points as E, N, H (x, y, z; right-handed, z up);
//   directions, angles and azimuths clockwise seen from above (direction = azimuth - orientation; azimuth from +N);
//   zenith angles from the zenith, face 2 kept as measured (in (pi, 2 pi)) with face = 2; the adjustment reduces and
//   averages.
// Distances are as the instrument would show them after prism constant and ppm; what was done stands in `corrections`.
// NaN says "the file gives none"; no field uses 0 for that.
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "plumbline/failure.hpp"

namespace plumbline::survey {

inline constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();
inline double or_else(double value, double other) { return std::isnan(value) ? other : value; }
inline double or_zero(double value) { return or_else(value, 0); }

/// Where something stands in its file; line and column count from 1, 0 = unknown.
struct SourcePosition {
  std::string file;
  int line = 0;
  int column = 0;
};

/// "file:line:column", as much of it as is known.
inline std::string place(const SourcePosition& at) {
  std::string text = at.file;
  if (at.line > 0) text += ":" + std::to_string(at.line);
  if (at.line > 0 && at.column > 0) text += ":" + std::to_string(at.column);
  return text;
}

enum class ObservationKind {
  direction,            ///< circle reading [rad], clockwise; needs a set-up, which has one orientation unknown
  zenith_angle,         ///< [rad]
  slope_distance,       ///< [m], between instrument axis and target
  horizontal_distance,  ///< [m], at the height of neither end (no height enters)
  height_difference,    ///< H(to) - H(from) between the points themselves [m], e.g. levelled
  angle,                ///< clockwise from `to` (left arm) to `second_to` (right arm) at `from` [rad]
  azimuth               ///< clockwise from +N [rad]; no orientation unknown
};

/// One set-up of an instrument: one orientation unknown for its directions. A station occupied twice is two set-ups.
struct SetUp {
  std::string id;       ///< unique within the file, e.g. "S3" or "4901/2"
  std::string station;  ///< point below the instrument; for a free station a name the reader made
  double instrument_height =
      kNotGiven;  ///< tilting axis above the station point [m]; NaN: the point is the axis itself
  SourcePosition source;
  /// Azimuth of the circle's zero, clockwise from +N [rad], as the file states it or as its backsight makes it; it
  /// orients a network that nothing else does and is no observation. NaN: not stated.
  double stated_orientation = kNotGiven;
};

struct Observation {
  ObservationKind kind = ObservationKind::direction;
  int set_up = -1;  ///< index into SurveyObservations::set_ups; -1 where there is none (levelling, single distances)
  int pointing =
      -1;  ///< equal for direction, zenith angle and distance of one sighting; counts from 0 in a file; -1: none
  std::string from, to;
  std::string second_to;                    ///< angle only
  double value = kNotGiven;                 ///< [rad] or [m]
  double sigma = kNotGiven;                 ///< standard deviation [rad] or [m]; NaN: the instrument profile decides
  bool without_centring = false;            ///< the sigma is that of the instrument: centring is to be added
  double levelling_length = kNotGiven;      ///< height differences: length of the line [m]
  double instrument_height = kNotGiven;     ///< of this observation [m]; NaN: the set-up's
  double target_height = kNotGiven;         ///< target above point `to` [m]; NaN: 0
  double second_target_height = kNotGiven;  ///< angle only [m]
  int instrument = -1;                      ///< index into SurveyObservations::instruments; -1: the campaign's
  int face = 0;                             ///< 1, 2; 0 = unknown or already the mean of both
  int set_number = 0;                       ///< sets (rounds) count from 1; 0 = unknown
  SourcePosition source;
  std::vector<std::string>
      corrections;  ///< what was done to the value, in order: "prism -34.4 mm", "ppm 12", "face reduction"
};

/// Correlated observations: covariance (n x n) [rad, m] of observations[indices]; replaces their sigmas.
struct ObservationCovariance {
  std::vector<int> indices;
  Eigen::MatrixXd covariance;
};

/// Observed coordinates with a full covariance; any subset of axes of any points, e.g. control points of an earlier
/// epoch.
struct CoordinateGroup {
  struct Component {
    std::string point;
    int axis = 0;  ///< 0 E, 1 N, 2 H
  };
  std::vector<Component> components;  ///< n
  Eigen::VectorXd values;             ///< n [m]
  Eigen::MatrixXd covariance;         ///< n x n [m^2]
  bool is_control = false;            ///< true: given as datum (prior) rather than measured in this campaign
  SourcePosition source;
};

/// Coordinate differences (GNSS baselines) with a full covariance.
struct VectorGroup {
  bool is_geocentric = false;  ///< values are dX, dY, dZ of the earth, which only a map brings together with E, N, H
  double horizontal_factor = 1, vertical_factor = 1;  ///< on standard deviations of a geocentric group, in its horizon
  struct Vector {
    std::string from, to;
    double from_height = 0;  ///< antenna above the point [m]
    double to_height = 0;
  };
  std::vector<Vector> vectors;  ///< n
  Eigen::VectorXd values;       ///< 3n: dE, dN, dH (or dX, dY, dZ) of each [m]
  Eigen::MatrixXd covariance;   ///< 3n x 3n [m^2]
  SourcePosition source;
};

/// A point in the frame of a levelled set-up, as camera-based sensors export it: z up, y at the zero of the circle, x
/// to its right; origin in the instrument's centre.
struct LocalCoordinate {
  int set_up = -1;
  std::string point;
  Eigen::Vector3d position = Eigen::Vector3d::Constant(kNotGiven);    ///< [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Constant(kNotGiven);  ///< [m^2]; NaN: the instrument profile decides
  double target_height = kNotGiven;                                   ///< [m]
  SourcePosition source;
  std::vector<std::string> corrections;
};

/// What a coordinate is in the adjustment; the datum parameter of the adjustment can override it.
enum class CoordinateRole {
  unused,       ///< does not exist in this network (height of a 2D point)
  free,         ///< unknown
  constrained,  ///< unknown, and part of the inner-constraint datum (capital letters in gama-local)
  fixed         ///< known without error
};

struct Point {
  std::string id;
  /// E, N, H [m]; NaN where the file gives none. Given coordinates of free points are approximate values.
  Eigen::Vector3d coordinates = Eigen::Vector3d::Constant(kNotGiven);
  std::array<CoordinateRole, 3> roles = {CoordinateRole::free, CoordinateRole::free, CoordinateRole::free};
  /// E, N, H that somebody keyed in as known. False: the instrument computed it, or nobody says.
  std::array<bool, 3> known = {false, false, false};
  std::string code, description;
  SourcePosition source;
};

/// A line, or part of it, that could not be used; reading went on.
struct SkippedLine {
  SourcePosition source;
  std::string found;     ///< the offending text, shortened
  std::string expected;  ///< what would have been right
};

/// About the whole file. Axes and senses tell how the file was written; the data above are normalised already.
struct NetworkInfo {
  std::string format;  ///< "gsi", "gama-xml", ...
  std::string title, description;
  std::string instrument, instrument_serial, operator_name, program, date;
  std::string axes_xy = "en";            ///< where x and y of the file point: en, nw, se, ws, ne, sw, es, wn
  bool angles_right_handed = false;      ///< true: the file counted angles counter-clockwise
  bool axes_inconsistent = false;        ///< true: handedness of axes and angles differed in the file
  bool angles_in_degrees = false;        ///< unit the file showed angles in (false: gon), for writing back
  double a_priori_sigma0 = kNotGiven;    ///< in the file's own convention (gama: unit of the weights, not a test value)
  bool use_a_posteriori_sigma0 = false;  ///< covariances of the file's result were scaled with the a posteriori sigma0
  double confidence_level = kNotGiven;   ///< e.g. 0.95
  double refraction_coefficient = kNotGiven;
  std::string coordinate_system;  ///< of the coordinates, as the file names it: "EPSG:25832", a name; empty: none
  /// What contradicts the approximate coordinates by more than this [m] takes no part (gama: tol-abs); NaN: no limit.
  double largest_misclosure = kNotGiven;
};

struct SurveyObservations {
  NetworkInfo info;
  std::vector<std::string> files;
  std::vector<Point> points;
  std::vector<SetUp> set_ups;
  std::vector<Observation> observations;
  std::vector<ObservationCovariance> covariances;
  std::vector<CoordinateGroup> coordinates;
  std::vector<VectorGroup> vectors;
  std::vector<LocalCoordinate> local_coordinates;
  std::vector<std::string> instruments;  ///< names that observations refer to where a job has several
  std::vector<SkippedLine> skipped;
  std::vector<std::string> warnings;  ///< about the file as a whole, e.g. "all zenith angles below 100 gon: ..."
};

/// A file nothing could be got from. what() is "file:line:column: found ..., expected ...".
class SurveyReadError : public BadInput {
 public:
  SurveyReadError(SourcePosition position, const std::string& found_text, const std::string& expected_text)
      : BadInput(describe(position, found_text, expected_text)),
        source(std::move(position)),
        found(found_text),
        expected(expected_text) {}

  SourcePosition source;
  std::string found, expected;

 private:
  static std::string describe(const SourcePosition& at, const std::string& found, const std::string& expected) {
    return place(at) + ": found " + found + ", expected " + expected;
  }
};

}  // namespace plumbline::survey

// Standard deviations of an instrument and its targets, from YAML. Built-in profiles are the files of
// libraries/survey/model/profiles.
#pragma once

#include <limits>
#include <map>
#include <string>
#include <vector>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

struct InstrumentProfile {
  std::string name;
  double direction_sigma = 0;  ///< one set in both faces [rad]
  double zenith_sigma = 0;     ///< one set in both faces [rad]
  /// Of an angle between two targets and of an azimuth, of one set [rad]; NaN: two directions, one direction.
  double angle_sigma = std::numeric_limits<double>::quiet_NaN();
  double azimuth_sigma = std::numeric_limits<double>::quiet_NaN();
  double single_face_factor = 1;   ///< on angles measured in one face only
  double distance_constant = 0;    ///< [m]
  double distance_ppm = 0;         ///< [1e-6]
  double instrument_centring = 0;  ///< horizontal, over a mark, each component [m]
  double target_centring = 0;      ///< horizontal, each component [m]
  double height_centring = 0;      ///< vertical, of the target and, where the next is 0, of both ends together [m]
  double instrument_height = 0;    ///< of the height noted above a mark [m]; common to all sights of a set-up
  /// What is left of the vertical axis' error after levelling and compensator, each component [rad]. It holds for a
  /// whole set-up, so sets do not average it away: tan(elevation) of it in a direction, all of it in a zenith angle
  /// (Ghilani, Adjustment Computations, ch. 7).
  double levelling = 0;
  /// Of distances [m]; NaN: instrument and target centring together.
  double distance_centring = std::numeric_limits<double>::quiet_NaN();
  double height_difference = 0;              ///< levelled height difference, constant part [m]
  double height_difference_per_sqrt_km = 0;  ///< [m]
  /// true: the sigmas are those of the mean of all sets, whatever their number; false: of one set.
  bool sigmas_of_mean = false;

  /// Standard deviation of a mean of `sets` sets [rad or m]; `horizontal` and `slope` are the length of the sight [m].
  double direction(double horizontal, double slope, int sets, bool single_face) const;
  double azimuth(double horizontal, double slope, int sets) const;
  /// Of an angle between arms of these lengths, whose targets lie `apart` [m]. The instrument stands at one place for
  /// both: c_i d3 / (d1 d2), which leaves nothing of a small angle and doubles that of a straight one (Ghilani,
  /// Adjustment Computations, 7.4).
  double angle(const double (&horizontal)[2], const double (&slope)[2], double apart, int sets) const;
  double zenith_angle(double slope, int sets, bool single_face) const;
  double distance(double slope, int sets) const;
  double levelled(double length) const;

  /// The same for readings whose equations have the instrument's centring as an unknown of their set-up.
  InstrumentProfile without_instrument_centring() const;
  /// What is the instrument's own alone: no centring of it, of targets and in height.
  InstrumentProfile without_centring() const;
};

/// "total_station_1arcsec: directions 1.0", zenith angles 1.0", distances 1.0 mm + 1.0 ppm, targets 0.3 mm".
std::string in_words(const InstrumentProfile& profile);
/// Names of the built-in profiles.
std::vector<const char*> profile_names();
/// Throws std::runtime_error with the known names if there is none.
InstrumentProfile built_in_profile(const std::string& name);
/// `origin` names the text in errors. Throws std::runtime_error with line and column.
InstrumentProfile parse_profile(const std::string& yaml, const std::string& origin);
/// A profile file, or a project of STAR*NET (starnet_project.hpp), whose default instrument it is.
InstrumentProfile read_profile(const std::string& path);
/// Further instruments of the same file, by the names that survey files call them: "instruments: {S9: {keys}}"; a key
/// that one of them lacks is the file's own.
std::map<std::string, InstrumentProfile> parse_instruments(const std::string& yaml, const std::string& origin);
std::map<std::string, InstrumentProfile> read_instruments(const std::string& path);

/// Profile of the parameters `profile` and `profile_file` that several nodes have: the file if there is one; for
/// "automatic" the built-in profile that the observations name (`instrument`, as campaign.yaml sets it), or else
/// ics50_assumed with a sentence in `remark` if they name another instrument; of a project of STAR*NET `remark` is what
/// else it sets.
InstrumentProfile choose_profile(const std::string& profile, const std::string& profile_file,
                                 const std::string& instrument, std::string& remark);

}  // namespace plumbline::survey

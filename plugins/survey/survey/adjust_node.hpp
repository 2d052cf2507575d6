// survey.adjust: files of a campaign to coordinates with full covariance.
#pragma once

#include "artifacts/points.hpp"
#include "artifacts/survey_network.hpp"
#include "artifacts/survey_observations.hpp"
#include "map_parameters.hpp"
#include "survey/adjust/adjust_network.hpp"

namespace plumbline::survey {

struct AdjustNode : MappedNode {
  static constexpr Info info{"survey.adjust", "survey_adjuster", 9,
                             "Adjusts a survey network by least squares, with tests, reliability and full covariance"};
  List<plumbline::SurveyObservations> observations{"observations", frame("frame=?S"),
                                                   "readings of one campaign, from one or several files"};
  Optional<Points> control{"control", frame("frame=?S"), "points known beforehand, with or without covariance"};
  Param<std::string> datum{"datum", "automatic", one_of("automatic", "file", "fixed", "weighted", "inner"),
                           "what defines the frame; automatic: weighted control if it has a covariance, fixed if not, "
                           "as the file says, or a free network"};
  Param<std::vector<std::string>> datum_points{"datum_points", std::vector<std::string>{},
                                               "points that carry a fixed or inner datum; empty: all that can"};
  Param<std::vector<std::string>> same_stations{
      "same_stations", std::vector<std::string>{},
      "stations that several files occupy and that are one mark though nothing in the files shows it; '*': all"};
  Param<double> alpha{"alpha", 0.05, "1", between(1e-6, 0.5), "error of the first kind of the global test"};
  Param<double> alpha0{"alpha0", 0.001, "1", between(1e-9, 0.5), "error of the first kind of one w-test"};
  Param<double> power{"power", 0.80, "1", between(0.5, 0.999), "power that minimal detectable blunders refer to"};
  Param<bool> remove_blunders{"remove_blunders", false,
                              "mistakes are mended: wrong readings removed, errors that a set-up has in common "
                              "estimated, units and turned circles put right; otherwise they are only named"};
  Param<double> removal_alpha{"removal_alpha", 0.003, "1", between(1e-9, 0.5),
                              "chance that a network in which nothing is wrong loses a reading"};
  Param<std::vector<std::string>> exclude{
      "exclude", std::vector<std::string>{},
      "what is left out, each with the reason that the page prints: 'point A7: knocked over', 'set-up S3: ...', "
      "'line job.gsi:57: ...', 'control G1: ...' (the point stays, what was known of it does not hold)"};
  Param<double> largest_removed_share{"largest_removed_share", 0.10, "1", between(0, 0.5),
                                      "data snooping stops when this share of the observations is removed"};
  Param<bool> robust_start{
      "robust_start", false,
      "robust weights find the first suspects of data snooping; else only where it does not end clean without"};
  Param<bool> variance_components{"variance_components", false,
                                  "estimate one factor for each kind of observation with enough redundancy"};
  Param<std::string> scale_with_sigma0{
      "scale_with_sigma0", "automatic", one_of("automatic", "off", "on"),
      "multiply covariances with the a posteriori variance; automatic: as the file asks"};
  Param<std::string> curvature{
      "curvature", "automatic", one_of("automatic", "off", "on"),
      "earth curvature and refraction in zenith angles; automatic: for raw readings, not for files of reduced ones"};
  Param<double> refraction_coefficient{"refraction_coefficient", 0.13, "1", between(-5, 5), "where the file has none"};
  Param<double> scale_sigma{"scale_sigma", 0.0, "ppm", at_least(0), "prior of an unknown distance scale; 0: none"};
  Param<double> additive_constant_sigma{"additive_constant_sigma", 0.0, "m", at_least(0),
                                        "prior of an unknown additive constant; 0: none"};
  Param<double> refraction_sigma{"refraction_sigma", 0.0, "1", at_least(0),
                                 "prior of an unknown refraction coefficient; 0: none"};
  Param<double> vertical_index_sigma{"vertical_index_sigma", 0.0, "arcsec", at_least(0),
                                     "prior of an unknown vertical index; 0: none"};
  Param<double> tilt_sigma{"tilt_sigma", 0.0, "arcsec", at_least(0), "prior of an unknown tilt a set-up; 0: none"};
  Param<double> instrument_height_sigma{"instrument_height_sigma", 0.0, "m", at_least(0),
                                        "prior of an unknown correction of each instrument height; 0: none"};
  Param<double> known_sigma{"known_sigma", 1e-4, "m", between(1e-6, 10),
                            "standard deviation of each coordinate that the file has as known (keyed in), where no "
                            "control is given; datum inner ignores them"};
  Param<std::string> coordinates{
      "coordinates", "untested", one_of("untested", "tested"),
      "of a survey without readings, a list of coordinates: tested says that another program adjusted and tested them, "
      "so that verdicts may rest on them and on the standard deviations that they come with"};
  Param<std::string> centring{"centring", "set_up", one_of("set_up", "reading"),
                              "the instrument's centring over a mark is one amount for all readings of a set-up, or "
                              "another for each reading, as STAR*NET has it in direction sets"};
  Param<std::string> covariance{
      "covariance", "automatic", one_of("automatic", "full", "neighbours"),
      "of `points`: joint of all of them; of networks with more than 4000 unknowns (automatic) that of each and of "
      "neighbouring markers, in `network`; full: joint however many there are, which takes 8 bytes times their square"};
  Param<std::vector<std::string>> pairs{
      "pairs", std::vector<std::string>{},
      "further pairs of points, each as 'A B' or 'A;B', whose covariance is wanted where it is not joint"};
  Out<Points> points{"points", frame("frame=?S"), "adjusted points with full covariance; see `covariance`"};
  Out<SurveyNetwork> network{"network", frame("frame=?S"), "the whole result: statistics, tests, every observation"};

  Out<Points> measured_control{
      "measured_control", frame("frame=?S"),
      "known points as the readings alone have them, in the datum of a free network, for survey.check_control; empty "
      "where fewer than three are known, or nothing like that can be said from the network with control"};

  AdjustOptions options() const;  ///< without the profile, which may depend on the observations
  void run(Context& context) override;
};

}  // namespace plumbline::survey

// Three epochs of a network and more: what has stayed, how far everything else moved, how fast, and whether that is
// more than chance.
//   variance   Bartlett's test of the epochs' sigma0; if they are equal the pooled one, with all their degrees of
//   freedom datum      points that no comparison with the first epoch takes out; each epoch is laid on them and its
//   covariance
//              brought into their datum (S-transformation, Baarda 1973), so that epochs are independent of each other
//   movement   of an epoch against the first, as in compare_epochs.hpp
//   velocity   weighted line through the positions of all epochs, x(t) = a + v (t - t1), with its test and the test of
//              what is left: a point may move without moving evenly
// Pelzer (1971); Niemeier, Ausgleichungsrechnung, 12.4; Heunecke et al., Auswertung geodätischer
// Überwachungsmessungen, 9.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "survey/epochs/compare_epochs.hpp"

namespace plumbline::survey {

struct DatedEpoch {
  std::string name;
  double time = 0;  ///< in any unit, ascending
  Epoch epoch;      ///< covariance a priori
  EpochVariance variance;
};

struct SeriesOptions {
  double alpha = 0.05;    ///< of tests of the whole
  double alpha0 = 0.001;  ///< of each point
  int free_motions = 4;   ///< 0: epochs are in one fixed frame; 3: shift; 4: shift and turn about the vertical
  double warning_level = 0, alarm_level = 0;  ///< length of a movement [m]; 0: none
  std::vector<std::string> stable;            ///< points that carry the datum; empty: found
};

/// How a movement stands to a level: it counts as reached where it may be beyond it (95 %, one-sided) only.
enum class Level { below, may_be_reached, reached };

struct SeriesPoint {
  std::string id;
  bool stable = false;  ///< carries the datum
  struct At {
    size_t epoch = 0;
    /// Of each coordinate since the epoch that measured it first, `reference` [m]; NaN: not measured in this epoch.
    Eigen::Vector3d movement = Eigen::Vector3d::Zero();
    Eigen::Vector3d sigma = Eigen::Vector3d::Zero();
    double statistic = 0, critical = 0;
    bool moved = false;
    Level warning = Level::below, alarm = Level::below;
  };
  std::vector<At> at;  ///< epochs that measured any coordinate again
  /// Of these the last one of each coordinate, the latest first: an epoch of heights alone says nothing of the plan.
  std::vector<const At*> latest() const;
  /// The highest level of any of them.
  Level latest_alarm() const;
  Level latest_warning() const;
  size_t first = 0;  ///< its first epoch
  std::array<size_t, 3> reference = {0, 0,
                                     0};     ///< first epoch of each coordinate; of no meaning where none is compared
  Eigen::Vector3d velocity, velocity_sigma;  ///< [m per unit of time]; NaN: not shown by two epochs
  double velocity_statistic = 0, velocity_critical = 0;
  bool moves = false;                      ///< the velocity is significant
  double misfit = 0, misfit_critical = 0;  ///< of the line, chi-squared; critical 0: two epochs only
  bool uneven() const { return misfit_critical > 0 && misfit > misfit_critical; }
};

struct EpochSeries {
  double sigma0 = 1;                           ///< pooled
  int degrees_of_freedom = 0;                  ///< of it where it was applied; 0: a priori variances hold
  double bartlett = 0, bartlett_critical = 0;  ///< of equal variances; critical 0: not tested
  std::vector<double> factors;                 ///< on the covariance of each epoch
  std::string variances;                       ///< in words
  std::vector<std::string> stable;
  std::string two_bodies;                 ///< points moved as one body against others, in words; empty: they do not
  bool bodies_are_rivals = false;         ///< and nobody can tell which of the two stayed (Comparison)
  std::vector<std::string> contradicted;  ///< of those that were named to carry the datum: most others say they moved
  std::vector<std::string> seen_once;     ///< points of one epoch only, or held without error
  std::vector<std::string> not_followed;  ///< names that change, points that the last epoch lacks, in words
  std::vector<std::string> not_compared;  ///< coordinates that an epoch holds or lacks, in words
  std::vector<SeriesPoint> points;        ///< those that some epoch sees again, in the order they first appear
};

/// A date of a file's head as days from 1970: "2025-03-14", "14.03.2025", "03-14-2025" (RW5 has the month first).
/// nullopt: no date.
std::optional<double> day_of_date(const std::string& date);

/// Throws std::runtime_error: fewer than two epochs, times that do not ascend, no common datum.
EpochSeries epoch_series(const std::vector<DatedEpoch>& epochs, const SeriesOptions& options);

}  // namespace plumbline::survey

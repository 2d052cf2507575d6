// Where anchors are, by all campaigns together: what did not move since it was measured last is one estimate, what was
// worked on or moved starts anew.
//
// A campaign y of the anchors z measures them on its control: y = z + n, where n is its own and `own` the covariance of
// n. What control is off by is the same for all campaigns: no number of them tells it, so it is no part of `own`, and
// is added to the estimate at the end. Anchors that are in both are compared,
//   d = y - z, S = cov(z) + cov(n), z += cov(z) S^-1 d,
// and those that are new are corrected by what the compared ones say of the errors of this campaign,
//   z_new = y_new - cov(n_new, n) S^-1 d:
// the set-up of a floor is known better where other anchors of the floor stayed. That is least squares over all
// campaigns (Kalman 1960, with a flat prior for what is new).
#pragma once

#include <Eigen/Core>
#include <set>
#include <string>
#include <vector>

namespace plumbline::loop {

/// Places of anchors [m] with the covariance of what no other campaign shares.
struct AnchorPlaces {
  std::vector<std::string> ids;
  std::vector<int> floors;             ///< storey, from 1 at the bottom; 0: unknown
  Eigen::VectorXd places;              ///< 3n [m]
  Eigen::MatrixXd own;                 ///< 3n x 3n [m²]
  std::vector<std::string> campaigns;  ///< by id: names of the campaigns in it, each followed by a blank
  std::size_t size() const { return ids.size(); }
};

struct CombineOptions {
  /// How far all anchors of a storey may sink or rise together from one campaign to the next, for each storey that
  /// there is below: loads, temperature. Standard deviation [m].
  double drift_per_storey = 0.00002;
  /// Of naming something as moved, in a campaign in which nothing did.
  double false_alarm = 1e-3;
  /// Of taking independent campaigns for one that repeats the readings of those before.
  double false_repetition = 1e-6;
};

/// An anchor, or all anchors of a floor together (`id` empty), that did not stay where they were.
struct MovedAnchor {
  std::string id;
  int floor = 0;
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< [m]
  double statistic = 0, critical = 0;               ///< chi-squared with three degrees of freedom
};

struct CombinedCampaigns {
  AnchorPlaces estimate;
  std::vector<MovedAnchor> moved;
  int compared = 0;        ///< anchors that were measured before and again, and are said not to have moved
  double chi_squared = 0;  ///< of their differences, 3 * compared degrees of freedom
  int known = 0;           ///< anchors that are in the estimate by this campaign already, where it has others anew
  bool repeats = false;    ///< differences are far smaller than two campaigns can have, or `known`: it counts alone
};

/// `campaign`: one name each in `campaigns`. An anchor whose estimate has that campaign already takes nothing from it
/// again; one of `worked_on` starts anew. Anchors that the campaign does not have stay as they were. Precondition: ids
/// are unique in each, matrices symmetric and positive definite. Throws std::runtime_error if they are not.
CombinedCampaigns combine_campaigns(const AnchorPlaces& before, const AnchorPlaces& campaign,
                                    const std::set<std::string>& worked_on, const CombineOptions& options = {});

/// Why a campaign that `repeats` can be none of its own; empty: it is one.
std::string repetition_words(const CombinedCampaigns& combined);

/// "F03-C02-R1 is 2.4 mm from where it was measured before", one line each, and what repeats.
std::vector<std::string> words_of(const CombinedCampaigns& combined);

}  // namespace plumbline::loop

// Divisions of the photographs of one camera, and how much of what they say differs with them beside what differs with
// the place that each was taken from.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "markers/camera_changes.hpp"

namespace plumbline::markers {

constexpr int smallest_part = 3;
constexpr double as_good_as = 1e-9;  ///< orders that split alike are ties

/// A way to weigh the photographs against each other: of two parts, or of a drift. The weights sum up to zero.
struct Contrast {
  CameraChange::Split split = CameraChange::Split::from_on;
  Eigen::VectorXd weights;  // second part positive
  std::vector<int> second;
  int period = 0;
};

Contrast of_parts(CameraChange::Split split, const std::vector<bool>& second, int period = 0);

/// Adds the contrast unless a part is smaller than smallest_part.
void add_parts(CameraChange::Split split, const std::vector<bool>& second, int period,
               std::vector<Contrast>& contrasts);

/// By the order of the photographs.
std::vector<Contrast> contrasts_in_order(std::size_t n);

/// How the camera was held: its x axis in the object, one way or upside down against most. A principal point shows it
/// when a program has turned the pictures; a lens or a board that are not quite the model show it, too, but in other
/// parameters.
void add_upside_down(const std::vector<RigidTransform>& poses, std::vector<Contrast>& contrasts);

/// What is known of where the photographs were taken: columns of tilt (two), roll and distance, about their means.
struct Places {
  Eigen::MatrixXd tilt, roll, distance;
};

Places places_of(const std::vector<RigidTransform>& cam_from_object);

/// Side by side; those that hardly differ are dropped.
Eigen::MatrixXd columns_of(const std::vector<Eigen::MatrixXd>& places, std::size_t photographs);

/// What the photographs say of directions in the parameters, each score in units of its standard deviation, and what of
/// it goes with their places.
class Scores {
 public:
  /// `places`: columns_of. `with_scatter`: the standard deviation holds what photographs have of their own beside their
  /// corners' noise.
  Scores(const CameraEvidence& evidence, const Eigen::MatrixXd& directions, const Eigen::MatrixXd& places,
         bool with_scatter = true);

  /// Orthonormal columns of how the scores about the common parameters answer to photographs whose parameters differ as
  /// `weights` do, beside how they answer to places; none where the places explain all but a twentieth.
  Eigen::MatrixXd answer(const Eigen::VectorXd& weights) const;

  /// What no place explains, with the photographs in some order; of length 1.
  Eigen::VectorXd in_order(const std::vector<int>& order) const;
  Eigen::VectorXd as_taken() const;

  /// Whether the places explain more than as many columns do of nothing (F-test, 1 %).
  bool differ_by_place() const;

 private:
  Eigen::MatrixXd response(const Eigen::VectorXd& weights) const;
  std::size_t photographs_ = 0;
  Eigen::Index directions_ = 0;
  std::vector<Eigen::MatrixXd> own_, common_;  // whitened information along the directions, and of all parameters
  std::vector<Eigen::MatrixXd> information_;   // of all parameters with the directions
  Eigen::MatrixXd formal_, basis_;
  Eigen::VectorXd left_;  // by photograph
  double of_places_ = 0;  // sum of squares
};

/// Part of the scores that an answer explains.
double explained(const Eigen::VectorXd& scores, const Eigen::MatrixXd& answer);

/// The best split by one set of scores, and the part of the orders of the photographs that split as well.
struct BestSplit {
  std::size_t contrast = 0;
  double explained = -1, level = 1;
};

BestSplit best_split(const Scores& scores, const std::vector<Contrast>& contrasts, double highest);

struct TwoGroups {
  std::vector<bool> second;  ///< the smaller one
  double level = 1;          ///< part of normal scores with the same scatter that fall apart as far
};

/// Single photographs in two groups along the direction of those given in which they scatter most: the best cut of
/// their sorted values. Nothing where normal scores do so as often as `highest`.
std::optional<TwoGroups> two_groups(const CameraEvidence& evidence, const Eigen::MatrixXd& directions,
                                    const Eigen::MatrixXd& places, double highest);

}  // namespace plumbline::markers

// Datum of a block that nothing ties to the ground: similarity motions in the space of its unknowns, and which of the
// equivalent solutions is meant.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "least_squares/problem/defects.hpp"
#include "photo/bundle/problem.hpp"

namespace plumbline::bundle {

/// Similarity motions about `centre` as vectors of all unknowns, n × 7 (order as in block/defects.hpp): what each
/// unknown changes by when the whole block moves. Scale changes tag sizes with the bodies.
Eigen::MatrixXd motions_of(const Problem& problem, const Layout& layout, const State& state,
                           const Eigen::Vector3d& centre);

/// Bodies (points, then the anchors of plates) with their names; fixed points too.
std::vector<least_squares::NamedPoint> bodies_of(const Problem& problem, const State& state);

/// Gauge of a free block: `count` of the similarity motions are unknown to the observations (6 without, 7 with scale),
/// and the sum of squared changes of the `held` unknowns against the start is to be smallest. count 0: not free.
struct Datum {
  int count = 0;
  std::vector<int> held;
};

/// Inner constraints over all bodies.
Datum inner_datum(const Problem& problem, const Layout& layout, int count);
/// The first image's six unknowns and, with scale, one coordinate of the projection centre furthest from it (the
/// largest of its base): how relative orientation is often fixed.
Datum first_image_datum(const Problem& problem, const Layout& layout, const State& state, int count);

/// How many similarity motions no observation sees: 0, 6 or 7, told from what there is, not numerically. A single known
/// or fixed body or image counts as a datum of its own (0): whether it is enough is for the rank to say.
int free_motions(const Problem& problem);

/// Moves the block along the motions it is free in until the held unknowns are where they were in `start`.
void restore_datum(const Problem& problem, const Layout& layout, const Datum& datum, const State& start, State& state);

}  // namespace plumbline::bundle

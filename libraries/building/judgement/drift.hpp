// Floor means, cumulative drift and height transfer, with the uncertainty that the full covariance gives them.
#pragma once

#include <memory>
#include <vector>

#include "building/judgement/difference.hpp"

namespace plumbline::judgement {

/// All floors from the lowest to the highest of the anchor table, those without anchors included.
std::vector<int> floors_of(const std::vector<AnchorEntry>& table);

/// r_f (1), D(F) (2), (3), relative drift and the statistics (11) of every floor in `floors`. D(F) starts at the lowest
/// floor and ends below the first floor without an anchor: a sum over a gap is not the sum of (2). It is left nan
/// unless `with_drift`.
std::vector<std::unique_ptr<FloorAccuracyT>> floor_accuracy(const DifferenceSet& set,
                                                            const std::vector<AnchorEntry>& table,
                                                            const std::vector<int>& floors, const Options& options,
                                                            bool with_drift);

/// Unweighted straight line through r_f over f; null with fewer than two floors that have anchors.
std::unique_ptr<DriftSlopeT> drift_slope(const DifferenceSet& set, const std::vector<AnchorEntry>& table,
                                         const std::vector<int>& floors, double confidence);

/// E_transfer (13) between adjacent floors: of the floor means, then of every column that has anchors on both floors.
std::vector<std::unique_ptr<HeightTransferT>> height_transfers(const DifferenceSet& set,
                                                               const std::vector<AnchorEntry>& table,
                                                               const std::vector<int>& floors, const Options& options);

/// Drift along every column that has anchors on at least two floors, by column number: (2) and (3) of the column alone,
/// and highest against lowest floor. The sum (2) needs an anchor of the column on every floor, and `with_drift`.
std::vector<std::unique_ptr<ColumnDriftT>> column_drifts(const DifferenceSet& set,
                                                         const std::vector<AnchorEntry>& table,
                                                         const std::vector<int>& floors, const Options& options,
                                                         bool with_drift);

}  // namespace plumbline::judgement

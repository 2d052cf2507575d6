// Tiles that are measured, kept until all are: a run that was killed or stopped goes on with those that are missing.
#pragma once

#include <atomic>
#include <string>

#include "plumbline/node.hpp"
#include "surface/dense/facet_tile.hpp"

namespace plumbline::surface {

/// Files in the folder that the host keeps for a node of these inputs and parameters ("partial:"). Where the host gives
/// none, or the disk refuses, nothing is kept and nothing is found.
class PartialTiles {
 public:
  explicit PartialTiles(const Context& context);
  bool has(size_t number) const;
  /// False if the tile is not there, or not whole.
  bool load(size_t number, FacetTile& tile);
  void save(size_t number, const FacetTile& tile) const;
  size_t found() const { return found_; }

 private:
  std::string path(size_t number) const;
  std::string folder_;
  std::atomic<size_t> found_ = 0;
};

}  // namespace plumbline::surface

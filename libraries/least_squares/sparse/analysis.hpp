// What of a factorisation follows from the pattern alone: the order in which blocks are eliminated, what fills up, and
// supernodes: neighbouring columns of the factor with (nearly) the same rows, which are stored and worked on as one
// dense panel. Made once, used for every factorisation on that pattern.
//
// Sources: Amestoy, Davis & Duff (1996), An approximate minimum degree ordering algorithm; George & Liu (1981),
// Computer Solution of Large Sparse Positive Definite Systems (trees, nested dissection from level structures);
// Ashcraft & Grimes (1989), The influence of relaxed supernode partitions.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "least_squares/sparse/pattern.hpp"

namespace plumbline::least_squares {

class Analysis {
 public:
  /// By minimum degree, or in the order given as one dense supernode where that is hardly more work. Deterministic.
  explicit Analysis(const Pattern& pattern);
  /// One supernode, unknowns in the order given: the panel is the matrix.
  bool is_dense() const { return is_dense_; }

  int unknown_count() const { return offsets_.back(); }
  int block_count() const { return static_cast<int>(offsets_.size()) - 1; }
  int offset(int block) const { return offsets_[block]; }
  int size(int block) const { return offset(block + 1) - offset(block); }
  /// Multiplications of the factorisation, nearly.
  double operations() const { return operations_; }
  /// Of a factor, or of a selected inverse; announce them before they are made.
  std::size_t bytes() const { return sizeof(double) * entries_; }
  /// Beside that, while a factorisation or a selected inverse is computed.
  std::size_t work_bytes() const { return sizeof(double) * work_; }

  // For the factorisation. Positions are those of the elimination.
  struct Supernode {
    int first = 0, width = 0;  ///< columns
    std::vector<int> rows;     ///< positions, ascending, its own columns first
    std::size_t begin = 0;     ///< of the panel (rows × width, column-major)
    struct Update {
      int from, row, count;  ///< an earlier supernode, its first row among our columns, how many of them
    };
    std::vector<Update> updates;  ///< ascending
    int height() const { return static_cast<int>(rows.size()); }
    /// Where a position stands among the rows, or −1. Precondition: it is not before the first.
    int row_of(int position) const {
      if (position < first + width) return position - first;
      const auto found = std::lower_bound(rows.begin() + width, rows.end(), position);
      return found != rows.end() && *found == position ? static_cast<int>(found - rows.begin()) : -1;
    }
  };
  const std::vector<Supernode>& supernodes() const { return supernodes_; }
  std::size_t entries() const { return entries_; }
  /// Position of the first unknown of a block; the others follow it.
  int position(int block) const { return positions_[block]; }
  /// The block at a position.
  int block_at(int position) const { return blocks_[position]; }
  /// Supernode whose column a position is.
  int supernode_at(int position) const { return supernode_at_[position]; }

 private:
  void make_supernodes(const std::vector<std::vector<int>>& neighbours, std::vector<int> order);
  void make_dense();
  void find_updates();
  void find_work();

  std::vector<int> offsets_, positions_, blocks_, supernode_at_;
  std::vector<Supernode> supernodes_;
  std::size_t entries_ = 0, work_ = 0;
  double operations_ = 0;
  bool is_dense_ = false;
};

}  // namespace plumbline::least_squares

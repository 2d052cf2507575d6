#include "least_squares/sparse/analysis.hpp"

#include <algorithm>
#include <numeric>

#include "least_squares/sparse/order.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::least_squares {
namespace {

using Lists = std::vector<std::vector<int>>;

constexpr int smallest_sparse = 64;
/// Multiplications of a factorisation from which on a better order is looked for: a tenth of a second of them.
constexpr double worth_dissecting = 3e8;

/// Parents in the elimination tree of the graph in this order (Liu 1986: with shortened paths); −1 for a root.
std::vector<int> elimination_tree(const Lists& neighbours, const std::vector<int>& order,
                                  const std::vector<int>& place) {
  std::vector<int> parent(order.size(), -1), ancestor(order.size(), -1);
  for (int k = 0; k < static_cast<int>(order.size()); ++k)
    for (int neighbour : neighbours[order[k]])
      for (int i = place[neighbour]; i >= 0 && i < k;) {
        const int next = ancestor[i];
        ancestor[i] = k;
        if (next < 0) parent[i] = k;
        i = next;
      }
  return parent;
}

/// The same order but for what the tree leaves open: children just before their parents.
std::vector<int> postorder(const std::vector<int>& parent) {
  const int n = static_cast<int>(parent.size());
  std::vector<int> first(parent.size(), -1), next(parent.size(), -1), result, stack;
  for (int k = n - 1; k >= 0; --k)
    if (parent[k] >= 0) next[k] = first[parent[k]], first[parent[k]] = k;
  for (int root = 0; root < n; ++root) {
    if (parent[root] >= 0) continue;
    stack.push_back(root);
    while (!stack.empty()) {
      const int node = stack.back();
      if (const int child = first[node]; child >= 0) {
        first[node] = next[child];
        stack.push_back(child);
      } else {
        result.push_back(node);
        stack.pop_back();
      }
    }
  }
  return result;
}

/// Blocks below the diagonal of the factor, by column, in the numbers of the order.
Lists structure_of(const Lists& neighbours, const std::vector<int>& order, const std::vector<int>& place,
                   const std::vector<int>& parent) {
  Lists structure(order.size());
  std::vector<int> seen_by(order.size(), -1);
  Lists children(order.size());
  for (int k = 0; k < static_cast<int>(order.size()); ++k) {
    stop_point();
    std::vector<int>& own = structure[k];
    seen_by[k] = k;
    const auto take = [&](int row) {
      if (row <= k || seen_by[row] == k) return;
      seen_by[row] = k;
      own.push_back(row);
    };
    for (int neighbour : neighbours[order[k]]) take(place[neighbour]);
    for (int child : children[k])
      for (int row : structure[child]) take(row);
    std::sort(own.begin(), own.end());
    if (parent[k] >= 0) children[parent[k]].push_back(k);
  }
  return structure;
}

/// Neighbouring columns that are stored as one, with zeros where their rows differ.
struct Merged {
  int first = 0, last = 0;  ///< columns of blocks
  int width = 0;            ///< unknowns
  double filled = 0;        ///< entries of the factor that need be there
};

/// Whether the panel of two supernodes holds few enough zeros: one wide panel is worked on faster than two narrow ones.
bool is_worth_it(double zeros, double all, int width) {
  if (zeros <= 0) return true;
  if (width <= 24) return zeros < 0.5 * all;
  if (width <= 64) return zeros < 0.15 * all;
  return zeros < 0.05 * all;
}

}  // namespace

Analysis::Analysis(const Pattern& pattern) {
  offsets_.push_back(0);
  for (int b = 0; b < pattern.block_count(); ++b) offsets_.push_back(offsets_.back() + pattern.size(b));
  const Lists neighbours = neighbours_of(pattern);
  std::vector<int> order = minimum_degree_order(neighbours);
  std::erase_if(order, [&](int b) { return size(b) == 0; });
  make_supernodes(neighbours, std::move(order));
  const double n = unknown_count(), dense = n * n * n / 6, most = 0.6 * dense;
  if (operations_ > worth_dissecting && operations_ <= most) {
    // Minimum degree is hard to beat on strips of images, and dissection better on wide blocks, by up to a quarter: the
    // one that multiplies less stays.
    std::vector<int> sizes;
    for (int b = 0; b < block_count(); ++b) sizes.push_back(size(b));
    Analysis dissected = *this;
    dissected.supernodes_.clear();
    dissected.entries_ = 0, dissected.operations_ = 0;
    dissected.make_supernodes(neighbours, nested_dissection_order(neighbours, sizes));
    if (dissected.operations_ < operations_) *this = std::move(dissected);
  }
  // Columns in the order given need not be gathered, and a single panel has the fewest ends of loops.
  if (operations_ > most || unknown_count() <= smallest_sparse) {
    make_dense();
    operations_ = dense;
  }
  find_work();
}

void Analysis::make_dense() {
  is_dense_ = true;
  positions_.assign(offsets_.begin(), offsets_.end() - 1);
  for (int b = 0; b < block_count(); ++b) std::fill_n(blocks_.begin() + offset(b), size(b), b);
  supernodes_.clear();
  const int n = unknown_count();
  if (n == 0) return;
  Supernode& s = supernodes_.emplace_back();
  s.width = n;
  s.rows.resize(n);
  std::iota(s.rows.begin(), s.rows.end(), 0);
  supernode_at_.assign(n, 0);
  entries_ = static_cast<std::size_t>(n) * n;
}

void Analysis::make_supernodes(const Lists& neighbours, std::vector<int> order) {
  positions_.assign(block_count(), 0);
  blocks_.assign(unknown_count(), 0);
  supernode_at_.assign(unknown_count(), 0);
  std::vector<int> place(neighbours.size(), -1);
  const auto renumber = [&] {
    for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = static_cast<int>(k);
  };
  renumber();
  const std::vector<int> sequence = postorder(elimination_tree(neighbours, order, place));
  std::vector<int> sorted;
  for (int k : sequence) sorted.push_back(order[k]);
  order = std::move(sorted);
  renumber();
  const std::vector<int> parent = elimination_tree(neighbours, order, place);
  const Lists structure = structure_of(neighbours, order, place, parent);

  std::vector<int> first_position = {0};  // of each column of blocks
  for (int b : order) first_position.push_back(first_position.back() + size(b));
  const auto height_below = [&](int column) {
    int height = 0;
    for (int row : structure[column]) height += size(order[row]);
    return height;
  };
  const auto trapezoid = [](double width, double below) { return width * (width + 1) / 2 + width * below; };
  std::vector<Merged> merged;
  for (int k = 0; k < static_cast<int>(order.size()); ++k) {
    const int below = height_below(k), own = size(order[k]);
    Merged node{k, k, own, trapezoid(own, below)};
    while (!merged.empty()) {
      const Merged& before = merged.back();
      if (parent[before.last] < node.first || parent[before.last] > node.last) break;
      const int width = before.width + node.width;
      const double all = trapezoid(width, below), filled = before.filled + node.filled;
      if (!is_worth_it(all - filled, all, width)) break;
      node = {before.first, node.last, width, filled};
      merged.pop_back();
    }
    merged.push_back(node);
  }

  for (std::size_t k = 0; k < order.size(); ++k) {
    positions_[order[k]] = first_position[k];
    std::fill_n(blocks_.begin() + first_position[k], size(order[k]), order[k]);
  }
  for (const Merged& node : merged) {
    Supernode& s = supernodes_.emplace_back();
    s.first = first_position[node.first];
    s.width = node.width;
    s.rows.resize(node.width);
    std::iota(s.rows.begin(), s.rows.end(), s.first);
    for (int row : structure[node.last])
      for (int p = first_position[row]; p < first_position[row + 1]; ++p) s.rows.push_back(p);
    std::fill_n(supernode_at_.begin() + s.first, s.width, static_cast<int>(supernodes_.size()) - 1);
    s.begin = entries_;
    entries_ += static_cast<std::size_t>(s.height()) * s.width;
  }
  find_updates();
}

void Analysis::find_updates() {
  for (int from = 0; from < static_cast<int>(supernodes_.size()); ++from) {
    const std::vector<int>& rows = supernodes_[from].rows;
    const int height = static_cast<int>(rows.size());
    for (int row = supernodes_[from].width; row < height;) {
      const int to = supernode_at(rows[row]);
      int end = row;
      while (end < height && supernode_at(rows[end]) == to) ++end;
      supernodes_[to].updates.push_back({from, row, end - row});
      row = end;
    }
    const double h = height, w = supernodes_[from].width;
    operations_ += (w * h * h - w * w * h + w * w * w / 3) / 2;
  }
}

void Analysis::find_work() {
  work_ = 0;
  for (const Supernode& s : supernodes_) {
    for (const auto& update : s.updates)
      work_ = std::max(work_, static_cast<std::size_t>(supernodes_[update.from].height() - update.row) * update.count);
    // A selected inverse gathers what belongs to the rows below, and multiplies it with the columns.
    const std::size_t width = s.width, below = s.rows.size() - width;
    work_ = std::max(work_, below * below + 2 * below * width + width * width);
  }
}

}  // namespace plumbline::least_squares

#include "least_squares/sparse/separator.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <queue>
#include <tuple>

#include "plumbline/stop.hpp"

namespace plumbline::least_squares {
namespace {

constexpr int coarsest = 60, starts_tried = 8, passes = 8, moves_in_vain = 100;
constexpr double shrinks = 0.9, heaviest_side = 0.6;

struct Coarse {
  Graph graph;
  std::vector<int> of_fine;  ///< vertex that a finer one is part of
};

/// Heavy edge matching: vertices that have much in common become one.
std::vector<int> match(const Graph& graph, int& count) {
  std::vector<int> order(graph.weights.size()), coarse(graph.weights.size(), -1);
  std::iota(order.begin(), order.end(), 0);
  const auto degree = [&](int v) { return graph.starts[v + 1] - graph.starts[v]; };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return degree(a) < degree(b); });
  const std::int64_t all = std::accumulate(graph.weights.begin(), graph.weights.end(), std::int64_t{0});
  const std::int64_t heaviest = std::max<std::int64_t>(1, 3 * all / (2 * coarsest));
  count = 0;
  for (int v : order) {
    if (coarse[v] >= 0) continue;
    int best = -1, strongest = 0;
    for (int e = graph.starts[v]; e < graph.starts[v + 1]; ++e) {
      const int other = graph.neighbours[e];
      if (coarse[other] >= 0 || graph.edge_weights[e] < strongest || graph.weights[v] + graph.weights[other] > heaviest)
        continue;
      if (graph.edge_weights[e] == strongest && best >= 0 && graph.weights[other] >= graph.weights[best]) continue;
      best = other, strongest = graph.edge_weights[e];
    }
    coarse[v] = count;
    if (best >= 0) coarse[best] = count;
    ++count;
  }
  return coarse;
}

Coarse coarsen(const Graph& graph) {
  Coarse made;
  int count = 0;
  made.of_fine = match(graph, count);
  std::vector<std::vector<int>> members(count);
  for (int v = 0; v < graph.size(); ++v) members[made.of_fine[v]].push_back(v);
  std::vector<int> place(count, -1);  // of an edge to that vertex among the edges of the one at work
  Graph& coarse = made.graph;
  for (int c = 0; c < count; ++c) {
    int weight = 0;
    const int begin = coarse.starts.back();
    for (int v : members[c]) {
      weight += graph.weights[v];
      for (int e = graph.starts[v]; e < graph.starts[v + 1]; ++e) {
        const int other = made.of_fine[graph.neighbours[e]];
        if (other == c) continue;
        if (place[other] < begin) {
          place[other] = static_cast<int>(coarse.neighbours.size());
          coarse.neighbours.push_back(other);
          coarse.edge_weights.push_back(0);
        }
        coarse.edge_weights[place[other]] += graph.edge_weights[e];
      }
    }
    coarse.weights.push_back(weight);
    coarse.starts.push_back(static_cast<int>(coarse.neighbours.size()));
  }
  return made;
}

/// A separator that is moved through the graph: a vertex of it goes to one side, and its neighbours on the other side
/// take its place.
class Moving {
 public:
  Moving(const Graph& graph, std::vector<Side> sides) : graph_(graph), sides_(std::move(sides)) {
    for (int v = 0; v < graph.size(); ++v) weight_[sides_[v]] += graph.weights[v];
    all_ = weight_[left] + weight_[right] + weight_[between];
  }

  /// What is to be small: the separator, the more so the more the sides differ; and what a side has above its share.
  double score() const {
    const double heavier = static_cast<double>(std::max(weight_[left], weight_[right])),
                 all = static_cast<double>(all_);
    const double uneven = static_cast<double>(std::abs(weight_[left] - weight_[right])) / all;
    return static_cast<double>(weight_[between]) * (1 + uneven) + std::max(0.0, heavier - heaviest_side * all);
  }
  std::vector<Side> take() && { return std::move(sides_); }

  void refine() {
    for (int pass = 0; pass < passes; ++pass)
      if (!improve()) return;
  }

 private:
  struct Candidate {
    std::int64_t gain;
    int vertex;
    Side to;
    bool operator<(const Candidate& other) const {
      return std::tie(gain, other.vertex, other.to) < std::tie(other.gain, vertex, to);
    }
  };

  std::int64_t gain_of(int v, Side to) const {
    const Side from = to == left ? right : left;
    std::int64_t gain = graph_.weights[v];
    for (int e = graph_.starts[v]; e < graph_.starts[v + 1]; ++e)
      if (sides_[graph_.neighbours[e]] == from) gain -= graph_.weights[graph_.neighbours[e]];
    return gain;
  }

  void set(int v, Side to) {
    undo_.push_back({v, sides_[v]});
    weight_[sides_[v]] -= graph_.weights[v];
    weight_[to] += graph_.weights[v];
    sides_[v] = to;
  }

  void offer(int v) {
    if (moved_[v]) return;
    for (Side to : {left, right}) queue_.push({gain_of(v, to), v, to});
  }

  void move(int v, Side to) {
    const Side from = to == left ? right : left;
    moved_[v] = true;
    set(v, to);
    std::vector<int> arrived;
    for (int e = graph_.starts[v]; e < graph_.starts[v + 1]; ++e) {
      const int other = graph_.neighbours[e];
      if (sides_[other] == from) set(other, between), arrived.push_back(other);
    }
    // What borders the separator anew, or no longer, has another gain.
    for (int other : arrived) {
      offer(other);
      for (int e = graph_.starts[other]; e < graph_.starts[other + 1]; ++e)
        if (sides_[graph_.neighbours[e]] == between) offer(graph_.neighbours[e]);
    }
    for (int e = graph_.starts[v]; e < graph_.starts[v + 1]; ++e)
      if (sides_[graph_.neighbours[e]] == between) offer(graph_.neighbours[e]);
  }

  /// One pass: every vertex leaves the separator once at most; the best of what was seen stays. False if that is what
  /// was there.
  bool improve() {
    moved_.assign(graph_.weights.size(), false);
    undo_.clear();
    queue_ = {};
    too_heavy_.clear();
    for (int v = 0; v < graph_.size(); ++v)
      if (sides_[v] == between) offer(v);
    double best = score();
    std::size_t best_at = 0;
    bool better = false;
    for (int in_vain = 0; in_vain < moves_in_vain && !queue_.empty();) {
      const Candidate next = queue_.top();
      queue_.pop();
      if (moved_[next.vertex] || sides_[next.vertex] != between || gain_of(next.vertex, next.to) != next.gain) continue;
      const double limit = heaviest_side * static_cast<double>(all_);
      const double after = static_cast<double>(weight_[next.to] + graph_.weights[next.vertex]);
      if (after > limit && after > static_cast<double>(weight_[next.to == left ? right : left])) {
        too_heavy_.push_back(next);  // by now
        continue;
      }
      move(next.vertex, next.to);
      for (const Candidate& waiting : too_heavy_) queue_.push(waiting);
      too_heavy_.clear();
      ++in_vain;
      if (score() < best) best = score(), best_at = undo_.size(), better = true, in_vain = 0;
    }
    while (undo_.size() > best_at) {
      const auto [v, side] = undo_.back();
      weight_[sides_[v]] -= graph_.weights[v];
      weight_[side] += graph_.weights[v];
      sides_[v] = side;
      undo_.pop_back();
    }
    return better;
  }

  const Graph& graph_;
  std::vector<Side> sides_;
  std::int64_t weight_[3] = {0, 0, 0}, all_ = 0;
  std::vector<bool> moved_;
  std::vector<std::pair<int, Side>> undo_;
  std::priority_queue<Candidate> queue_;
  std::vector<Candidate> too_heavy_;
};

/// All vertices in the order in which a search in breadth from `start` finds them; then those of other parts, likewise.
std::vector<int> breadth_first(const Graph& graph, int start) {
  std::vector<int> found;
  std::vector<bool> seen(graph.weights.size(), false);
  const auto find = [&](int v) {
    if (!seen[v]) seen[v] = true, found.push_back(v);
  };
  find(start);
  std::size_t next = 0;
  for (int v = 0; v < graph.size(); ++v) {
    for (; next < found.size(); ++next)
      for (int e = graph.starts[found[next]]; e < graph.starts[found[next] + 1]; ++e) find(graph.neighbours[e]);
    find(v);
  }
  return found;
}

/// What a search from `start` finds first, half of the weight, and its border.
std::vector<Side> grown_from(const Graph& graph, int start) {
  const std::int64_t all = std::accumulate(graph.weights.begin(), graph.weights.end(), std::int64_t{0});
  std::vector<Side> sides(graph.weights.size(), right);
  std::int64_t weight = 0;
  for (int v : breadth_first(graph, start)) {
    if (2 * weight >= all) break;
    sides[v] = left;
    weight += graph.weights[v];
  }
  for (int v = 0; v < graph.size(); ++v)
    for (int e = graph.starts[v]; e < graph.starts[v + 1] && sides[v] == right; ++e)
      if (sides[graph.neighbours[e]] == left) sides[v] = between;
  return sides;
}

std::vector<Side> separator_of_small(const Graph& graph) {
  std::vector<Side> best(graph.weights.size(), right);
  double least = std::numeric_limits<double>::infinity();
  int start = breadth_first(graph, 0).back();  // far out
  for (int trial = 0; trial < std::min(starts_tried, graph.size()); ++trial) {
    Moving moving(graph, grown_from(graph, start));
    moving.refine();
    if (moving.score() < least) least = moving.score(), best = std::move(moving).take();
    start = trial == 0 ? breadth_first(graph, start).back() : (trial * graph.size()) / starts_tried;
  }
  return best;
}

}  // namespace

std::vector<Side> find_separator(const Graph& graph) {
  stop_point();
  if (graph.size() == 0) return {};
  if (graph.size() <= coarsest) return separator_of_small(graph);
  const Coarse coarse = coarsen(graph);
  if (coarse.graph.size() > shrinks * graph.size()) return separator_of_small(graph);
  const std::vector<Side> of_coarse = find_separator(coarse.graph);
  std::vector<Side> sides(graph.weights.size());
  for (int v = 0; v < graph.size(); ++v) sides[v] = of_coarse[coarse.of_fine[v]];
  Moving moving(graph, std::move(sides));
  moving.refine();
  return std::move(moving).take();
}

}  // namespace plumbline::least_squares

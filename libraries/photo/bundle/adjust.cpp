#include "photo/bundle/adjust.hpp"

#include <fmt/core.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "base/text/words.hpp"
#include "geometry/linear_algebra/decompositions.hpp"
#include "photo/bundle/parts.hpp"
#include "photo/bundle/weakest.hpp"
#include "plumbline/failure.hpp"

namespace plumbline::bundle {
namespace {

constexpr double rank_tolerance = 1e-12;  ///< of scaled eigenvalues; rounding leaves about 1e-15
constexpr double weak_eigenvalue = 1e-9;  ///< below it a step of unit length changes next to nothing

/// Null vectors of the reduced, scaled matrix of a free block, orthonormal.
Eigen::MatrixXd motions_of_kept(const Problem& problem, const Layout& layout, const State& state,
                                const Elimination& elimination, const Datum& datum) {
  if (datum.count == 0 || elimination.kept_count() < datum.count) return {};
  const Eigen::MatrixXd g =
      motions_of(problem, layout, state, least_squares::centre_of(bodies_of(problem, state))).leftCols(datum.count);
  Eigen::MatrixXd kept = Eigen::MatrixXd::Zero(elimination.kept_count(), datum.count);
  for (int b : elimination.kept_blocks())
    kept.middleRows(elimination.kept_offset(b), layout.size(b)) = g.middleRows(layout.offset(b), layout.size(b));
  kept = elimination.scale().cwiseInverse().asDiagonal() * kept;
  return linear_algebra::orthonormal_columns(kept);
}

/// A vector of the scaled reduced system as a direction in all unknowns, scaled to their conditional standard
/// deviations.
struct Direction {
  Eigen::VectorXd unknowns;
};
Direction full_direction(const Layout& layout, const Elimination& elimination, const Eigen::VectorXd& scaled) {
  Direction d;
  d.unknowns.setZero(layout.unknown_count());
  const Eigen::VectorXd kept = elimination.scale().cwiseProduct(scaled);
  for (int b = 0; b < layout.block_count(); ++b)
    if (const int at = elimination.kept_offset(b); at >= 0)
      d.unknowns.segment(layout.offset(b), layout.size(b)) = kept.segment(at, layout.size(b));
  for (const auto& block : elimination.blocks()) {
    if (block.weakest < rank_tolerance) continue;
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(block.size);
    const auto y = elimination.y(block);
    for (size_t k = 0; k < block.kept.size(); ++k)
      sum -= y.middleCols(block.local[k], layout.size(block.kept[k])) *
             kept.segment(elimination.kept_offset(block.kept[k]), layout.size(block.kept[k]));
    d.unknowns.segment(layout.offset(block.block), block.size) =
        block.factor.topLeftCorner(block.size, block.size).triangularView<Eigen::Lower>().transpose().solve(sum);
  }
  return d;
}

/// "the pose of image 3", "the position of F01-C02-R1"
std::string name_of_block(const Problem& problem, const Ref& ref) {
  const size_t i = static_cast<size_t>(ref.index);
  if (ref.kind == Kind::image) return "the pose of " + problem.images[i].name;
  return "the position of " + (ref.kind == Kind::point ? problem.points[i].name : problem.plates[i].name);
}

/// What a direction does, in words: a motion of the whole block if it is nearly one, else the unknowns with the largest
/// part in it.
std::string describe_direction(const Problem& problem, const Layout& layout, const State& state,
                               const Elimination& elimination, const Eigen::VectorXd& direction) {
  const auto bodies = bodies_of(problem, state);
  const Eigen::Vector3d centre = least_squares::centre_of(bodies);
  std::vector<int> body_unknowns;
  for (int b = 0; b < layout.block_count(); ++b) {
    const Kind kind = layout.ref(b).kind;
    if ((kind == Kind::point || kind == Kind::plate) && layout.size(b) > 0)
      for (int c = 0; c < 3; ++c) body_unknowns.push_back(layout.offset(b) + c);
  }
  if (body_unknowns.size() >= 9) {
    const Eigen::MatrixXd g = motions_of(problem, layout, state, centre)(body_unknowns, Eigen::all);
    const Eigen::VectorXd moved = direction(body_unknowns);
    const Eigen::VectorXd motion = linear_algebra::minimum_norm_solution(g, moved);
    if (moved.norm() > 0 && (g * motion - moved).norm() < 0.05 * moved.norm()) {
      double extent = 1e-9;
      for (const auto& b : bodies) extent = std::max(extent, (b.position - centre).norm());
      std::vector<least_squares::NamedPoint> still;  // what stays where it is names the axis
      double largest = 0;
      for (Eigen::Index i = 0; i + 2 < moved.size(); i += 3) largest = std::max(largest, moved.segment<3>(i).norm());
      for (size_t i = 0; i < bodies.size() && 3 * i + 2 < static_cast<size_t>(moved.size()); ++i)
        if (moved.segment<3>(static_cast<Eigen::Index>(3 * i)).norm() < 0.02 * largest) still.push_back(bodies[i]);
      const auto names = least_squares::describe_motions(motion, centre, extent, still);
      if (!names.empty()) return names.front() + " of the whole block";
    }
  }
  const Eigen::VectorXd scaled = direction.cwiseProduct(elimination.diagonal().cwiseMax(0).cwiseSqrt());
  for (int b = 0; b < layout.block_count(); ++b) {  // all of it in one point, plate or image
    const Kind kind = layout.ref(b).kind;
    if ((kind == Kind::point || kind == Kind::plate || kind == Kind::image) && layout.size(b) > 0 &&
        scaled.segment(layout.offset(b), layout.size(b)).squaredNorm() > 0.999 * scaled.squaredNorm())
      return name_of_block(problem, layout.ref(b));
  }
  std::vector<int> order(static_cast<size_t>(scaled.size()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return std::abs(scaled(a)) > std::abs(scaled(b)); });
  std::vector<std::string> parts;
  for (size_t k = 0; k < std::min<size_t>(order.size(), 4); ++k)
    if (k == 0 || std::abs(scaled(order[k])) > 0.3 * std::abs(scaled(order[0])))
      parts.push_back(name_of_unknown(problem, layout, order[k]));
  return "a combination of " + text::enumerate(parts);
}

/// Where most of the misfit is, for a message.
std::string worst_images(const Problem& problem, const Layout& layout, const State& state) {
  std::vector<double> squares(problem.images.size());
  std::vector<int> rows(problem.images.size());
  Rows r;
  const auto add = [&](const auto& term) {
    const size_t image = static_cast<size_t>(term.image);
    ++rows[image];
    squares[image] += evaluate(problem, layout, state, term, false, r) ? r.values().squaredNorm() / r.rows : 1e12;
  };
  for (const auto& o : problem.image_points) add(o);
  for (const auto& o : problem.image_tags) add(o);
  std::vector<size_t> order(squares.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const auto rms = [&](size_t i) { return rows[i] > 0 ? std::sqrt(squares[i] / rows[i]) : 0.0; };
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return rms(a) > rms(b); });
  std::vector<std::string> words;
  for (size_t k = 0; k < std::min<size_t>(3, order.size()); ++k) {
    const std::string text = fmt::format(" (rms {:.3g} sigma)", rms(order[k]));
    words.push_back(problem.images[order[k]].name + text);
  }
  return text::enumerate(words);
}

/// Largest correction in units of the conditional standard deviation of its unknown.
double largest_step(const Elimination& elimination, const Eigen::VectorXd& step) {
  return step.cwiseAbs().cwiseProduct(elimination.diagonal().cwiseMax(0).cwiseSqrt()).maxCoeff();
}

[[noreturn]] void fail_to_converge(const Problem& problem, const Layout& layout, const State& state,
                                   Elimination& elimination, const Datum& datum, int iterations,
                                   const std::string& engine) {
  std::string cause;
  Eigen::VectorXd weakest;
  if (elimination.build(state)) {
    if (require_determined(problem, layout, state, elimination, datum) && elimination.kept_count() > 0 &&
        smallest_eigenvalue(elimination.factor(), motions_of_kept(problem, layout, state, elimination, datum),
                            weakest) < weak_eigenvalue)
      cause = "the observations hardly determine " +
              describe_direction(problem, layout, state, elimination,
                                 full_direction(layout, elimination, weakest).unknowns) +
              ": every step along it changes the fit by next to nothing; add observations that fix it, or hold it";
  }
  if (cause.empty())
    cause = "the approximate values do not lead to a minimum: the worst fit is in " +
            worst_images(problem, layout, state) + "; check their approximate poses and point numbers";
  throw NotConverged("the block adjustment did not converge in " + std::to_string(iterations) +
                     " iterations: " + cause + (engine.empty() ? "" : " (the engine says: " + engine + ")"));
}

/// Of each eliminated image or body by itself.
void require_eliminated_determined(const Problem& problem, const Layout& layout, const Elimination& elimination) {
  std::vector<std::string> images, points;
  for (const auto& block : elimination.blocks()) {
    if (block.weakest >= rank_tolerance) continue;
    const Ref ref = layout.ref(block.block);
    if (ref.kind == Kind::image)
      images.push_back(problem.images[ref.index].name);
    else
      points.push_back(ref.kind == Kind::point ? problem.points[ref.index].name : problem.plates[ref.index].name);
  }
  if (images.size() > 10) images = {images[0], images[1], std::to_string(images.size() - 2) + " others"};
  if (points.size() > 10) points = {points[0], points[1], std::to_string(points.size() - 2) + " others"};
  if (!images.empty())
    throw std::runtime_error("the pose of " + text::enumerate(images) +
                             " is undetermined: too few or only collinear points in the image");
  if (!points.empty())
    throw std::runtime_error("the position of " + text::enumerate(points) +
                             " is undetermined: its rays are parallel or it is seen only once");
}

}  // namespace

bool require_determined(const Problem& problem, const Layout& layout, const State& state, Elimination& elimination,
                        const Datum& datum) {
  require_eliminated_determined(problem, layout, elimination);
  const Eigen::Index n = elimination.kept_count();
  if (n == 0) return true;
  const Eigen::MatrixXd motions = motions_of_kept(problem, layout, state, elimination, datum);
  const bool factorised = elimination.factorise(motions);
  Eigen::VectorXd weakest;
  constexpr double limit = 2 * rank_tolerance;
  if (factorised && smallest_eigenvalue(elimination.factor(), motions, weakest, 1e4 * limit) > limit) return true;
  const Spectrum spectrum = smallest_eigenvalues(elimination, motions, rank_tolerance);
  std::string message;
  int defect = 0;
  for (Eigen::Index i = 0; i < spectrum.values.size() && spectrum.values(i) < rank_tolerance; ++i, ++defect) {
    if (defect >= 7) continue;
    const std::string words =
        "; " + describe_direction(problem, layout, state, elimination,
                                  full_direction(layout, elimination, spectrum.vectors.col(i)).unknowns);
    if (message.find(words) == std::string::npos) message += words;  // one point may be open in several directions
  }
  if (defect == 0) return factorised;
  if (const std::string parts = words_of_parts(problem); !parts.empty()) throw std::runtime_error(parts);
  throw std::runtime_error("the block has a rank defect of " + std::to_string(defect) + ": undetermined is" +
                           message.substr(1));
}

namespace {

/// Takes a state to its minimum by undamped steps.
class Refinement {
 public:
  Refinement(const Problem& problem, const Layout& layout, const State& start, const AdjustOptions& options)
      : problem_(problem), layout_(layout), start_(start), options_(options) {}

  /// False if the steps do not get smaller; then `state` is where they led. The elimination is one at the state, or so
  /// near that its factors are those there.
  bool run(State& state, Elimination& elimination) {
    double last = std::numeric_limits<double>::infinity();
    bool shrinks = false;  // few photographs of wide angle let the steps swing, each seven tenths of the last
    for (steps_ = 0; steps_ < most || (shrinks && steps_ < most_shrinking);) {
      if (!elimination.build(state) || !factorise(state, elimination)) return false;
      sum_of_squares_ = elimination.sum_of_squares();
      const Eigen::VectorXd step = elimination.step();
      const double size = largest_step(elimination, step);
      if (size < smallest) return true;
      if (!step.allFinite() || (size > 100 && size > 10 * last)) return false;
      shrinks = size < 0.9 * last;
      last = size;
      ++steps_;
      const double moved = std::sqrt(std::max(0.0, step.dot(elimination.right())));
      move(step, state);
      if (correct(elimination, size, moved, state)) return true;
    }
    return false;
  }
  /// From a state nearby; nothing if the steps do not get smaller.
  void follow(const Elimination& elimination, State& state) {
    correct(elimination, std::numeric_limits<double>::infinity(), 0, state);
  }

  int steps() const { return steps_; }
  double sum_of_squares() const { return sum_of_squares_; }

 private:
  static constexpr int most = 30, most_shrinking = 60;
  static constexpr double smallest = 1e-7;  ///< of the largest correction, in conditional standard deviations

  bool factorise(const State& state, Elimination& elimination) {
    if (steps_ == 0 && !options_.is_determined)
      return require_determined(problem_, layout_, state, elimination, options_.datum);
    return elimination.factorise(motions_of_kept(problem_, layout_, state, elimination, options_.datum));
  }

  void move(const Eigen::VectorXd& step, State& state) {
    apply_step(problem_, layout_, step, state);
    restore_datum(problem_, layout_, options_.datum, start_, state);
  }

  /// Further steps with the same factors, as long as each is far smaller than the one before: they cost a fifth of one
  /// with its own, and over the small way that is left the derivatives hardly change. True if they lead to the minimum
  /// and that is nearby; `moved` is how far the first one led.
  bool correct(const Elimination& elimination, double size, double moved, State& state) {
    constexpr double contraction = 0.2;
    Eigen::VectorXd right;
    while (size >= 0.1 * smallest) {
      if (!elimination.gradient(state, right, sum_of_squares_)) return false;
      const Eigen::VectorXd step = elimination.step(right);
      const double next = largest_step(elimination, step);
      if (!(next < contraction * size)) return next < smallest && moved < options_.nearby;
      moved += std::sqrt(std::max(0.0, step.dot(right)));
      move(step, state);
      size = next;
    }
    return moved < options_.nearby;
  }

  const Problem& problem_;
  const Layout& layout_;
  const State& start_;
  const AdjustOptions& options_;
  int steps_ = 0;
  double sum_of_squares_ = 0;
};

}  // namespace

void follow(const Problem& problem, const Layout& layout, const AdjustOptions& options, Adjusted& adjusted) {
  const State start = adjusted.state;
  Refinement(problem, layout, start, options).follow(*adjusted.elimination, adjusted.state);
}

Adjusted adjust(const Problem& problem, const Layout& layout, const State& start, const AdjustOptions& options) {
  problem.require_consistent();
  Adjusted result;
  result.rows = problem.row_count();
  result.unknowns = layout.unknown_count();
  result.defect = options.datum.count;
  MinimiseOptions minimise = options.minimise;
  minimise.loss = {};
  const auto eliminate = [&] {
    result.elimination = std::make_unique<Elimination>(problem, layout, minimise.side, minimise.threads);
  };
  eliminate();
  if (options.announce) options.announce(result.elimination->bytes());
  Refinement refinement(problem, layout, start, options);
  MinimiseSummary summary;
  bool found = false;
  if (options.start_is_near) {
    result.state = start;
    found = refinement.run(result.state, *result.elimination);
  }
  if (!found) {
    if (options.start_is_near) eliminate();  // the minimiser has one of its own: not two at a time
    result.state = start;
    summary = options.minimiser(problem, result.state, minimise);
    restore_datum(problem, layout, options.datum, start, result.state);
    found = refinement.run(result.state, *result.elimination);
  }
  Elimination& elimination = *result.elimination;
  result.iterations = summary.iterations + refinement.steps();
  if (!elimination.undefined().empty())
    throw std::runtime_error(elimination.undefined() +
                             " cannot be computed after the adjustment: it lies behind the camera or outside the "
                             "camera model; a wrong number or a bad approximate pose");
  if (!found)
    fail_to_converge(problem, layout, result.state, elimination, options.datum, result.iterations, summary.message);
  result.sum_of_squares = refinement.sum_of_squares();
  if (options.with_cofactors)
    result.cofactors = std::make_unique<Cofactors>(problem, layout, result.state, elimination, options.datum);
  return result;
}

Adjusted adjust_by_gradients(const Problem& problem, const Layout& layout, const State& start,
                             const AdjustOptions& options) {
  problem.require_consistent();
  Adjusted result;
  result.rows = problem.row_count();
  result.unknowns = layout.unknown_count();
  result.defect = options.datum.count;
  result.state = start;
  MinimiseOptions minimise = options.minimise;
  minimise.loss = {};
  minimise.reduced = Reduced::gradients;
  const auto eliminate = [&] {
    return std::make_unique<Elimination>(problem, layout, minimise.side, minimise.threads, minimise.reduced);
  };
  if (options.announce) options.announce(eliminate()->bytes());
  const MinimiseSummary summary = options.minimiser(problem, result.state, minimise);
  restore_datum(problem, layout, options.datum, start, result.state);
  result.iterations = summary.iterations;
  result.elimination = eliminate();
  Elimination& elimination = *result.elimination;
  if (!elimination.build(result.state))
    throw std::runtime_error(elimination.undefined() +
                             " cannot be computed after the adjustment: it lies behind the camera or outside the "
                             "camera model; a wrong number or a bad approximate pose");
  require_eliminated_determined(problem, layout, elimination);
  if (!elimination.factorise({}))
    throw std::runtime_error("undetermined is " +
                             name_of_unknown(problem, layout, layout.offset(elimination.open_block())));
  if (!summary.converged)
    throw NotConverged("the block adjustment did not converge in " + std::to_string(summary.iterations) +
                       " iterations: the worst fit is in " + worst_images(problem, layout, result.state) +
                       " (the engine says: " + summary.message + ")");
  result.sum_of_squares = elimination.sum_of_squares();
  return result;
}

}  // namespace plumbline::bundle

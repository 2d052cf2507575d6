// Bundle adjustment of synthetic blocks of the shape of well-known ones: our own solver and Ceres, from the
// same start, with the same derivatives and the same stopping rule, one thread, one run beside the other. Answers are
// checked: same final cost, and coordinates near the truth. Then the covariance by selected inverse.
//
//   adjust_benchmark [IMAGES POINTS RAYS [anywhere] | FOLDER]
//                                  FOLDER: an AICON block, a PhotoModeler export, a BAL problem; anywhere: points are
//                                  seen by images of the whole ring, so that the factor fills up
//   adjust_benchmark apart MINUTES IMAGES POINTS RAYS [ENGINE]
//                                  every engine once in a process of its own, ended after so many minutes of the
//                                  processor: for blocks that an engine may not get through; ENGINE: those whose name
//                                  has that word
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "apart.hpp"
#include "photo/block/image_block_folder.hpp"
#include "photo/block/point_block.hpp"
#include "photo/bundle/adjust.hpp"
#include "photo/bundle/ceres_covariance.hpp"
#include "photo/colmap/exchange.hpp"
#include "ring_block.hpp"

namespace {

using namespace plumbline;
using namespace plumbline::bundle;
/// Time of this process alone: other programs on the machine do not count.
double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Captured {};

/// The problem and the start that a block of another program's files becomes.
Made read(const char* folder) {
  Made made;
  block::PointBlockOptions options;
  options.minimiser = [&](const Problem& problem, State& state, const MinimiseOptions&) -> MinimiseSummary {
    made.problem = problem;
    made.start = state;
    throw Captured();
  };
  try {
    block::adjust_point_block(block::read_image_block(folder, "", "", {}).block, options);
  } catch (const Captured&) {
  }
  return made;
}

struct Run {
  double seconds = 0;
  MinimiseSummary summary;
  State state;
};

Run run(const Made& made, const Minimiser& engine) {
  MinimiseOptions options;
  options.function_tolerance = 1e-10;
  Run result;
  result.state = made.start;
  const double start = processor_seconds();
  result.summary = engine(made.problem, result.state, options);
  result.seconds = processor_seconds() - start;
  return result;
}

double rms_error(const State& found, const State& truth) {
  double sum = truth.points.empty() ? std::nan("") : 0;
  for (size_t j = 0; j < truth.points.size(); ++j) sum += (found.points[j] - truth.points[j]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(truth.points.size()));
}

double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

double median(std::vector<double> v) {
  std::sort(v.begin(), v.end());
  return v[v.size() / 2];
}

void print(const char* engine, const std::vector<Run>& runs, const Made& made) {
  std::vector<double> seconds;
  for (const auto& r : runs) seconds.push_back(r.seconds);
  const Run& last = runs.back();
  std::printf("  %-6s %8.3f s  %2d iterations  %6.3f us per observation and iteration  cost %.10g  rms error %.2f mm\n",
              engine, median(seconds), last.summary.iterations,
              1e6 * median(seconds) / last.summary.iterations / static_cast<double>(made.problem.image_points.size()),
              last.summary.final_cost, 1e3 * rms_error(last.state, made.truth));
}

/// Processor time of programs that this one has waited for.
double children_seconds() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double cost_of(const Problem& problem, const State& state) {
  const Layout layout(problem);
  Rows rows;
  double sum = 0;
  for (const auto& term : problem.image_points)
    sum += evaluate(problem, layout, state, term, false, rows) ? rows.values().squaredNorm() : std::nan("");
  return sum;
}

/// The same images, points and start without a datum, for Debian's program, which reads and writes a model of text;
/// ours does that too here. COLMAP has one weight for all and refines p1 and p2 beside k1 and k2.
void compare_with_colmap(Made made) {
  if (!colmap::is_installed()) return;
  for (const auto& camera : made.problem.cameras)
    if (camera.lens != Lens::brown) return;
  for (auto& image : made.problem.images) image.fixed = false;
  for (auto& camera : made.problem.cameras) camera.free[7] = camera.free[8] = true;
  made.problem.known.clear();
  made.problem.distances.clear();
  colmap::BundleOptions options;
  options.refine_principal_point = true;
  std::vector<double> ratios, theirs, ours;
  State by_colmap, by_schur;
  for (int repeat = 0; repeat < 3; ++repeat) {
    by_colmap = by_schur = made.start;
    double start = children_seconds();
    colmap::adjust_by_colmap(made.problem, by_colmap, options);
    theirs.push_back(children_seconds() - start);
    start = processor_seconds();
    const auto order = colmap::image_order(by_schur);
    (void)cameras::colmap_text(colmap::model_of(made.problem, by_schur, order));
    MinimiseOptions how;
    how.function_tolerance = 1e-10;
    minimise_schur(made.problem, by_schur, how);
    (void)cameras::colmap_text(colmap::model_of(made.problem, by_schur, order));
    ours.push_back(processor_seconds() - start);
    ratios.push_back(theirs.back() / ours.back());
  }
  std::printf(
      "  colmap bundle_adjuster %8.3f s, schur with two models of text %.3f s: ratio %.2f (median of 3), cost of "
      "COLMAP's answer over ours - 1: %.1e\n",
      median(theirs), median(ours), median(ratios),
      cost_of(made.problem, by_colmap) / cost_of(made.problem, by_schur) - 1);
}

/// Cofactors of every image and every point, and of 300 points jointly, from one linearisation; false if a joint block
/// is not the block computed on its own.
bool print_covariance(const Made& made, const State& state, std::vector<Eigen::MatrixXd>& own) {
  if (free_motions(made.problem) > 0) return true;  // no datum: nothing to invert
  const Layout layout(made.problem);
  const int points = static_cast<int>(made.problem.points.size());
  const double start = processor_seconds();
  Elimination elimination(made.problem, layout);
  elimination.build(state);
  if (!elimination.factorise({})) return false;
  const double built = processor_seconds();
  const Cofactors cofactors(made.problem, layout, state, elimination, {});
  own = cofactors.all_own();
  const double each = processor_seconds();
  std::vector<int> anchors;
  for (int j = 0; j < std::min(300, points); ++j)
    anchors.push_back(layout.block({Kind::point, j * points / std::min(300, points)}));
  const Eigen::MatrixXd joint = cofactors.joint(anchors);
  const auto& analysis = elimination.factor().analysis();
  std::printf(
      "  covariance: linearised and factorised in %.3f s (%s, %d unknowns, factor %.1f MB), every image 6 x 6 and "
      "every "
      "point 3 x 3 in %.3f s, %zu points jointly in %.3f s; announced %.0f MB, peak memory so far %.0f MB\n",
      built - start, analysis.is_dense() ? "dense" : "sparse", analysis.unknown_count(),
      1e-6 * static_cast<double>(analysis.bytes()), each - built, anchors.size(), processor_seconds() - each,
      1e-6 * static_cast<double>(elimination.bytes()), peak_megabytes());
  const Eigen::Matrix3d apart = joint.topLeftCorner<3, 3>() - own[anchors[0]];
  return apart.norm() < 1e-9 * own[anchors[0]].norm();
}

/// The same by Ceres, of every image and every point, or where that would take hours of 200 of each; its pattern of
/// the whole Jacobian is factorised all the same.
bool compare_covariance(const Made& made, const State& state, const std::vector<Eigen::MatrixXd>& ours) {
  const Layout layout(made.problem);
  std::vector<int> blocks;
  const auto take = [&](Kind kind, size_t count) {
    const size_t taken = made.problem.image_points.size() > 100000 ? std::min<size_t>(count, 200) : count;
    for (size_t i = 0; i < taken; ++i) {
      const int b = layout.block({kind, static_cast<int>(i * count / taken)});
      if (layout.size(b) > 0) blocks.push_back(b);
    }
  };
  take(Kind::image, made.problem.images.size());
  take(Kind::point, made.problem.points.size());
  const double start = processor_seconds();
  const auto theirs = covariances_by_ceres(made.problem, state, blocks);
  double worst = 0;
  for (size_t k = 0; k < blocks.size(); ++k) {
    const Eigen::VectorXd expected = theirs[k].diagonal().cwiseSqrt(), found = ours[blocks[k]].diagonal().cwiseSqrt();
    for (Eigen::Index i = 0; i < found.size(); ++i)
      if (const double off = std::abs(found[i] / expected[i] - 1); !(off <= worst)) worst = off;  // nan stays
  }
  std::printf(
      "  ceres::Covariance of %zu images and points %.3f s; ours differ in a standard deviation by %.1e at most\n",
      blocks.size(), processor_seconds() - start, worst);
  return worst < 1e-6;
}

/// The same problem without a factor, beside Ceres' ITERATIVE_SCHUR with SCHUR_JACOBI. False if the costs differ.
bool compare_gradients(const Made& made, double cost) {
  const auto by_gradients = [](const Minimiser& engine) {
    return [engine](const Problem& problem, State& state, MinimiseOptions options) {
      options.reduced = Reduced::gradients;
      return engine(problem, state, options);
    };
  };
  const Layout layout(made.problem);
  const double announced = static_cast<double>(Elimination(made.problem, layout).bytes()),
               without = static_cast<double>(
                   Elimination(made.problem, layout, Side::automatic, 1, Reduced::gradients).bytes());
  const Run ours = run(made, by_gradients(minimise_schur)), theirs = run(made, by_gradients(minimise_ceres));
  std::printf("  by conjugate gradients, announced %.0f MB where the factor takes %.0f MB: %s\n", 1e-6 * without,
              1e-6 * announced, ours.summary.message.c_str());
  print("schur", {ours}, made);
  print("ceres", {theirs}, made);
  std::printf("  costs over that with a factor - 1: %.1e ours, %.1e Ceres\n", ours.summary.final_cost / cost - 1,
              theirs.summary.final_cost / cost - 1);
  return std::abs(ours.summary.final_cost / cost - 1) < 1e-6;
}

constexpr size_t largest_for_ceres = 3000000;  ///< observations

bool compare(const char* name, const Made& made) {
  const int repeats = made.problem.image_points.size() > 150000 ? 1 : 3;
  std::printf("%s: %zu images, %zu points, %zu observations\n", name, made.problem.images.size(),
              made.problem.points.size(), made.problem.image_points.size());
  std::vector<Run> ours, ceres;
  std::vector<double> ratios;
  std::vector<Eigen::MatrixXd> own;
  bool sound = true;
  for (int repeat = 0; repeat < repeats; ++repeat) {  // interleaved, so that a busy machine slows both
    ours.push_back(run(made, minimise_schur));
    if (repeat == 0) sound = print_covariance(made, ours.back().state, own);  // before Ceres has taken any memory
    if (made.problem.image_points.size() > largest_for_ceres) {
      print("schur", ours, made);
      return sound;
    }
    ceres.push_back(run(made, minimise_ceres));
    ratios.push_back(ceres.back().seconds / ours.back().seconds);
  }
  print("schur", ours, made);
  print("ceres", ceres, made);
  const double difference = ours.back().summary.final_cost / ceres.back().summary.final_cost - 1;
  std::printf("  ratio %.2f (median of %d), final costs differ by %.1e, peak memory with Ceres %.0f MB\n",
              median(ratios), repeats, difference, peak_megabytes());
  if (!own.empty()) sound = compare_covariance(made, ours.back().state, own) && sound;
  sound = compare_gradients(made, ours.back().summary.final_cost) && sound;
  if (repeats > 1) compare_with_colmap(made);
  return sound && std::abs(difference) < 1e-9;
}

/// Ours and Ceres, each with a factor and without, and COLMAP, which estimates p1 and p2 always: so all do, and its
/// datum is its own.
void compare_apart(double minutes, Made made, const std::string& engine) {
  for (auto& camera : made.problem.cameras) camera.free[7] = camera.free[8] = true;
  std::printf("%zu images, %zu points, %zu observations; the problem itself takes %.0f MB; at most %g minutes each\n",
              made.problem.images.size(), made.problem.points.size(), made.problem.image_points.size(),
              peak_megabytes(), minutes);
  const auto take = [&](const char* name, const std::function<void()>& work) {
    if (std::string(name).find(engine) == std::string::npos) return;
    const Taken taken = run_apart(name, 60 * minutes, work);
    std::printf("  %s: %.0f s of the processor, peak memory %.0f MB%s\n", name, taken.seconds, taken.megabytes,
                taken.ended ? "" : ", no answer");
  };
  const auto minimise = [&](const Minimiser& minimiser, Reduced how, bool with_sigmas) {
    return [&made, minimiser, how, with_sigmas] {
      const auto by = [&](const Problem& problem, State& state, MinimiseOptions options) {
        options.reduced = how;
        return minimiser(problem, state, options);
      };
      const Run found = run(made, by);
      std::printf("  %s\n", found.summary.message.c_str());
      print("", {found}, made);
      std::vector<Eigen::MatrixXd> own;
      if (with_sigmas) print_covariance(made, found.state, own);
    };
  };
  take("schur, factor, every sigma", minimise(minimise_schur, Reduced::factor, true));
  take("Ceres SPARSE_SCHUR, without covariance", minimise(minimise_ceres, Reduced::factor, false));
  take("schur, gradients", minimise(minimise_schur, Reduced::gradients, false));
  take("Ceres ITERATIVE_SCHUR", minimise(minimise_ceres, Reduced::gradients, false));
  if (!colmap::is_installed()) return;
  take("colmap bundle_adjuster, with two models of text", [&] {
    State state = made.start;
    colmap::BundleOptions options;
    options.refine_principal_point = true;
    options.time_limit = 3600 * minutes;  // of a clock, the processor's comes first
    const auto found = colmap::adjust_by_colmap(made.problem, state, options);
    std::printf("  COLMAP: %d iterations, %.0f s of its own, cost %.10g\n", found.iterations, children_seconds(),
                cost_of(made.problem, state));
  });
}

}  // namespace

int main(int count, char** words) {
  bool sound = true;
  if (count >= 6 && std::string(words[1]) == "apart") {
    compare_apart(std::atof(words[2]), make({std::atoi(words[3]), std::atoi(words[4]), std::atoi(words[5])}),
                  count > 6 ? words[6] : "");
  } else if (count == 2) {
    sound = compare(words[1], read(words[1]));
  } else if (count == 4 || count == 5) {
    sound = compare("given", make({std::atoi(words[1]), std::atoi(words[2]), std::atoi(words[3]), count == 5}));
  } else {
    sound = compare("100 x 3000", make({100, 3000, 20})) && sound;
    sound = compare("16 x 22106 (Dubrovnik's shape)", make({16, 22106, 4})) && sound;
    sound = compare("49 x 7776 (Ladybug's shape)", make({49, 7776, 4})) && sound;
    sound = compare("200 x 10000", make({200, 10000, 20})) && sound;
  }
  if (!sound) std::fprintf(stderr, "the engines do not agree\n");
  return sound ? 0 : 1;
}

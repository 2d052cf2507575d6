// Bundle adjustment of synthetic blocks of the shape of well-known ones: our own solver and Ceres, from the
// same start, with the same derivatives and the same stopping rule, one thread, one run beside the other. Answers are
// checked: same final cost, and coordinates near the truth. Then the covariance by selected inverse.
//
//   adjust_benchmark [IMAGES POINTS RAYS [anywhere] | FOLDER]
//                                  FOLDER: an AICON block, a PhotoModeler export, a BAL problem; anywhere: points are
//                                  seen by images of the whole ring, so that the factor fills up
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "photo/block/image_block_folder.hpp"
#include "photo/block/point_block.hpp"
#include "photo/bundle/adjust.hpp"
#include "photo/bundle/ceres_covariance.hpp"
#include "photo/colmap/exchange.hpp"
#include "plumbline/rigid_transform.hpp"

namespace {

using namespace plumbline;
using namespace plumbline::bundle;
/// Time of this process alone: other programs on the machine do not count.
double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// splitmix64 and Box-Muller: the same problem everywhere.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}
  double uniform() {
    uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return (static_cast<double>((z ^ (z >> 31)) >> 11) + 0.5) * 0x1p-53;
  }
  double normal() { return std::sqrt(-2 * std::log(uniform())) * std::cos(2 * M_PI * uniform()); }
  Eigen::Vector3d vector(double size) { return size * Eigen::Vector3d(normal(), normal(), normal()); }

 private:
  uint64_t state_;
};

struct Shape {
  int images, points, rays;
  bool anywhere = false;
};

struct Made {
  Problem problem;
  State truth, start;
};

/// Images on a ring around a cube of points, one camera, each point seen by `rays` neighbouring images; 0.5 px noise;
/// two images are held, so that the datum is given and Ceres has observations of one size only.
Made make(const Shape& shape) {
  Made made;
  Problem& p = made.problem;
  Random random(1);
  p.groups = {{"images"}};
  p.cameras.push_back(
      {"camera", Lens::brown, 0, {true, true, true, true, true, true, false, false, false, false, false}});
  made.truth.interiors.push_back({3000, 3000, 2000, 1500, -0.1, 0.05, 0, 0, 0, 0});
  for (int i = 0; i < shape.images; ++i) {
    const double angle = 2 * M_PI * i / shape.images;
    const Eigen::Vector3d centre(20 * std::cos(angle), 20 * std::sin(angle), 4 * std::sin(3 * angle));
    const Eigen::Vector3d z = (random.vector(0.5) - centre).normalized();
    const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
    Eigen::Matrix3d world_from_camera;
    world_from_camera << x, z.cross(x), z;
    p.images.push_back({std::to_string(i), 0});
    made.truth.images.emplace_back();
    made.truth.images.back().set(Eigen::Quaterniond(Eigen::Matrix3d(world_from_camera.transpose())), centre);
  }
  for (int j = 0; j < shape.points; ++j) {
    p.points.push_back({std::to_string(j)});
    made.truth.points.emplace_back(8 * (random.uniform() - 0.5), 8 * (random.uniform() - 0.5),
                                   8 * (random.uniform() - 0.5));
    const int first = static_cast<int>(random.uniform() * shape.images);
    for (int r = 0; r < shape.rays; ++r) {
      ImagePoint o;
      o.image =
          (first + r * (shape.anywhere ? 1 + static_cast<int>(random.uniform() * shape.images / shape.rays) : 1)) %
          shape.images;
      o.point = j;
      const Placement& pose = made.truth.images[o.image];
      LensRows rows;
      if (!evaluate_lens(Lens::brown, made.truth.interiors[0].data(), 0, 0,
                         pose.matrix * (made.truth.points.back() - pose.position), Eigen::Vector2d::Zero(), false,
                         rows))
        continue;
      o.observed = rows.misclosure + 0.5 * Eigen::Vector2d(random.normal(), random.normal());
      o.whitening = 2 * Eigen::Matrix2d::Identity();
      p.image_points.push_back(o);
    }
  }
  made.start = made.truth;
  p.images[0].fixed = p.images[shape.images / 4].fixed = true;
  for (size_t i = 0; i < p.images.size(); ++i) {
    if (p.images[i].fixed) continue;
    Placement& pose = made.start.images[i];
    pose.set(quaternion_from_rotation_vector(random.vector(0.002)) * pose.rotation,
             pose.position + random.vector(0.05));
  }
  for (auto& point : made.start.points) point += random.vector(0.05);
  return made;
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
    (void)markers::colmap_text(colmap::model_of(made.problem, by_schur, order));
    MinimiseOptions how;
    how.function_tolerance = 1e-10;
    minimise_schur(made.problem, by_schur, how);
    (void)markers::colmap_text(colmap::model_of(made.problem, by_schur, order));
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

}  // namespace

int main(int count, char** words) {
  bool sound = true;
  if (count == 2) {
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

// How long a network takes: simulated facades of the sizes the project promises, adjusted with covariance and
// reliability, as a library call, as the whole pipeline, and by gama-local where that is on the PATH.
//   survey_network_benchmark [MARKERS SET_UPS SIGHTS_PER_MARKER [RUNS [known|reading|prism]]]
// `known`: the three markers at its corners and in the middle are held, so that there is control to check. `reading`:
// one distance is 50 mm too long; `prism`: all distances of one set-up are 34.4 mm too long.
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "survey/adjust/adjust_network.hpp"
#include "survey/files/gama.hpp"
#include "survey/model/observation_equations.hpp"

namespace {

using namespace plumbline::survey;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// splitmix64 and Box-Muller: the same network on every machine.
double normal(std::uint64_t& state) {
  const auto uniform = [&] {
    std::uint64_t z = (state += 0x9E3779B97F4A7C15ULL);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return (static_cast<double>((z ^ (z >> 31)) >> 11) + 1) * 0x1p-53;
  };
  const double u = uniform(), v = uniform();
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

/// A long facade in rows of ten markers; each set-up sees the markers nearest along it, `sights` set-ups for each
/// marker.
SurveyObservations facade(int markers, int set_ups, int sights, const std::string& mistake) {
  SurveyObservations s;
  std::uint64_t state = 42;
  const int columns = (markers + 9) / 10;
  const double length = 2.0 * columns;
  for (int m = 0; m < markers; ++m) {
    Point p;
    p.id = "M" + std::to_string(m);
    p.coordinates = {2.0 * (m / 10), 0.2 * (m % 3), 3.0 * (m % 10)};
    const bool held = mistake == "known" && (m == 0 || m == markers / 2 || m == markers - 1);
    p.roles.fill(held ? CoordinateRole::fixed : CoordinateRole::constrained);
    s.points.push_back(p);
  }
  for (int i = 0; i < set_ups; ++i) {
    Point p;
    p.id = "S" + std::to_string(i);
    p.coordinates = {length * (i + 0.5) / set_ups, -18.0 - 3.0 * (i % 3), 1.6};
    s.points.push_back(p);
    s.set_ups.push_back({p.id, p.id, kNotGiven, {}});
  }
  for (int m = 0; m < markers; ++m) {
    const Eigen::Vector3d& marker = s.points[m].coordinates;
    const int nearest = static_cast<int>(marker.x() / length * set_ups);
    const int first = std::max(0, std::min(nearest - sights / 2, set_ups - sights));
    for (int i = first; i < std::min(set_ups, first + sights); ++i) {
      const Eigen::Vector3d d = marker - s.points[markers + i].coordinates;
      const double values[] = {wrap_angle(std::atan2(d.x(), d.y()) - 0.1 * i),
                               std::atan2(std::hypot(d.x(), d.y()), d.z()), d.norm()};
      const ObservationKind kinds[] = {ObservationKind::direction, ObservationKind::zenith_angle,
                                       ObservationKind::slope_distance};
      for (int k = 0; k < 3; ++k) {
        Observation o;
        o.kind = kinds[k];
        o.set_up = i;
        o.from = s.set_ups[i].station;
        o.to = s.points[m].id;
        o.sigma = k == 2 ? 1e-3 : 1.5e-5;
        o.value = values[k] + o.sigma * normal(state);
        s.observations.push_back(o);
      }
    }
  }
  for (Observation& o : s.observations) {
    if (o.set_up != set_ups / 2 || o.kind != ObservationKind::slope_distance) continue;
    if (mistake == "reading" || mistake == "prism") o.value += mistake == "prism" ? 0.0344 : 0.05;
    if (mistake == "reading") break;
  }
  s.info.format = "gama-xml";
  s.info.largest_misclosure = 1.0;
  s.info.a_priori_sigma0 = 1;
  return s;
}

struct Times {
  double wall = 0, cpu = 0;  // [s]
};

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

/// Processor time of this process (RUSAGE_SELF) or of those it waited for (RUSAGE_CHILDREN).
double cpu_seconds(int who) {
  rusage usage{};
  getrusage(who, &usage);
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Medians of wall and processor time, each on its own.
Times median(std::vector<Times> runs) {
  const auto middle = [&](double Times::*time) {
    std::nth_element(runs.begin(), runs.begin() + static_cast<std::ptrdiff_t>(runs.size() / 2), runs.end(),
                     [&](const Times& a, const Times& b) { return a.*time < b.*time; });
    return runs[runs.size() / 2].*time;
  };
  return {middle(&Times::wall), middle(&Times::cpu)};
}

NetworkResult adjust(const SurveyObservations& survey, Times& times) {
  const double cpu = cpu_seconds(RUSAGE_SELF);
  const auto start = Clock::now();
  NetworkResult result = adjust_network(survey, {});
  times = {seconds_since(start), cpu_seconds(RUSAGE_SELF) - cpu};
  return result;
}

/// Times of a command, a process of its own; nothing is added if it fails.
void run_command(const std::string& command, std::vector<Times>& times) {
  const double cpu = cpu_seconds(RUSAGE_CHILDREN);
  const auto start = Clock::now();
  if (std::system((command + " > /dev/null 2>&1").c_str()) == 0)
    times.push_back({seconds_since(start), cpu_seconds(RUSAGE_CHILDREN) - cpu});
}

/// The same network as a file, for processes: the pipeline with its pages and tables, and gama-local.
class Processes {
 public:
  explicit Processes(const SurveyObservations& survey)
      : folder_(std::filesystem::temp_directory_path() / ("plumbline-benchmark-" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "network.gkf") << write_gama_xml(survey);
  }
  Processes(const Processes&) = delete;
  Processes& operator=(const Processes&) = delete;
  ~Processes() { std::filesystem::remove_all(folder_); }

  /// With an empty store: nothing is reused.
  void pipeline(std::vector<Times>& times) const {
    static const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "plumbline";
    std::filesystem::remove_all(folder_ / "store");
    run_command("'" + program.string() + "' run survey_network file=" + path("network.gkf") + " --store " +
                    path("store") + " --out " + path("out"),
                times);
  }
  void gama(const std::string& algorithm, std::vector<Times>& times) const {
    run_command("gama-local " + path("network.gkf") + " --algorithm " + algorithm + " --xml " + path("network.xml"),
                times);
  }

 private:
  std::string path(const char* name) const { return "'" + (folder_ / name).string() + "'"; }
  std::filesystem::path folder_;
};

void print_other(const std::string& name, const std::vector<Times>& runs, const Times& library,
                 const std::vector<Times>& pipeline) {
  if (runs.empty()) {
    std::printf("      %s: is not there, or fails\n", name.c_str());
    return;
  }
  const Times other = median(runs);
  std::printf("      %s: wall %.3f s, cpu %.3f s; over the adjustment: wall %.0f, cpu %.0f", name.c_str(), other.wall,
              other.cpu, other.wall / library.wall, other.cpu / library.cpu);
  if (!pipeline.empty()) std::printf("; over the pipeline: wall %.0f", other.wall / median(pipeline).wall);
  std::printf("\n");
}

/// All in turn, so that each meets the same load of the machine.
void run(int markers, int set_ups, int sights, int runs, const std::vector<std::string>& algorithms,
         const std::string& mistake = "") {
  const SurveyObservations survey = facade(markers, set_ups, sights, mistake);
  const Processes processes(survey);
  std::vector<Times> ours(1), pipeline;
  std::vector<std::vector<Times>> gama(algorithms.size());
  const NetworkResult r = adjust(survey, ours.front());
  for (int i = 0; i < runs; ++i) {
    if (i > 0) adjust(survey, ours.emplace_back());
    processes.pipeline(pipeline);
    for (std::size_t a = 0; a < algorithms.size(); ++a) processes.gama(algorithms[a], gama[a]);
  }
  const Times own = median(ours);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf(
      "%5d markers %3d set-ups %6d observations %5d unknowns: wall %.3f s, cpu %.3f s (medians of %d), %d iterations, "
      "sigma0 %.4f, sum of redundancy - f = %.1e, peak memory %ld MiB\n",
      markers, set_ups, r.observations, r.unknowns, own.wall, own.cpu, runs, r.iterations, r.sigma0,
      r.sum_of_redundancy_numbers - r.degrees_of_freedom, usage.ru_maxrss / 1024);
  std::printf("      %s\n", r.verdict.c_str());
  if (!pipeline.empty())
    std::printf("      plumbline run survey_network: wall %.3f s, cpu %.3f s\n", median(pipeline).wall,
                median(pipeline).cpu);
  for (std::size_t a = 0; a < algorithms.size(); ++a)
    print_other("gama-local --algorithm " + algorithms[a], gama[a], own, pipeline);
}

}  // namespace

// gama-local's default is envelope; gso is the fastest of its four on these networks.
int main(int argc, char** argv) {
  if (argc >= 4 && argc <= 6) {
    const int markers = std::atoi(argv[1]);
    std::vector<std::string> algorithms = {"gso"};
    if (markers <= 200) algorithms.emplace_back("envelope");  // at 300 it takes minutes
    run(markers, std::atoi(argv[2]), std::atoi(argv[3]), argc >= 5 ? std::max(1, std::atoi(argv[4])) : 5, algorithms,
        argc == 6 ? argv[5] : "");
    return 0;
  }
  run(100, 6, 6, 5, {"envelope", "gso"});  // 1 800 observations
  run(300, 20, 7, 5, {"gso"});             // 6 300 observations; envelope takes minutes
  run(1000, 60, 7, 5, {});                 // 21 000 observations; gama-local takes longer than anyone waits
  run(3000, 150, 7, 3, {});                // cofactors on demand from here on
  run(10000, 400, 6, 3, {});               // 400 set-ups of 150 sights
  return 0;
}

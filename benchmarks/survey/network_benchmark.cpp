// How long a network takes: simulated facades of the sizes the project promises, adjusted with full covariance and
// reliability, as a library call and, where gama-local is on the PATH, against it as a process on the same network.
//   survey_network_benchmark [markers set_ups sights_per_marker]
#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

#include "adjust_network.hpp"
#include "formats/gama.hpp"
#include "observation_equations.hpp"

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
SurveyObservations facade(int markers, int set_ups, int sights) {
  SurveyObservations s;
  std::uint64_t state = 42;
  const int columns = (markers + 9) / 10;
  const double length = 2.0 * columns;
  for (int m = 0; m < markers; ++m) {
    Point p;
    p.id = "M" + std::to_string(m);
    p.coordinates = {2.0 * (m / 10), 0.2 * (m % 3), 3.0 * (m % 10)};
    p.roles.fill(CoordinateRole::constrained);
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
    const Eigen::Vector3d& marker = s.points[static_cast<size_t>(m)].coordinates;
    const int nearest = static_cast<int>(marker.x() / length * set_ups);
    const int first = std::max(0, std::min(nearest - sights / 2, set_ups - sights));
    for (int i = first; i < std::min(set_ups, first + sights); ++i) {
      const Eigen::Vector3d d = marker - s.points[static_cast<size_t>(markers + i)].coordinates;
      const double values[] = {wrap_angle(std::atan2(d.x(), d.y()) - 0.1 * i),
                               std::atan2(std::hypot(d.x(), d.y()), d.z()), d.norm()};
      const ObservationKind kinds[] = {ObservationKind::direction, ObservationKind::zenith_angle,
                                       ObservationKind::slope_distance};
      for (int k = 0; k < 3; ++k) {
        Observation o;
        o.kind = kinds[k];
        o.set_up = i;
        o.from = s.set_ups[static_cast<size_t>(i)].station;
        o.to = s.points[static_cast<size_t>(m)].id;
        o.sigma = k == 2 ? 1e-3 : 1.5e-5;
        o.value = values[k] + o.sigma * normal(state);
        s.observations.push_back(o);
      }
    }
  }
  s.info.format = "gama-xml";
  s.info.a_priori_sigma0 = 1;
  return s;
}

/// Seconds of `gama-local` on the same network; negative if it is not there or fails.
double gama_seconds(const SurveyObservations& survey) {
  if (std::system("command -v gama-local > /dev/null 2>&1") != 0) return -1;
  const auto folder = std::filesystem::temp_directory_path() / "plumbline-survey-benchmark";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "network.gkf") << write_gama_xml(survey);
  const std::string command = "gama-local '" + (folder / "network.gkf").string() + "' --xml '" +
                              (folder / "network.xml").string() + "' > /dev/null 2>&1";
  const auto start = Clock::now();
  const int status = std::system(command.c_str());
  const double elapsed = seconds_since(start);
  std::filesystem::remove_all(folder);
  return status == 0 ? elapsed : -1;
}

void run(int markers, int set_ups, int sights) {
  const SurveyObservations survey = facade(markers, set_ups, sights);
  const auto start = Clock::now();
  const NetworkResult r = adjust_network(survey, {});
  const double ours = seconds_since(start);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf(
      "%5d markers %3d set-ups %6d observations %5d unknowns: %7.3f s, %d iterations, sigma0 %.4f, "
      "sum of redundancy - f = %.1e, peak memory %ld MiB\n",
      markers, set_ups, r.observations, r.unknowns, ours, seconds(usage.ru_utime) + seconds(usage.ru_stime),
      r.iterations, r.sigma0, r.sum_of_redundancy_numbers - r.degrees_of_freedom, usage.ru_maxrss / 1024);
  const double gama = gama_seconds(survey);
  if (gama > 0)
    std::printf("      gama-local: %.3f s, ratio %.0f\n", gama, gama / ours);
  else
    std::printf("      gama-local is not on the PATH: no comparison\n");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 4) {
    run(std::atoi(argv[1]), std::atoi(argv[2]), std::atoi(argv[3]));
    return 0;
  }
  run(100, 6, 6);    // 1 800 observations
  run(300, 20, 7);   // 6 300 observations
  run(1000, 60, 7);  // 21 000 observations
  return 0;
}

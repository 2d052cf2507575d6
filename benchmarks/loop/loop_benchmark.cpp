// Open, measured once, closed, and closed with nobody who looks at what the state asks a person for: the same simulated
// towers side by side. Prints a table, the reliability of p_in, joints, faults.
//
//   loop_benchmark [TRIALS [FLOORS [FAULTS [SEED [FACADES [FACTOR [TOLERANCE [CLOSED [SEEN]]]]]]]]]
//
// FAULTS is their share, FACTOR that on the survey's errors. TOLERANCE [mm] is that of corners; joints have 1.6 times
// as much. With one of 2 or 3 mm there are panels of every stated probability: the reliability diagram. With CLOSED = 0
// both closed loops are left out, with 2 the one without a person. SEEN [mm] is how well who hangs a panel measures its
// place. SEED is the first. The unit of all intervals and tests is the tower.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <string>
#include <vector>

#include "base/statistics/by_seed.hpp"
#include "loop/simulate/trial.hpp"

using namespace plumbline;
using namespace plumbline::loop;

namespace {

/// Wilson's interval of a share, 95 %; trials are the units where items of one trial hang together, so this is for
/// single items.
void wilson(double k, double n, double& low, double& high) {
  const double z = 1.96, p = k / n, d = 1 + z * z / n;
  const double middle = (p + z * z / (2 * n)) / d, half = z * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n)) / d;
  low = middle - half, high = middle + half;
}

/// Mean over towers, half of its 95 % interval (jackknife, Student's t) and, of a difference, the exchange test of
/// zero.
struct Mean {
  std::vector<double> values;
  void add(double x) { values.push_back(x); }
  double value() const { return mean_of(values)(statistics::Weights(values.size(), 1.0)); }
  double half() const {
    if (values.size() < 2) return std::nan("");
    const auto found = statistics::estimate(values.size(), mean_of(values), 0.95, statistics::Scale::plain);
    return found.interval.upper - found.value;
  }
  double p() const { return statistics::exchange_test(values.size(), sum_of(values), {}); }

 private:
  static statistics::Statistic mean_of(const std::vector<double>& values) {
    return [&values](const statistics::Weights& weights) {
      double sum = 0, weight = 0;
      for (std::size_t i = 0; i < values.size(); ++i) sum += weights[i] * values[i], weight += weights[i];
      return weight > 0 ? sum / weight : std::nan("");
    };
  }
  static statistics::Statistic sum_of(const std::vector<double>& values) {
    return [&values](const statistics::Weights& signs) {
      double sum = 0;
      for (std::size_t i = 0; i < values.size(); ++i) sum += signs[i] * values[i];
      return sum;
    };
  }
};

struct Sum {
  Mean panels, joints, reworks, top, rounds, top_floor, bottom_floor, slope;
  double by_person = 0, verified = 0, wrong = 0, worst = 0, infeasible = 0, planted = 0, missed = 0, items = 0,
         looks = 0;
  double nees = 0, diagonal = 0, joint_values = 0, seconds = 0;
  std::map<std::string, int> kinds;
  double stated[12] = {}, inside[12] = {}, count[12] = {};
};

/// Of each tower by itself, for intervals that know that its panels share a survey: seed, bin, panels, sum of what is
/// stated, panels inside (benchmarks/loop/reliability.py).
void print_reliability(const TrialResult& r, std::uint64_t seed) {
  double stated[11] = {};
  int inside[11] = {}, count[11] = {};
  for (const Stated& one : r.stated) {
    if (!(one.p_in >= 0)) continue;
    const int bin = one.p_in >= 0.95 ? 10 : static_cast<int>(10 * one.p_in);
    stated[bin] += one.p_in, inside[bin] += one.inside, ++count[bin];
  }
  for (int bin = 0; bin <= 10; ++bin)
    if (count[bin] > 0)
      std::printf("tower %llu %d %d %.6f %d\n", static_cast<unsigned long long>(seed), bin, count[bin], stated[bin],
                  inside[bin]);
}

/// Slope of the pass rate over the height of one tower, by least squares over its floors [percent per ten floors].
double slope_of(const TrialResult& r) {
  const double n = static_cast<double>(r.inside_by_floor.size()), middle = (n + 1) / 2;
  const double per_floor = static_cast<double>(r.panels) / n;
  double sum = 0, square = 0;
  for (std::size_t f = 0; f < r.inside_by_floor.size(); ++f) {
    const double floor = static_cast<double>(f + 1) - middle;
    sum += floor * 100.0 * r.inside_by_floor[f] / per_floor, square += floor * floor;
  }
  return square > 0 ? 10 * sum / square : 0;
}

void add(const TrialResult& r, Sum& s) {
  s.panels.add(100.0 * r.panels_inside / r.panels),
      s.joints.add(r.joints > 0 ? 100.0 * r.joints_inside / r.joints : 100.0);
  s.reworks.add(100.0 * r.reworks / (r.panels + 1e-9)), s.top.add(std::isnan(r.top_height) ? 0 : 1e3 * r.top_height),
      s.rounds.add(r.rounds);
  const double per_floor = static_cast<double>(r.panels) / static_cast<double>(r.inside_by_floor.size());
  s.bottom_floor.add(100.0 * r.inside_by_floor.front() / per_floor);
  s.top_floor.add(100.0 * r.inside_by_floor.back() / per_floor);
  s.slope.add(slope_of(r));
  s.by_person += r.by_person, s.verified += r.verified, s.wrong += r.verified_wrong, s.infeasible += r.infeasible,
      s.items += r.panels;
  s.worst = std::max(s.worst, r.verified_worst);
  for (const std::string& line : r.missed) std::fprintf(stderr, "missed  %s\n", line.c_str());
  for (const std::string& line : r.wrong) std::fprintf(stderr, "outside  %s\n", line.c_str());
  for (const std::string& line : r.left) std::fprintf(stderr, "left  %s\n", line.c_str());
  for (const auto& [kind, count] : r.planted_by_kind) s.kinds[kind] += count;
  s.planted += r.planted, s.missed += r.planted_verified, s.looks += r.looks;
  s.nees += r.joint_nees, s.diagonal += r.joint_nees_diagonal, s.joint_values += r.joint_values;
  for (const Stated& stated : r.stated) {
    if (!(stated.p_in >= 0)) continue;
    const int bin = stated.p_in >= 0.95 ? 10 : static_cast<int>(10 * stated.p_in);
    s.stated[bin] += stated.p_in, s.inside[bin] += stated.inside, ++s.count[bin];
  }
}

constexpr Strategy kStrategies[] = {Strategy::open, Strategy::measured_once, Strategy::unattended, Strategy::closed};
constexpr std::size_t kCount = std::size(kStrategies);

bool is_closed(Strategy strategy) { return strategy == Strategy::unattended || strategy == Strategy::closed; }

/// `paired`: of each strategy, closed minus it.
void print_closed(const Sum (&sums)[kCount], const Mean (&paired)[kCount]) {
  for (std::size_t i = 0; i + 1 < kCount; ++i) {
    if (paired[i].values.empty()) continue;
    std::printf("closed minus %-14s %5.1f +- %4.1f percent of the panels, exchange test p %.3f (paired by tower)\n",
                name_of(kStrategies[i]), paired[i].value(), paired[i].half(), paired[i].p());
  }
  for (std::size_t i = 2; i < kCount; ++i) {
    const Sum& c = sums[i];
    if (c.panels.values.empty()) continue;
    std::printf(
        "%s: %.0f of %.0f panels VERIFIED (%.2f %%; %.0f of them where a person had looked), %.0f not feasible; of the "
        "verified %.0f (%.2f %%) outside in truth, the worst by %.2f mm\n",
        name_of(kStrategies[i]), c.verified, c.items, 100 * c.verified / c.items, c.by_person, c.infeasible, c.wrong,
        100 * c.wrong / std::max(1.0, c.verified), 1e3 * c.worst);
    std::printf("%s: %.0f faults planted, %.0f brackets VERIFIED that are 4.5 mm or more off\n",
                name_of(kStrategies[i]), c.planted, c.missed);
  }
  const Sum& c = sums[kCount - 1];
  for (const auto& [kind, count] : c.kinds) std::printf("  %s: %d\n", kind.c_str(), count);
  std::printf("closed: a person was asked to look %.0f times, %.2f for each 100 panels\n", c.looks,
              100 * c.looks / c.items);
}

}  // namespace

int main(int argc, char** argv) {
  const int trials = argc > 1 ? std::atoi(argv[1]) : 200, floors = argc > 2 ? std::atoi(argv[2]) : 5;
  SiteOptions options;
  options.tower.floors = floors, options.tower.bays = 4;
  options.faults = Faults::all(argc > 3 ? std::atof(argv[3]) : 0);
  const auto first = static_cast<std::uint64_t>(argc > 4 ? std::atoi(argv[4]) : 1);
  options.tower.facades = argc > 5 ? std::atoi(argv[5]) : 1;
  const double worse = argc > 6 ? std::atof(argv[6]) : 1;
  const double tolerance = argc > 7 ? 1e-3 * std::atof(argv[7]) : options.tower.tolerance;
  options.tower.tolerance = tolerance, options.tower.joint_tolerance = 1.6 * tolerance;
  const int closed = argc > 8 ? std::atoi(argv[8]) : 1;
  if (argc > 9) options.seen = 1e-3 * std::atof(argv[9]);
  const auto is_left_out = [&](Strategy strategy) {
    return is_closed(strategy) && (closed == 0 || (closed == 2 && strategy == Strategy::unattended));
  };
  options.survey.single *= worse, options.survey.set_up *= worse, options.survey.control_walk *= worse;
  Sum sums[kCount];
  Mean paired[kCount];
  for (int t = 0; t < trials; ++t) {
    double share[kCount] = {};
    for (std::size_t i = 0; i < kCount; ++i) {
      if (is_left_out(kStrategies[i])) continue;
      const std::clock_t start = std::clock();
      const TrialResult r = run_trial(options, kStrategies[i], first + static_cast<std::uint64_t>(t));
      sums[i].seconds += static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
      add(r, sums[i]);
      if (kStrategies[i] == Strategy::measured_once) print_reliability(r, first + static_cast<std::uint64_t>(t));
      share[i] = 100.0 * r.panels_inside / r.panels;
    }
    for (std::size_t i = 0; i < kCount; ++i)
      if (!is_left_out(kStrategies[i])) paired[i].add(share[kCount - 1] - share[i]);
  }
  std::printf("%d trials, %d floors of 4 panels on %d facades\n", trials, floors, options.tower.facades);
  std::printf("%-14s %18s %18s %14s %14s %10s %16s %8s %8s\n", "", "panels inside [%]", "joints inside [%]",
              "lowest floor", "top floor", "reworks", "top height [mm]", "rounds", "s/trial");
  for (std::size_t i = 0; i < kCount; ++i) {
    const Sum& s = sums[i];
    if (s.panels.values.empty()) continue;
    std::printf("%-14s %10.1f +- %4.1f %10.1f +- %4.1f %14.1f %14.1f %10.1f %8.2f +- %4.2f %8.1f %8.2f\n",
                name_of(kStrategies[i]), s.panels.value(), s.panels.half(), s.joints.value(), s.joints.half(),
                s.bottom_floor.value(), s.top_floor.value(), s.reworks.value(), s.top.value(), s.top.half(),
                s.rounds.value(), s.seconds / trials);
  }
  for (std::size_t i = 0; i < kCount; ++i)
    if (!sums[i].panels.values.empty())
      std::printf("over the height %-14s %6.2f +- %5.2f percent of the panels per ten floors\n",
                  name_of(kStrategies[i]), sums[i].slope.value(), sums[i].slope.half());
  if (closed != 0) print_closed(sums, paired);
  const Sum& m = sums[1];
  std::printf(
      "joints, measured once: mean of (true - stated)^2/u^2 %.3f with the joint covariance, %.3f with its diagonal "
      "(%.0f values)\n",
      m.nees / m.joint_values, m.diagonal / m.joint_values, m.joint_values);
  std::printf("p_in: stated, found inside, panels\n");
  for (int bin = 0; bin <= 10; ++bin)
    if (m.count[bin] > 0) {
      double low, high;
      wilson(m.inside[bin], m.count[bin], low, high);
      std::printf("  %.3f %.3f [%.3f, %.3f] %.0f\n", m.stated[bin] / m.count[bin], m.inside[bin] / m.count[bin], low,
                  high, m.count[bin]);
    }
}

// Which of several sets of approximate coordinates is meant: the one whose adjustment fits the observations.
#include <algorithm>
#include <cmath>
#include <optional>

#include "survey/network/network_model_steps.hpp"
#include "survey/start/approximate_figure.hpp"

namespace plumbline::survey {

namespace {

using Places = std::vector<Eigen::Vector3d>;

struct Trial {
  size_t model = 0;
  double sum_of_squares = 0;
  int degrees_of_freedom = 0, defect = 0;
  Places places;
};

/// Adjusts all observations of a model; nullopt if that does not converge or has defects that its datum may not mend.
std::optional<Trial> try_model(const NetworkModel& m, size_t number, const AdjustOptions& options) {
  StochasticState state;
  state.removed.assign(m.rows.size(), 0);
  NetworkProblem problem = make_problem(m, options, state);
  least_squares::SolverOptions solver;
  solver.datum_unknowns = datum_unknowns(m, problem);
  try {
    const least_squares::Solution solution = least_squares::solve(problem.problem, solver);
    if (!solution.converged || !name_local_defects(m, problem, solution.datum.null_space()).empty())
      return std::nullopt;
    Trial trial{number, solution.sum_of_squares(), solution.degrees_of_freedom(), solution.datum.defect(), {}};
    for (int block : problem.point_blocks)
      trial.places.push_back(Eigen::Map<const Eigen::Vector3d>(problem.problem.parameters[block].value.data()));
    return trial;
  } catch (const std::exception&) {
    return std::nullopt;  // a rank defect: it is told about when no other model is left
  }
}

double extent(const Places& places) {
  double largest = 0;
  for (const auto& p : places) largest = std::max(largest, (p - places.front()).norm());
  return largest;
}

/// The second solution turned and shifted onto the first, as a free network's datum leaves it open.
Places aligned(const Trial& a, const Trial& b) {
  if (a.defect == 0) return b.places;
  std::vector<Eigen::Vector2d> from, to;
  double lift = 0;
  for (size_t i = 0; i < a.places.size(); ++i) {
    from.push_back(b.places[i].head<2>());
    to.push_back(a.places[i].head<2>());
    lift += (a.places[i].z() - b.places[i].z()) / static_cast<double>(a.places.size());
  }
  const auto motion = fit_plane(from, to);
  Places places = b.places;
  for (Eigen::Vector3d& p : places) {
    if (motion) p.head<2>() = (*motion)(p.head<2>());
    p.z() += lift;
  }
  return places;
}

/// Number of the point two solutions disagree about most; -1 if they are the same.
int farthest_apart(const Trial& a, const Trial& b) {
  // A free network follows its approximate coordinates, so two of the same shape need not agree to the last digit.
  double most = a.defect > 0 ? 0.01 * extent(a.places) : 1e-3;
  const Places other = aligned(a, b);
  int point = -1;
  for (size_t i = 0; i < a.places.size(); ++i)
    if (const double d = (a.places[i] - other[i]).norm(); d > most) {
      most = d;
      point = static_cast<int>(i);
    }
  return point;
}

std::string coordinates(const NetworkModel& m, int point, const Eigen::Vector3d& p) {
  std::string text;
  for (int k = 0; k < 3; ++k)
    if (m.roles[point][k] != CoordinateRole::unused)
      text += std::string(text.empty() ? "" : ", ") + "ENH"[k] + " " + fixed_digits(p[k], 2);
  return text;
}

[[noreturn]] void refuse(const NetworkModel& m, const Trial& best, const std::vector<Trial>& rivals) {
  std::vector<int> asked;
  std::vector<std::string> ids;
  for (const Trial& rival : rivals) {
    const auto tells = [&](int i) { return (best.places[i] - rival.places[i]).norm() > 1e-3; };
    if (std::any_of(asked.begin(), asked.end(), tells)) continue;
    asked.push_back(farthest_apart(best, rival));
    ids.push_back(m.ids[asked.back()]);
  }
  const Trial& rival = rivals.front();
  std::string text = "the observations fit " + std::to_string(rivals.size() + 1) +
                     " different networks equally well (v'Pv " + fixed_digits(best.sum_of_squares, 2) + " and " +
                     fixed_digits(rival.sum_of_squares, 2) + "), such as one and its mirror image: point " + ids[0] +
                     " is at " + coordinates(m, asked[0], best.places[asked[0]]) + " or at " +
                     coordinates(m, asked[0], rival.places[asked[0]]);
  if (m.starts_from_known_points) {
    text += std::string("; give ") + (ids.size() == 1 ? "one of these as " : "") + "approximate coordinates of " +
            join(ids) + ", or an observation that decides (a direction, an angle)";
  } else {
    const bool plane = m.roles[asked[0]][2] == CoordinateRole::unused;
    text += std::string("; give approximate coordinates of ") + (plane ? "three" : "four") + " points, " + ids[0] +
            " among them, that do not lie " + (plane ? "on a line" : "in a plane") +
            ", or observations that decide (directions, angles)";
  }
  throw NetworkError(text, {{Finding::Severity::error, "two positions fit: " + join(ids), ids}});
}

}  // namespace

NetworkModel choose_alternative(std::vector<NetworkModel> models, const AdjustOptions& options) {
  // Twice the logarithm of the odds that a rival must lose by: exp(8), 1 in 3000.
  constexpr double kClear = 16;
  if (models.size() == 1) return std::move(models.front());
  std::vector<Trial> trials;
  for (size_t i = 0; i < models.size(); ++i)
    if (auto trial = try_model(models[i], i, options)) trials.push_back(std::move(*trial));
  if (trials.empty()) return std::move(models.front());
  std::stable_sort(trials.begin(), trials.end(),
                   [](const Trial& a, const Trial& b) { return a.sum_of_squares < b.sum_of_squares; });
  const Trial& best = trials.front();
  const double variance = best.sum_of_squares / std::max(1, best.degrees_of_freedom);
  std::vector<Trial> rivals;
  for (size_t i = 1; i < trials.size(); ++i)
    if (trials[i].sum_of_squares < best.sum_of_squares + kClear * std::max(1.0, variance) &&
        farthest_apart(best, trials[i]) >= 0)
      rivals.push_back(trials[i]);
  if (!rivals.empty()) refuse(models[best.model], best, rivals);
  return std::move(models[best.model]);
}

}  // namespace plumbline::survey

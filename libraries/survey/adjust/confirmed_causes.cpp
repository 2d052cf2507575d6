#include "survey/adjust/confirmed_causes.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <string>

#include "plumbline/stop.hpp"
#include "survey/doctor/find_causes.hpp"
#include "survey/model/observation_equations.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

std::vector<Finding> confirmed_causes(const SurveyObservations& survey, const AdjustOptions& options,
                                      const ControlPoints& control, double now, size_t fewer_left_out_than) {
  constexpr double kFits = 3, kBetter = 5;  // of sigma0
  std::vector<Finding> findings;
  for (const Cause& cause : find_causes(survey, options, control)) {
    try {
      const NetworkResult r = adjust_as_it_is(cause.mended, options, cause.control, nullptr);
      const bool several = r.sigma0 > kFits && r.sigma0 * kBetter < now;  // it is one of several mistakes
      if ((r.validity == Validity::invalid && !several) || r.left_out.size() >= fewer_left_out_than) continue;
      findings.push_back({Finding::Severity::warning,
                          "probably: " + cause.text + ". Adjusted with that undone, sigma0 is " +
                              fixed_digits(r.sigma0, 2) +
                              (std::isnan(now) ? "; as it is the network cannot be adjusted"
                                               : " in place of " + fixed_digits(now, 2)) +
                              ". Mend it in the file: nothing was changed here",
                          cause.points});
    } catch (const std::runtime_error&) {
      continue;  // it is not that, or not that alone
    }
  }
  return findings;
}

namespace {

/// Set-ups of which nothing is left where their stations were left out.
std::vector<std::string> lost_set_ups(const SurveyObservations& survey, const NetworkResult& result) {
  std::set<std::string> out(result.left_out.begin(), result.left_out.end());
  std::vector<std::string> lost;
  for (const SetUp& s : survey.set_ups)
    if (out.contains(s.station)) lost.push_back(s.id);
  return lost;
}

}  // namespace

void explain_left_out(const SurveyObservations& survey, const AdjustOptions& options, const ControlPoints& control,
                      NetworkResult& result) {
  if (result.left_out.empty()) return;
  const std::vector<Finding> causes = confirmed_causes(survey, options, control, result.sigma0, result.left_out.size());
  const std::string points =
      std::to_string(result.left_out.size()) + (result.left_out.size() == 1 ? " point" : " points");
  if (!causes.empty()) {
    result.findings.insert(result.findings.begin(), causes.begin(), causes.end());
    result.validity = Validity::doubtful;
    result.verdict = "doubtful: " + points + " left out because of one mistake (" +
                     causes.front().text.substr(0, causes.front().text.find(". Adjusted with")) +
                     "); of the rest: " + result.verdict;
    return;
  }
  const std::vector<std::string> lost = lost_set_ups(survey, result);
  if (lost.empty()) {
    result.verdict += "; " + points + " left out as not determined";
    return;
  }
  result.validity = Validity::doubtful;
  result.verdict = "doubtful: " + std::string(lost.size() == 1 ? "set-up " : "set-ups ") + join(lost, 6) +
                   (lost.size() == 1 ? " hangs" : " hang") + " in the air, and no reading of " +
                   (lost.size() == 1 ? "it" : "them") + " took part or was tested; of the rest: " + result.verdict;
}

namespace {

/// Another frame of the known points, or another geoid, that would draw distances longer by `scale`.
struct FrameCause {
  std::string text;
  AdjustOptions options;
};

/// Of all distances: the mean of what the network finds of each set-up's.
CommonEstimate scale_of_distances(const NetworkResult& r) {
  double sum = 0, weights = 0;
  for (const ResultSetUp& s : r.set_ups) {
    if (!(s.scale.sigma > 0)) continue;
    const double weight = 1 / (s.scale.sigma * s.scale.sigma);
    sum += weight * s.scale.value, weights += weight;
  }
  return weights > 0 ? CommonEstimate{sum / weights, 1 / std::sqrt(weights)} : CommonEstimate{};
}

/// What adjusts with other options; refuses by std::runtime_error.
using Trial = std::function<NetworkResult(const AdjustOptions&)>;

/// The geoid's height that leaves the distances no scale. The scale that is found of one set-up has the others' in it
/// as far as the control gives way, and their mean is too small by a share: one trial tells which.
void explain_by_geoid(const AdjustOptions& options, double scale, const Trial& adjust,
                      std::vector<FrameCause>& causes) {
  constexpr double kLeast = 10, kMost = 110;  // [m] above or below the ellipsoid, anywhere
  const double first = scale * kEarthRadius;
  if (options.geoid.height != 0 || !options.geoid.grid.empty() || std::abs(first) > kMost) return;
  AdjustOptions other = options;
  other.geoid.height = first;
  const double left = scale_of_distances(adjust(other)).value;
  other.geoid.height = std::round(first * scale / (scale - left));
  if (!(std::abs(other.geoid.height) > kLeast && std::abs(other.geoid.height) < kMost)) return;
  const std::string value = fixed_digits(other.geoid.height, 0);
  // Its trial has one free number for one number: it proves nothing.
  causes.push_back({"the geoid lies about " + value + " m above the ellipsoid of the map (geoid_height=" + value +
                        "; a map of geoids tells), or the distances are off by as much (ppm setting, weather, a prism "
                        "constant where they are about equally long), which these readings do not tell apart",
                    other});
}

std::vector<FrameCause> frame_causes(const AdjustOptions& options, double scale, const NetworkResult& result,
                                     const Trial& adjust) {
  constexpr double kNearest = 1e5, kFarthest = 9e5, kNorth = 1e5;  // of eastings of UTM, and of a northing [m]
  std::vector<FrameCause> causes;
  try {
    explain_by_geoid(options, scale, adjust, causes);
  } catch (const std::runtime_error&) {
    // It is not that.
  }
  AdjustOptions plane = options;
  plane.map = kPlane;
  causes.push_back(
      {"the known points lie in a plane of their own and not on the map that was given (map=plane), or "
       "the distances had been reduced to the map before",
       plane});
  const auto first = std::find_if(result.points.begin(), result.points.end(),
                                  [](const ResultPoint& p) { return p.position.head<2>().allFinite(); });
  if (first == result.points.end()) return causes;
  const double in_zone = std::fmod(first->position.x(), 1e6);
  if (in_zone < kNearest || in_zone > kFarthest || first->position.y() < kNorth) return causes;
  AdjustOptions utm = options;
  utm.map = "utm:32";  // of any zone the scale follows from the easting alone
  causes.push_back({"the known points lie in UTM and not on the map that was given (map=utm:ZONE)", utm});
  return causes;
}

}  // namespace

void explain_scale(const SurveyObservations& survey, const AdjustOptions& options, const ControlPoints& control,
                   NetworkResult& result) {
  constexpr double kClearly = 5, kGone = 3;  // standard deviations
  const CommonEstimate scale = scale_of_distances(result);
  if (options.map.empty() || options.map == kPlane || !(scale.sigma > 0) ||
      !(std::abs(scale.value) > kClearly * scale.sigma))
    return;
  const Trial adjust = [&](const AdjustOptions& other) {
    stop_point();
    return adjust_as_it_is(survey, other, control, nullptr);
  };
  std::vector<Finding> found;
  for (const FrameCause& cause : frame_causes(options, scale.value, result, adjust)) {
    try {
      const NetworkResult r = adjust(cause.options);
      const CommonEstimate left = scale_of_distances(r);
      if (!(r.sigma0 < result.sigma0) || std::abs(left.value) > kGone * left.sigma) continue;
      found.push_back({Finding::Severity::warning,
                       "probably: " + cause.text + ". Adjusted so, sigma0 is " + fixed_digits(r.sigma0, 2) +
                           " in place of " + fixed_digits(result.sigma0, 2) + ", and the distances have no scale of " +
                           fixed_digits(1e6 * scale.value, 0) + " ppm any more. Nothing was changed here",
                       {}});
    } catch (const std::runtime_error&) {
      continue;  // it is not that
    }
  }
  result.findings.insert(result.findings.begin(), found.begin(), found.end());
}

}  // namespace plumbline::survey

// What is said of cameras that change and of photographs that scatter.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "geometry/statistics.hpp"
#include "markers/camera_changes.hpp"

namespace plumbline::markers {
namespace {

using Split = CameraChange::Split;
using What = CameraChange::What;

std::string list_of(const std::vector<int>& members, const std::vector<std::string>& paths) {
  constexpr std::size_t most = 4;
  std::string list;
  for (std::size_t k = 0; k < std::min(most, members.size()); ++k)
    list += (k ? ", " : "") + paths[static_cast<std::size_t>(members[k])];
  return list + (members.size() > most ? ", ..." : "");
}

std::string where(const CameraChange& change, const CameraEvidence& evidence) {
  const std::string count = std::to_string(change.second.size());
  const std::string list = " (" + list_of(change.second, evidence.paths) + ")";
  switch (change.split) {
    case Split::from_on:
      return "from " + evidence.paths[static_cast<std::size_t>(change.second.front())] + " on";
    case Split::drift:
      return "from " + evidence.paths.front() + " to " + evidence.paths.back() + ", bit by bit,";
    case Split::every:
      return std::string("in every ") +
             (change.period == 2   ? "second"
              : change.period == 3 ? "third"
                                   : "fourth") +
             " photograph" + list;
    case Split::some:
      return "in " + count + " photographs" + list;
    case Split::upside_down:
      return "in the " + count + " photographs that are held upside down against the others" + list;
  }
  return "";
}

/// "2.01 ± 0.05 %".
std::string amount(double value, double sigma, int decimals, const char* unit) {
  char text[80];
  std::snprintf(text, sizeof text, "%.*f \u00b1 %.*f%s", decimals, value, decimals, sigma, unit);
  return text;
}

}  // namespace

std::string in_words(const CameraChange& change, const CameraEvidence& evidence) {
  const bool measured = change.by_sigma.x() > 0;  // one adjustment does not say by how much, nor in which direction
  const std::string relative = !measured ? "another"
                                         : amount(100 * std::abs(change.by.x()), 100 * change.by_sigma.x(), 2, " % ") +
                                               (change.by.x() > 0 ? "longer" : "shorter");
  std::string how, cause;
  switch (change.what) {
    case What::focus:
      how = " the principal distance is " + relative;
      cause = "focus or zoom";
      break;
    case What::aspect:
      how = " fx is " + relative + " against fy";
      cause = "pictures that a program stretched";
      break;
    case What::principal_point:
      how = " the principal point lies elsewhere";
      if (measured)
        how += " by " + amount(change.by.x(), change.by_sigma.x(), 1, "") + ", " +
               amount(change.by.y(), change.by_sigma.y(), 1, " px");
      cause = change.split == Split::upside_down ? "pictures that a program turned by 180 degrees"
                                                 : "pictures that a program cropped or turned, or a stabiliser";
      break;
    case What::distortion:
      how = " the distortion is another";
      if (measured) how += " (k1 by " + amount(change.by.x(), change.by_sigma.x(), 3, ")");
      cause = "focus, another lens, or pictures that a program freed of distortion";
      break;
  }
  return where(change, evidence) + how + ": " + cause +
         (change.or_place ? "; or: seen from another side, with a lens or a board that are not quite as the model has "
                            "them"
                          : "");
}

std::vector<std::string> warnings_of(const CameraTruth& truth) {
  std::vector<std::string> words;
  const auto count = static_cast<int>(truth.evidence.score.size());
  if (truth.change) {
    words.push_back(in_words(*truth.change, truth.evidence));
    // What changes makes them scatter: no other cause is to be named.
    if (truth.empirical.judged && truth.empirical.factor > 1.5) words.push_back(scatter_in_words(truth.empirical));
    return words;
  }
  if (count > 0 && count < fewest_to_compare)
    words.push_back(std::to_string(count) + (count == 1 ? " photograph is" : " photographs are") +
                    " too few to see whether the camera changed (" + std::to_string(fewest_to_compare) +
                    " are needed)");
  if (const std::string scatter = in_words(truth.empirical, truth.scatter); !scatter.empty()) words.push_back(scatter);
  return words;
}

bool fits_better(const TwoCameras& two) {
  if (two.more_unknowns < 1 || two.redundancy < 1 || !(two.rms_as_two > 0)) return two.rms_as_two < two.rms_as_one;
  const double f = (std::pow(two.rms_as_one / two.rms_as_two, 2) - 1) * two.redundancy / two.more_unknowns;
  return f > fisher_f_quantile(0.999, two.more_unknowns, two.redundancy);
}

namespace {

/// The difference of what changes, with its standard deviation.
void put_difference(const TwoCameras& two, CameraChange& change) {
  const auto a = two.first.parameters(), b = two.second.parameters();
  const Eigen::MatrixXd sum = two.first_covariance + two.second_covariance;
  const auto sigma_of = [&](const Eigen::VectorXd& by) { return std::sqrt(std::max(0.0, by.dot(sum * by))); };
  const auto unit = [](Eigen::Index k, double value) {
    return Eigen::VectorXd(value * Eigen::VectorXd::Unit(BrownCamera::parameter_count, k));
  };
  switch (change.what) {
    case What::focus:
    case What::aspect: {
      const double sign = change.what == What::focus ? 1 : -1, share = change.what == What::focus ? 0.5 : 1;
      change.by.x() = share * ((b[0] - a[0]) / a[0] + sign * (b[1] - a[1]) / a[1]);
      change.by_sigma.x() = sigma_of(unit(0, share / a[0]) + unit(1, sign * share / a[1]));
      break;
    }
    case What::principal_point:
      change.by = {b[2] - a[2], b[3] - a[3]};
      change.by_sigma = {sigma_of(unit(2, 1)), sigma_of(unit(3, 1))};
      break;
    case What::distortion:
      change.by.x() = b[4] - a[4], change.by_sigma.x() = sigma_of(unit(4, 1));
      break;
  }
}

}  // namespace

std::string settle_change(CameraTruth& truth, const TwoCameras& two) {
  if (!truth.change) return "";
  char text[300], lengths[100] = "";
  if (!fits_better(two)) {
    std::snprintf(text, sizeof text,
                  " something of the camera seemed to differ, but as two cameras they fit to %.3f px rms and as one to "
                  "%.3f px, which is no better: they count as one",
                  two.rms_as_two, two.rms_as_one);
    const std::string words = where(*truth.change, truth.evidence) + text;
    truth.change.reset();
    return words;
  }
  put_difference(two, *truth.change);
  // What one adjustment takes for the difference may be what another one makes there; two tell.
  constexpr double significant = 4;  // standard deviations
  const auto clearness = [](const CameraChange& change) {
    double most = 0;
    for (const Eigen::Index k : {0, 1})
      if (change.by_sigma(k) > 0) most = std::max(most, std::abs(change.by(k)) / change.by_sigma(k));
    return most;
  };
  CameraChange clearest = *truth.change;
  for (const What what : {What::focus, What::aspect, What::principal_point, What::distortion}) {
    CameraChange other = *truth.change;
    other.what = what, other.by.setZero(), other.by_sigma.setZero();
    put_difference(two, other);
    if (clearness(*truth.change) < significant && clearness(other) > std::max(significant, clearness(clearest)))
      clearest = other;
  }
  truth.change = clearest;
  const double first = std::sqrt(two.first_covariance(0, 0)), second = std::sqrt(two.second_covariance(0, 0));
  if (std::abs(two.second.fx - two.first.fx) > 2 * std::hypot(first, second))
    std::snprintf(lengths, sizeof lengths, ", fx %.1f \u00b1 %.1f and %.1f \u00b1 %.1f px,", two.first.fx, first,
                  two.second.fx, second);
  std::snprintf(text, sizeof text,
                "as two cameras%s they fit to %.3f px rms, as one to %.3f px: put these photographs into a folder of "
                "their own",
                lengths, two.rms_as_two, two.rms_as_one);
  return text;
}

}  // namespace plumbline::markers

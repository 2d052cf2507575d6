// May the result be used?
#include <algorithm>
#include <cmath>

#include "geometry/statistics.hpp"
#include "survey/doctor/network_words.hpp"
#include "survey/model/network_model.hpp"

namespace plumbline::survey {

namespace {

/// Beyond that it is not the instrument that is worse than its profile: readings are wrong, or their units.
constexpr double kLargestSigma0 = 10;
constexpr double kClearly = 0.001;  ///< error of the first kind of the doubt

long failing(const NetworkResult& r, double critical) {
  return std::count_if(r.rows.begin(), r.rows.end(),
                       [&](const ResultRow& row) { return !row.removed && std::abs(row.statistics.w) > critical; });
}

std::string mended(const NetworkResult& r) {
  const auto removed = std::count_if(r.rows.begin(), r.rows.end(), [](const ResultRow& row) { return row.removed; });
  if (removed == 0) return "";
  return "; " + std::to_string(removed) + (removed == 1 ? " reading was" : " readings were") + " taken out";
}

}  // namespace

void judge(const NetworkModel& model, double critical, NetworkResult& r) {
  const std::string sigma0 = "sigma0 " + fixed_digits(r.sigma0, 2);
  const bool high = r.degrees_of_freedom > 0 && r.global_test.verdict == adjustment::GlobalTest::Verdict::high;
  // One sound network in forty fails its global test; without a suspect it is doubted only if it fails clearly.
  const bool clearly = high && r.sum_of_squares > chi_squared_quantile(1 - kClearly, r.degrees_of_freedom);
  const bool error = std::any_of(r.findings.begin(), r.findings.end(),
                                 [](const Finding& f) { return f.severity == Finding::Severity::error; });
  const long suspects = failing(r, critical);
  if (model.contradicted || error || (high && r.sigma0 > kLargestSigma0)) {
    r.validity = Validity::invalid;
    r.verdict = "not a result: " +
                std::string(model.contradicted ? "set-ups contradict each other, see the first finding"
                            : error            ? "the coordinates are probably wrong"
                                               : "the readings contradict each other") +
                " (" + sigma0 + "); mend what the findings name and adjust again";
    const double factor = std::max(1.0, r.sigma0 * r.sigma0 / r.variance_factor);
    r.cofactors *= factor;
    r.variance_factor *= factor;
  } else if (r.degrees_of_freedom == 0) {
    r.validity = Validity::doubtful;
    r.verdict = "cannot be tested: no reading is controlled by another";
  } else if (clearly || suspects > 0) {
    r.validity = Validity::doubtful;
    r.verdict =
        "doubtful: " +
        (suspects > 0 ? std::to_string(suspects) + (suspects == 1 ? " reading fails" : " readings fail") + " the test"
                      : std::string("the readings agree less well than their accuracies say")) +
        " (" + sigma0 + ")" + mended(r);
  } else {
    r.validity = Validity::sound;
    r.verdict = "sound: the readings agree as well as their accuracies say (" + sigma0 +
                (high ? ", a little high" : "") + ")" + mended(r);
  }
}

}  // namespace plumbline::survey

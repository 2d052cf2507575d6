#include "photo/block/tag_block_rejected.hpp"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <algorithm>

#include "base/text/words.hpp"
#include "geometry/statistics.hpp"

namespace plumbline::block {
namespace {

std::string in_mm(const Eigen::Vector3d& v) {
  return fmt::format("{:.1f}, {:.1f}, {:.1f} mm", 1e3 * v.x(), 1e3 * v.y(), 1e3 * v.z());
}

std::vector<std::string> names_of(const TagBlock& given, const std::vector<int>& plates) {
  std::vector<std::string> names;
  for (int plate : plates) names.push_back(given.plates[plate].anchor);
  return names;
}

}  // namespace

void leave_out(int plate, TagControl& control) {
  std::vector<int> rows;
  for (size_t k = 0; k < control.plates.size(); ++k)
    for (int c = 0; c < 3 && control.plates[k] != plate; ++c) rows.push_back(3 * static_cast<int>(k) + c);
  control.position = control.position(rows).eval();
  control.covariance = control.covariance(rows, rows).eval();
  std::erase(control.plates, plate);
}

std::vector<int> plates_of(const std::vector<NeededControl>& needed) {
  std::vector<int> plates;
  for (const NeededControl& point : needed) plates.push_back(point.worst.plate);
  return plates;
}

bool are_too_many(size_t tested, const std::vector<RejectedControl>& rejected) {
  constexpr size_t part = 3;
  return part * rejected.size() > tested;
}

namespace {

constexpr const char* which_does_not_show =
    "survey and photographs do not show the same state, or what is stated of survey, tags or camera is wrong; single "
    "points that are do not stand out, so all are kept";

std::string most_of(const TagBlock& given, const std::vector<RejectedControl>& rejected) {
  std::vector<int> most;
  for (size_t k = 0; k < std::min<size_t>(rejected.size(), 5); ++k) most.push_back(rejected[k].plate);
  return text::enumerate(names_of(given, most));
}

ControlDoubt doubt_of(const RejectedControl& worst, std::string words) {
  return {worst.test, worst.limit, worst.freedom, std::move(words)};
}

/// The group of observations, as people call what is stated of it.
std::string stated_of(const std::string& group) {
  const std::string interior = "interior prior";
  if (group == "control") return "the survey's standard deviations";
  if (group == "tag scale prior") return "the size of the tags";
  if (group == interior) return "the camera's calibration";
  if (group.starts_with(interior)) return "the calibration of camera " + group.substr(interior.size() + 4);
  return "the " + group;
}

}  // namespace

ControlDoubt too_many(const TagBlock& given, size_t tested, const std::vector<RejectedControl>& rejected) {
  return doubt_of(rejected.front(), "more than a third of the " + std::to_string(tested) +
                                        " control points contradict the photographs, " + most_of(given, rejected) +
                                        " most: " + which_does_not_show);
}

ControlDoubt not_mended(const TagBlock& given, size_t tested, const std::vector<RejectedControl>& rejected) {
  return doubt_of(rejected.front(), std::to_string(rejected.size()) + " of the " + std::to_string(tested) +
                                        " control points contradict the photographs, " + most_of(given, rejected) +
                                        " most, and without them the rest still does not hold: " + which_does_not_show);
}

ControlDoubt rivals(const TagBlock& given, const RejectedControl& worst, const std::vector<int>& others) {
  std::vector<int> all{worst.plate};
  all.insert(all.end(), others.begin(), others.begin() + std::min<std::ptrdiff_t>(std::ssize(others), 4));
  const std::string more = others.size() > 4 ? " and " + std::to_string(others.size() - 4) + " more" : "";
  return doubt_of(
      worst,
      "control contradicts the photographs, and that of " + text::enumerate(names_of(given, all)) + more +
          fmt::format(
              " would explain it alike ({} by {}): which is wrong the others do not tell, so all are kept; survey one "
              "more near them, or measure these again",
              given.plates[worst.plate].anchor, in_mm(worst.off)));
}

ControlDoubt needed(const TagBlock& given, const NeededControl& point) {
  const RejectedControl& worst = point.worst;
  return doubt_of(worst, fmt::format("the control of {} contradicts the photographs and the other control by {} and is "
                                     "kept, because without it: ",
                                     given.plates[worst.plate].anchor, in_mm(worst.off)) +
                             point.without);
}

ControlDoubt as_far_as_believed(const TagBlock& given, const RejectedControl& worst,
                                const std::vector<std::string>& disproved) {
  std::vector<std::string> stated;
  for (const std::string& group : disproved) stated.push_back(stated_of(group));
  const std::string what = text::enumerate(stated);
  return doubt_of(worst, fmt::format("control contradicts the photographs, that of {} most, by {}, but only as far as "
                                     "one believes {}, which the block disproves: so it is kept",
                                     given.plates[worst.plate].anchor, in_mm(worst.off), what));
}

namespace {

void fill_rejected(const TagBlock& given, TagBlockResult& result) {
  for (RejectedControl& rejected : result.rejected_control) {
    const auto k = std::find(given.control.plates.begin(), given.control.plates.end(), rejected.plate) -
                   given.control.plates.begin();
    const auto j = std::find(result.plates.begin(), result.plates.end(), rejected.plate) - result.plates.begin();
    rejected.off = given.control.position.segment<3>(3 * k) - result.anchors.segment<3>(3 * j);
    rejected.sigma =
        (given.control.covariance.diagonal().segment<3>(3 * k) + result.anchor_covariance.diagonal().segment<3>(3 * j))
            .cwiseSqrt();
    const bool from_the_beginning = rejected.limit == 0;
    if (from_the_beginning) {
      constexpr double level = 1e-3;  // over all points
      const Eigen::Matrix3d both =
          given.control.covariance.block<3, 3>(3 * k, 3 * k) + result.anchor_covariance.block<3, 3>(3 * j, 3 * j);
      rejected.test = rejected.off.dot(both.ldlt().solve(rejected.off));
      rejected.limit = chi_squared_quantile(1 - level / static_cast<double>(given.control.plates.size()), 3);
    }
    result.left_out.push_back("the control of " + given.plates[rejected.plate].anchor +
                              ", which contradicts the photographs and the other control by " + in_mm(rejected.off) +
                              (from_the_beginning ? " (or the offset of its tag is wrong)" : ""));
  }
}

}  // namespace

void fill_judged_control(const TagBlock& given, const JudgedControl& judged, TagBlockResult& result) {
  result.rejected_control = judged.rejected;
  for (const NeededControl& point : judged.needed) result.control_doubts.push_back(needed(given, point));
  result.control_doubts.insert(result.control_doubts.end(), judged.doubts.begin(), judged.doubts.end());
  fill_rejected(given, result);
  if (judged.hidden.empty()) return;
  const size_t shown = std::min<size_t>(judged.hidden.size(), 5);
  const std::vector<int> first(judged.hidden.begin(), judged.hidden.begin() + static_cast<std::ptrdiff_t>(shown));
  const std::string more =
      judged.hidden.size() > shown ? " and of " + std::to_string(judged.hidden.size() - shown) + " more" : "";
  result.warnings.push_back("the control of " + text::enumerate(names_of(given, first)) + more +
                            " is not tested in every direction: an error of it would not show; survey more points");
}

void name_wrong_control(const TagBlock& given, TagBlockOptions options, TagBlockResult& result) {
  options.robust_control = true;
  options.withhold.clear();
  const TagBlockResult without = adjust_tag_block(given, options);
  for (const RejectedControl& rejected : without.rejected_control)
    result.control_doubts.push_back(doubt_of(
        rejected, fmt::format("the control of {} contradicts the photographs and the other control by {} and is kept: "
                              "robust_control=true of the adjustment (block.with.robust_control=true) leaves it out",
                              given.plates[rejected.plate].anchor, in_mm(rejected.off))));
  result.control_doubts.insert(result.control_doubts.end(), without.control_doubts.begin(),
                               without.control_doubts.end());
}

}  // namespace plumbline::block

#include "photo/block/tag_block_rejected.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "base/text/words.hpp"

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

bool are_too_many(size_t tested, const std::vector<RejectedControl>& rejected) {
  constexpr size_t part = 3;
  return part * rejected.size() > tested;
}

namespace {

constexpr const char* no_single_points =
    "survey and photographs do not show the same state, or what is stated of survey, tags or camera is wrong; that is "
    "no matter of single points, so all are kept";

std::string most_of(const TagBlock& given, const std::vector<RejectedControl>& rejected) {
  std::vector<int> most;
  for (size_t k = 0; k < std::min<size_t>(rejected.size(), 5); ++k) most.push_back(rejected[k].plate);
  return text::enumerate(names_of(given, most));
}

}  // namespace

std::string too_many_in_words(const TagBlock& given, size_t tested, const std::vector<RejectedControl>& rejected) {
  return "more than a third of the " + std::to_string(tested) + " control points contradict the photographs, " +
         most_of(given, rejected) + " most: " + no_single_points;
}

std::string not_mended_in_words(const TagBlock& given, size_t tested, const std::vector<RejectedControl>& rejected) {
  return std::to_string(rejected.size()) + " of the " + std::to_string(tested) +
         " control points contradict the photographs, " + most_of(given, rejected) +
         " most, and without them the rest still does not hold: " + no_single_points;
}

std::string rivals_in_words(const TagBlock& given, const RejectedControl& worst, const std::vector<int>& rivals) {
  std::vector<int> all{worst.plate};
  all.insert(all.end(), rivals.begin(), rivals.begin() + std::min<std::ptrdiff_t>(std::ssize(rivals), 4));
  const std::string more = rivals.size() > 4 ? " and " + std::to_string(rivals.size() - 4) + " more" : "";
  return "control contradicts the photographs, and that of " + text::enumerate(names_of(given, all)) + more +
         fmt::format(
             " would explain it alike ({} by {}): which is wrong the others do not tell, so all are kept; survey one "
             "more near them, or measure these again",
             given.plates[worst.plate].anchor, in_mm(worst.off));
}

std::string needed_in_words(const TagBlock& given, const RejectedControl& worst, const std::string& without) {
  return fmt::format(
             "the control of {} contradicts the photographs and the other control by {} and is kept, because without "
             "it: ",
             given.plates[worst.plate].anchor, in_mm(worst.off)) +
         without;
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
    result.left_out.push_back("the control of " + given.plates[rejected.plate].anchor +
                              ", which contradicts the photographs and the other control by " + in_mm(rejected.off));
  }
}

}  // namespace

void fill_judged_control(const TagBlock& given, const JudgedControl& judged, TagBlockResult& result) {
  result.rejected_control = judged.rejected;
  result.control_doubt = judged.doubt;
  fill_rejected(given, result);
  if (!judged.doubt.empty()) result.warnings.push_back(judged.doubt);
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
    result.warnings.push_back(
        fmt::format("the control of {} contradicts the photographs and the other control by {} and is kept: "
                    "robust_control=true of the adjustment (block.with.robust_control=true) leaves it out",
                    given.plates[rejected.plate].anchor, in_mm(rejected.off)));
  if (!without.control_doubt.empty()) result.warnings.push_back(without.control_doubt);
}

}  // namespace plumbline::block

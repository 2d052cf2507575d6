#include "photo/block/tag_block_rejected.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <stdexcept>

#include "base/text/words.hpp"

namespace plumbline::block {

void leave_out(int plate, TagControl& control) {
  std::vector<int> rows;
  for (size_t k = 0; k < control.plates.size(); ++k)
    for (int c = 0; c < 3 && control.plates[k] != plate; ++c) rows.push_back(3 * static_cast<int>(k) + c);
  control.position = control.position(rows).eval();
  control.covariance = control.covariance(rows, rows).eval();
  std::erase(control.plates, plate);
}

void require_few(const TagBlock& given, const std::vector<RejectedControl>& rejected) {
  constexpr size_t part = 3;
  if (part * rejected.size() <= given.control.plates.size()) return;
  std::vector<std::string> names;
  for (size_t k = 0; k < std::min<size_t>(rejected.size(), 5); ++k)
    names.push_back(given.plates[rejected[k].plate].anchor);
  throw std::runtime_error("more than a third of the " + std::to_string(given.control.plates.size()) +
                           " control points contradict the photographs, " + text::enumerate(names) +
                           " most: survey and photographs do not show the same state, or their standard deviations are "
                           "wrong; leaving points out (robust_control) does not mend that");
}

void fill_rejected_control(const TagBlock& given, TagBlockResult& result) {
  for (RejectedControl& rejected : result.rejected_control) {
    const auto k = std::find(given.control.plates.begin(), given.control.plates.end(), rejected.plate) -
                   given.control.plates.begin();
    const auto j = std::find(result.plates.begin(), result.plates.end(), rejected.plate) - result.plates.begin();
    rejected.off = given.control.position.segment<3>(3 * k) - result.anchors.segment<3>(3 * j);
    rejected.sigma =
        (given.control.covariance.diagonal().segment<3>(3 * k) + result.anchor_covariance.diagonal().segment<3>(3 * j))
            .cwiseSqrt();
    const std::string text =
        fmt::format(" contradicts the photographs and the other control by {:.1f}, {:.1f}, {:.1f} mm",
                    1e3 * rejected.off.x(), 1e3 * rejected.off.y(), 1e3 * rejected.off.z());
    result.left_out.push_back("the control of " + given.plates[rejected.plate].anchor + ", which" + text);
  }
}

void name_wrong_control(const TagBlock& given, TagBlockOptions options, TagBlockResult& result) {
  options.robust_control = true;
  options.withhold.clear();
  try {
    const TagBlockResult without = adjust_tag_block(given, options);
    for (const RejectedControl& rejected : without.rejected_control)
      result.warnings.push_back(fmt::format(
          "the control of {} contradicts the photographs and the other control by {:.1f}, {:.1f}, {:.1f} "
          "mm and is kept; robust_control=true of the adjustment (block.with.robust_control=true) leaves it out",
          given.plates[rejected.plate].anchor, 1e3 * rejected.off.x(), 1e3 * rejected.off.y(), 1e3 * rejected.off.z()));
  } catch (const std::runtime_error& error) {
    result.warnings.emplace_back(error.what());
  }
}

}  // namespace plumbline::block

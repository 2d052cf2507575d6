#include "judgement/mounting.hpp"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

namespace plumbline::judgement {
namespace {

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t"), last = text.find_last_not_of(" \t");
  return first == std::string::npos ? std::string() : text.substr(first, last - first + 1);
}

[[noreturn]] void fail(const std::string& rule, const std::string& found) {
  throw std::runtime_error("mounting rule '" + rule + "': found '" + found +
                           "', expected 'selection: right=0.3mm, up=0.3mm, out=1mm' with standard deviations from 0 to "
                           "100 mm along the axes of the plate");
}

}  // namespace

MountingRule parse_mounting(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) fail(text, text);
  MountingRule rule{bim::Selection(text.substr(0, colon)),
                    Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()), trimmed(text)};
  std::string rest = text.substr(colon + 1);
  for (bool more = true; more;) {
    const std::size_t comma = rest.find(',');
    const std::string part = trimmed(rest.substr(0, comma));
    more = comma != std::string::npos;
    if (more) rest = rest.substr(comma + 1);
    const std::size_t equals = std::min(part.find('='), part.size());
    const std::string axis = trimmed(part.substr(0, equals)),
                      number = trimmed(part.substr(std::min(equals + 1, part.size())));
    double value = 0;
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
    const std::string unit = trimmed(std::string(end, number.data() + number.size()));
    value *= unit == "mm" ? 1e-3 : 1;
    const int k = axis == "right" ? 0 : axis == "up" ? 1 : axis == "out" ? 2 : -1;
    if (k < 0 || error != std::errc() || (unit != "mm" && unit != "m") || !(value >= 0 && value <= 0.1))
      fail(text, part);
    rule.sigma[k] = value;
  }
  return rule;
}

Eigen::Matrix3d Mounting::covariance(const bim::ElementFacts& anchor, const std::vector<double>& of_plate,
                                     const Eigen::Quaterniond& frame_from_plate) const {
  Eigen::Vector3d chosen = Eigen::Vector3d::Constant(sigma);
  if (of_plate.size() == 3) chosen = Eigen::Vector3d(of_plate[0], of_plate[1], of_plate[2]);
  for (const MountingRule& rule : rules)
    if (rule.selection.matches(anchor)) chosen = rule.sigma.array().isNaN().select(chosen, rule.sigma);
  if (chosen.isZero(0)) return Eigen::Matrix3d::Zero();
  const Eigen::Matrix3d turn = frame_from_plate.normalized().toRotationMatrix();
  return turn * chosen.cwiseAbs2().asDiagonal() * turn.transpose();
}

std::string Mounting::words(std::size_t from_table) const {
  std::string text;
  if (sigma > 0) {
    char figure[64];
    std::snprintf(figure, sizeof figure, "%.3g mm on each axis of a plate", 1e3 * sigma);
    text = figure;
  }
  const auto add = [&](const std::string& more) { text += (text.empty() ? "" : "; ") + more; };
  if (from_table > 0) add(std::to_string(from_table) + " plates by the plate table");
  for (const MountingRule& rule : rules) add(rule.text);
  return text;
}

}  // namespace plumbline::judgement

#include "building/ifc/selection_rule.hpp"

#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "base/text/text.hpp"

namespace plumbline::ifc {
namespace {

using text::trim;

}  // namespace

double length_with_unit(std::string_view text) {
  text = trim(text);
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const std::string_view unit = trim(text.substr(static_cast<std::size_t>(end - text.data())));
  const double factor = unit == "mm" ? 1e-3 : unit == "m" ? 1 : 0;
  if (error != std::errc() || factor == 0 || !std::isfinite(number)) return std::numeric_limits<double>::quiet_NaN();
  return number * factor;
}

SelectionAndRest split_rule(const std::string& text, const std::string& example) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos)
    throw std::runtime_error("'" + text + "': found no ':', expected such as '" + example + "'");
  return {Selection(text.substr(0, colon)), std::string(trim(std::string_view(text).substr(colon + 1)))};
}

LengthRule parse_lengths(const std::string& text, const std::string& example) {
  auto [selection, rest] = split_rule(text, example);
  LengthRule rule{std::move(selection), {}, std::string(trim(text))};
  for (const std::string_view part : text::split(rest, ',')) {
    const std::string_view written = trim(part);
    const std::size_t equals = std::min(written.find('='), written.size());
    const std::string_view number = trim(written.substr(std::min(equals + 1, written.size())));
    std::string name(trim(written.substr(0, equals)));
    // Whichever were taken, the other would be dropped.
    for (const NamedLength& before : rule.lengths)
      if (before.name == name)
        throw std::runtime_error("'" + text + "': found '" + before.text + "' and '" + std::string(written) +
                                 "', expected each name once");
    rule.lengths.push_back({std::move(name), length_with_unit(number), std::string(written)});
  }
  return rule;
}

}  // namespace plumbline::ifc

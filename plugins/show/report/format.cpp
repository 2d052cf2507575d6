#include "show/report/format.hpp"

#include <charconv>
#include <cmath>

namespace plumbline::report {

namespace {

std::string plain(double value, int decimals) {
  char buffer[400];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, decimals);
  std::string text(buffer, end.ptr);
  if (text[0] == '-' && text.find_first_of("123456789") == std::string::npos) text.erase(0, 1);
  return text;
}

std::string trimmed(std::string text) {
  if (text.find('.') == std::string::npos) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

}  // namespace

std::string fixed(double value, int decimals) {
  if (!std::isfinite(value)) return unknown;
  std::string text = plain(value, decimals);
  if (text[0] == '-') text.replace(0, 1, "\u2212");
  return text;
}

std::string signed_fixed(double value, int decimals) {
  const std::string text = fixed(value, decimals);
  return std::isfinite(value) && value > 0 && text.find_first_of("123456789") != std::string::npos ? "+" + text : text;
}

std::string mm(double metres, int decimals) { return fixed(1e3 * metres, decimals); }
std::string signed_mm(double metres, int decimals) { return signed_fixed(1e3 * metres, decimals); }

std::string mm_unit(double metres, int decimals) {
  return std::isfinite(metres) ? mm(metres, decimals) + "\u00A0mm" : unknown;
}

std::string mm_with_u(double metres, double u, int decimals) {
  if (!std::isfinite(metres)) return unknown;
  const std::string value = signed_mm(metres, decimals);
  return std::isfinite(u) ? value + "\u00A0±\u00A0" + mm(u, decimals) : value;
}

std::string tolerance(double metres) { return trimmed(plain(1e3 * metres, 3)) + "\u00A0mm"; }

std::string percent(double fraction, int decimals) {
  if (!std::isfinite(fraction)) return unknown;
  if (fraction == 0 || fraction == 1) return fraction == 0 ? "0\u00A0%" : "100\u00A0%";
  std::string text = plain(100 * fraction, decimals);
  const double step = std::pow(10.0, -decimals);
  if (100 * fraction > 100 - 0.5 * step) text = plain(100 - step, decimals);
  if (100 * fraction < 0.5 * step) text = plain(step, decimals);
  return text + "\u00A0%";
}

std::string probability(double p) {
  if (!std::isfinite(p)) return unknown;
  if (p < 0.001) return "<\u00A00.001";
  return p > 0.999 ? ">\u00A00.999" : plain(p, 3);
}

std::string count(long n, const std::string& singular, const std::string& plural) {
  return std::to_string(n) + "\u00A0" + (n == 1 ? singular : plural);
}

std::string px(double value) { return std::isfinite(value) ? trimmed(plain(value, 2)) : "0"; }

}  // namespace plumbline::report

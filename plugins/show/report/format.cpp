#include "show/report/format.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>

#include "show/report/language.hpp"

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

std::string with_decimal_sign(std::string text) {
  if (speech().language == Language::german) std::replace(text.begin(), text.end(), '.', ',');
  return text;
}

constexpr double kInch = 0.0254;  ///< [m], exactly: the international one

int decimals_spoken(int decimals) { return speech().units == Units::inches ? decimals + 2 : decimals; }

}  // namespace

double in_units(double metres) { return speech().units == Units::inches ? metres / kInch : 1e3 * metres; }

std::string fixed(double value, int decimals) {
  if (!std::isfinite(value)) return unknown;
  std::string text = with_decimal_sign(plain(value, decimals));
  if (text[0] == '-') text.replace(0, 1, "\u2212");
  return text;
}

std::string signed_fixed(double value, int decimals) {
  const std::string text = fixed(value, decimals);
  return std::isfinite(value) && value > 0 && text.find_first_of("123456789") != std::string::npos ? "+" + text : text;
}

std::string mm(double metres, int decimals) {
  return in_units_spoken(fixed(in_units(metres), decimals_spoken(decimals)));
}
std::string signed_mm(double metres, int decimals) {
  return in_units_spoken(signed_fixed(in_units(metres), decimals_spoken(decimals)));
}

std::string in_fractions(double metres) {
  if (speech().units != Units::inches || !std::isfinite(metres)) return "";
  const auto parts = std::lround(32 * std::abs(metres) / kInch);
  const auto whole = parts / 32, rest = parts % 32, common = std::gcd(rest, 32L);
  if (parts == 0) return "";
  if (rest == 0) return " (" + std::to_string(whole) + ")";
  return " (" + (whole > 0 ? std::to_string(whole) + "-" : "") + std::to_string(rest / common) + "/" +
         std::to_string(32 / common) + ")";
}

std::string to_set(double metres) { return mm_unit(std::abs(metres), 1) + in_fractions(metres); }

int decimals_beside(double value, double limit, int decimals) {
  if (!std::isfinite(value) || !std::isfinite(limit) || value == limit) return decimals;
  for (int digits = decimals; digits < decimals + 3; ++digits)
    if (mm(value, digits) != mm(limit, digits)) return digits;
  return decimals + 3;
}

std::string mm_unit(double metres, int decimals) {
  return std::isfinite(metres) ? mm(metres, decimals) + "\u00A0mm" : unknown;
}

std::string mm_with_u(double metres, double u, int decimals) {
  if (!std::isfinite(metres)) return unknown;
  const std::string value = signed_mm(metres, decimals);
  return std::isfinite(u) ? value + "\u00A0±\u00A0" + mm(u, decimals) : value;
}

std::string tolerance(double metres) {
  const int decimals = speech().units == Units::inches ? 4 : 3;
  return in_units_spoken(with_decimal_sign(trimmed(plain(in_units(metres), decimals)))) + "\u00A0mm";
}

std::string percent(double fraction, int decimals) {
  if (!std::isfinite(fraction)) return unknown;
  if (fraction == 0 || fraction == 1) return fraction == 0 ? "0\u00A0%" : "100\u00A0%";
  std::string text = plain(100 * fraction, decimals);
  const double step = std::pow(10.0, -decimals);
  if (100 * fraction > 100 - 0.5 * step) text = plain(100 - step, decimals);
  if (100 * fraction < 0.5 * step) text = plain(step, decimals);
  return with_decimal_sign(text) + "\u00A0%";
}

std::string probability(double p) {
  if (!std::isfinite(p)) return unknown;
  if (p < 0.001) return with_decimal_sign("<\u00A00.001");
  return with_decimal_sign(p > 0.999 ? ">\u00A00.999" : plain(p, 3));
}

std::string count(long n, const std::string& singular, const std::string& plural) {
  return std::to_string(n) + "\u00A0" + (n == 1 ? singular : plural);
}

std::string px(double value) { return std::isfinite(value) ? trimmed(plain(value, 2)) : "0"; }

}  // namespace plumbline::report

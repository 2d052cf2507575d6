#include "show/bench/pairing.hpp"

#include <fmt/core.h>

#include <cctype>
#include <cmath>

#include "base/text/text.hpp"
#include "base/text/words.hpp"

namespace plumbline::bench {

std::vector<Pairing> pairings(const Analysis& analysis, const std::string& group) {
  std::vector<Pairing> list;
  std::string last;
  for (const Duel& duel : analysis.duels) {
    if (duel.group != group) continue;
    const std::string names = duel.first + "\n" + duel.second;
    if (names != last) list.emplace_back();
    last = names;
    if (duel.overall)
      list.back().overall = &duel;
    else
      list.back().places.push_back(&duel);
  }
  return list;
}

bool errors_equal(const Duel& duel, double rope) {
  const auto& e = duel.errors;
  return duel.refused.empty() && e.places > 0 && (e.same || (e.narrow.lower > -rope && e.narrow.upper < rope));
}

bool all_same(const Pairing& pair) {
  bool any = false;
  for (const Duel* duel : pair.places) {
    if (!duel->refused.empty() || duel->errors.lost_first + duel->errors.lost_second > 0) return false;
    if (duel->errors.places == 0) continue;
    if (!duel->errors.same) return false;
    any = true;
  }
  return any;
}

std::string power_text(const Pairing& pair, const Bench& bench) {
  // A verdict that rests on results which are no merit leaves the errors open.
  const auto of_errors = [&](const Duel& duel) {
    statistics::PairedComparison errors = duel.errors;
    if (duel.untested && errors.places > 0 && !errors_equal(duel, bench.rope))
      errors.verdict = statistics::Verdict::undecided;
    return errors;
  };
  const Duel* worst = nullptr;
  double most = 0;
  for (const Duel* duel : pair.places) {
    if (!duel->refused.empty()) continue;
    const double wanted = seeds_wanted(of_errors(*duel), bench.rope);
    if (wanted > most) most = wanted, worst = duel;
  }
  if (!worst) return "";
  const std::string power = power_in_words(of_errors(*worst), bench.rope, 1e3, "mm");
  return power.empty() || worst->place.empty() ? power : power + " on " + worst->place;
}

std::string listed(const std::vector<std::string>& places) { return text::enumerate(places, " / ", " / "); }

std::string millimetres(double metres) {
  const double mm = 1e3 * std::abs(metres);
  return text::format_fixed(mm, mm < 0.1 ? 3 : mm < 10 ? 2 : 1) + " mm";
}

std::string rope_text(const Bench& bench) { return fmt::format("{:g} mm", 1e3 * bench.rope); }

std::string begin_sentence(std::string text, const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (text.starts_with(name) && (text.size() == name.size() || text[name.size()] == ' ' || text[name.size()] == ','))
      return text;
  const std::string word = text.substr(0, text.find(' '));
  if (word.find_first_of("._%") == std::string::npos && !text.empty())
    text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

}  // namespace plumbline::bench

#include "base/text/near_text.hpp"

#include <algorithm>
#include <cctype>

namespace plumbline::text {
namespace {

std::string in_small_letters(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace

std::size_t letter_edits(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i)
    for (std::size_t j = 1; j <= b.size(); ++j) {
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

std::string nearest_of(const std::string& wanted, const std::vector<std::string>& candidates) {
  constexpr std::size_t kLongest = 200;  // a word of people
  std::size_t best = std::max<std::size_t>(1, wanted.size() / 3) + 1;
  std::string nearest;
  if (wanted.size() > kLongest) return nearest;
  for (const std::string& candidate : candidates) {
    if (candidate.size() > kLongest) continue;
    const std::size_t far = letter_edits(in_small_letters(wanted), in_small_letters(candidate));
    if (far < best) best = far, nearest = candidate;
  }
  return nearest;
}

bool differ_in_figures_alone(const std::string& a, const std::string& b) {
  const auto without = [](const std::string& text) {
    std::string kept;
    for (const char c : text) {
      const bool figure = std::isdigit(static_cast<unsigned char>(c)) != 0;
      if (!figure || !kept.ends_with('#')) kept += figure ? '#' : c;
    }
    return kept;
  };
  return a != b && without(a) == without(b);
}

}  // namespace plumbline::text

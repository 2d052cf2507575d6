#include "base/text/words.hpp"

#include <algorithm>

#include "base/text/text.hpp"

namespace plumbline::text {

std::string join(const std::vector<std::string>& words, std::size_t most) {
  const std::size_t shown = std::min(words.size(), most);
  std::string text;
  for (std::size_t i = 0; i < shown; ++i) text += (i > 0 ? ", " : "") + words[i];
  return words.size() > shown ? text + " and " + std::to_string(words.size() - shown) + " more" : text;
}

std::string enumerate(const std::vector<std::string>& words, const char* last, const char* between) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? last : between) + words[i];
  return text;
}

std::string millimetres(double metres, int decimals) { return format_fixed(1e3 * metres, decimals) + " mm"; }

}  // namespace plumbline::text

#include "survey/words/network_words.hpp"

#include <sstream>

namespace plumbline::survey {

std::string join(const std::vector<std::string>& ids, size_t most) {
  std::string text;
  for (size_t i = 0; i < ids.size() && i < most; ++i) text += (i ? ", " : "") + ids[i];
  if (ids.size() > most) text += " and " + std::to_string(ids.size() - most) + " more";
  return text;
}

std::string fixed_digits(double value, int digits) {
  std::ostringstream text;
  text.setf(std::ios::fixed);
  text.precision(digits);
  text << value;
  return text.str();
}

}  // namespace plumbline::survey

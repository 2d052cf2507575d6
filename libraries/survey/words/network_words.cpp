#include "survey/words/network_words.hpp"

#include "base/text/text.hpp"
#include "base/text/words.hpp"

namespace plumbline::survey {

std::string join(const std::vector<std::string>& ids, size_t most) { return text::join(ids, most); }

std::string fixed_digits(double value, int digits) { return text::format_fixed(value, digits); }

}  // namespace plumbline::survey

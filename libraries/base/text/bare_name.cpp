#include "base/text/bare_name.hpp"

namespace plumbline::text {

std::string bare_name(const std::string& name) {
  std::string out;
  bool digit_before = false;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const auto c = static_cast<unsigned char>(name[i]);
    const bool digit = c >= '0' && c <= '9';
    if (c == '0' && !digit_before && i + 1 < name.size() && name[i + 1] >= '0' && name[i + 1] <= '9') continue;
    digit_before = digit;
    if (digit || (c >= 'A' && c <= 'Z') || c >= 0x80) out += name[i];
    if (c >= 'a' && c <= 'z') out += static_cast<char>(c - 'a' + 'A');
  }
  return out;
}

}  // namespace plumbline::text

#include "building/judgement/facade_order.hpp"

#include <cctype>
#include <set>

namespace plumbline::judgement {
namespace {

constexpr std::size_t kLongest = 11;  // of 31 that a layer of DXF R12 may have

std::string code_of(const std::string& name) {
  std::string code;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80 && std::isalnum(byte))
      code += static_cast<char>(std::toupper(byte));
    else if (!code.empty() && code.back() != '_')
      code += '_';
  }
  code = code.substr(0, kLongest);
  while (code.ends_with('_')) code.pop_back();
  return code.empty() ? "F" : code;
}

}  // namespace

std::map<std::string, std::string> facade_codes(const DeviationT& deviation) {
  std::map<std::string, std::string> codes;
  if (deviation.facades.size() < 2) return codes;
  std::set<std::string> taken;
  for (const auto& facade : deviation.facades) {
    std::string code = code_of(facade->name);
    for (int n = 2; !taken.insert(code).second; ++n) {
      const std::string number = "_" + std::to_string(n);
      code = code_of(facade->name).substr(0, kLongest - number.size()) + number;
    }
    codes.emplace(facade->name, code);
  }
  return codes;
}

}  // namespace plumbline::judgement

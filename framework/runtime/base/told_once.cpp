#include "runtime/base/told_once.hpp"

#include <map>
#include <sstream>

namespace plumbline::runtime {

namespace {

constexpr size_t kAlike = 3, kNames = 4;
constexpr const char* kItem = " on item ";

std::string without_item(const std::string& text) {
  const size_t at = text.rfind(kItem);
  return at == std::string::npos || text.find_first_not_of("0123456789of ", at + 9) != std::string::npos
             ? text
             : text.substr(0, at);
}

/// Where in the text what it is about is named: the first part before a colon with a number or a suffix in it, as in
/// "left out: IMG_1.jpg: ...".
std::pair<size_t, size_t> subject(const std::string& text) {
  size_t begin = 0;
  for (size_t end; (end = text.find(": ", begin)) != std::string::npos && end < 200; begin = end + 2)
    if (text.substr(begin, end - begin).find_first_of("0123456789.") != std::string::npos) return {begin, end - begin};
  return {0, 0};
}

/// What is left of a text without its subject and the words that hold numbers or paths.
std::string kind_of(const std::string& text) {
  const auto [begin, size] = subject(text);
  std::istringstream words(without_item(std::string(text).erase(begin, size)));
  std::string kind, word;
  while (words >> word) {
    if (word.find_first_of("0123456789/\\") == std::string::npos) kind += word + ' ';
  }
  return kind;
}

struct Alike {
  size_t number = 0;
  std::vector<std::string> names;
};

}  // namespace

std::vector<std::string> told_once(const std::vector<std::string>& texts) {
  std::map<std::string, Alike> kinds;
  for (const std::string& text : texts) {
    Alike& alike = kinds[kind_of(text)];
    const auto [begin, size] = subject(text);
    if (alike.number++ > 0 && alike.names.size() < kNames && size > 0) alike.names.push_back(text.substr(begin, size));
  }
  std::vector<std::string> lines;
  for (const std::string& text : texts) {
    Alike& alike = kinds[kind_of(text)];
    if (alike.number == 0) continue;
    if (alike.number <= kAlike) {
      lines.push_back(text);
      continue;
    }
    std::string names;
    for (const std::string& name : alike.names) names += (names.empty() ? ": " : ", ") + name;
    if (!names.empty() && alike.names.size() + 1 < alike.number) names += ", others";
    lines.push_back(without_item(text) + " [and " + std::to_string(alike.number - 1) + " more like this" + names +
                    "; run.jsonl has each]");
    alike.number = 0;
  }
  return lines;
}

}  // namespace plumbline::runtime

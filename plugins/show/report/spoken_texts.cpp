#include "show/report/spoken_texts.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <sstream>
#include <string_view>
#include <utility>

#include "base/text/xml_text.hpp"
#include "show/report/catalogue.hpp"
#include "show/report/language.hpp"

namespace plumbline::report {

namespace {

/// For a terminal or a file of text, where a no-break space is in the way of who searches.
std::string plainly_spoken(const std::string& english) {
  std::string said = spoken(english);
  for (std::size_t at = 0; (at = said.find("\u00A0", at)) != std::string::npos;) said.replace(at, 2, " ");
  return said;
}

std::string unescaped(std::string text) {
  static constexpr std::array<std::pair<const char*, const char*>, 6> entities = {
      {{"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&apos;", "'"}, {"&#39;", "'"}, {"&amp;", "&"}}};
  for (const auto& [entity, sign] : entities)
    for (std::size_t at = 0; (at = text.find(entity, at)) != std::string::npos; ++at)
      text.replace(at, std::string_view(entity).size(), sign);
  return text;
}

bool is_number_alone(std::string_view text) {
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  const std::size_t point = text.find('.');
  return point != std::string_view::npos && point > 0 && point + 1 < text.size() &&
         std::all_of(text.begin(), text.end(),
                     [](char c) { return c == '.' || std::isdigit(static_cast<unsigned char>(c)) != 0; }) &&
         text.find('.', point + 1) == std::string_view::npos;
}

std::string spoken_text(const std::string& escaped) {
  const std::size_t first = escaped.find_first_not_of(" \n");
  if (first == std::string::npos) return escaped;
  const std::size_t end = escaped.find_last_not_of(" \n") + 1;
  const std::string text = unescaped(escaped.substr(first, end - first));
  const bool number = speech().language == Language::german && is_number_alone(text);
  const std::string said = number ? german().number(text) : spoken(text);
  return escaped.substr(0, first) + text::xml_escaped(said) + escaped.substr(end);
}

/// The tag as it is, but for the language that it names and what it says aloud.
std::string spoken_tag(std::string tag) {
  const auto set = [&](std::string_view name, auto&& change) {
    const std::size_t at = tag.find(name);
    if (at == std::string::npos) return;
    const std::size_t begin = at + name.size(), end = tag.find('"', begin);
    if (end != std::string::npos) tag.replace(begin, end - begin, change(tag.substr(begin, end - begin)));
  };
  if (tag.starts_with("<html") && speech().language == Language::german)
    set(" lang=\"", [](const std::string&) { return std::string("de"); });
  set(" aria-label=\"", spoken_text);
  return tag;
}

bool stays(std::string_view tag) {
  return tag.starts_with("<style") || tag.starts_with("<script") || tag.find(" translate=\"no\"") != tag.npos;
}

}  // namespace

std::string spoken_lines(const std::string& text) {
  std::string out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t start = std::min(line.find_first_not_of(' '), line.size());
    out += line.substr(0, start) + plainly_spoken(line.substr(start)) + "\n";
  }
  return out;
}

std::string spoken_comments(const std::string& yaml) {
  std::string out;
  std::istringstream lines(yaml);
  for (std::string line; std::getline(lines, line); out += line + "\n") {
    static constexpr std::string_view inner = "   # ";
    const std::size_t behind = line.rfind(inner);
    const std::size_t begin = behind != std::string::npos ? behind + inner.size()
                              : line.starts_with("# ")    ? std::size_t{2}
                                                          : std::string::npos;
    if (begin < line.size()) line.replace(begin, std::string::npos, plainly_spoken(line.substr(begin)));
  }
  return out;
}

std::string spoken_page(const std::string& html) {
  std::string out;
  for (std::size_t at = 0; at < html.size();) {
    if (html[at] != '<') {
      const std::size_t end = std::min(html.find('<', at), html.size());
      out += spoken_text(html.substr(at, end - at)), at = end;
      continue;
    }
    std::size_t end = std::min(html.find('>', at), html.size() - 1) + 1;
    const std::string tag = html.substr(at, end - at);
    out += spoken_tag(tag), at = end;
    if (!stays(tag) || tag.ends_with("/>")) continue;
    const std::string close = "</" + tag.substr(1, tag.find_first_of(" >") - 1);
    end = std::min(html.find(close, at), html.size());
    out += html.substr(at, end - at), at = end;
  }
  return out;
}

}  // namespace plumbline::report

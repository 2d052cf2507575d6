#include "runtime/record/file_content.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <map>

#include "runtime/base/digest.hpp"

namespace plumbline::runtime {

namespace {

using Json = nlohmann::ordered_json;

/// A line of text as its words and its numbers with a decimal point, which may differ within a tolerance.
Json line_of(const std::string& line) {
  const auto digit = [&](size_t at) { return at < line.size() && line[at] >= '0' && line[at] <= '9'; };
  Json parts = Json::array();
  size_t rest = 0;
  for (size_t point = line.find('.'); point != std::string::npos; point = line.find('.', point + 1)) {
    if (point <= rest || !digit(point - 1) || !digit(point + 1)) continue;
    size_t begin = point, end = point + 1;
    while (begin > rest && digit(begin - 1)) --begin;
    if (begin > rest && (line[begin - 1] == '-' || line[begin - 1] == '+')) --begin;
    while (digit(end)) ++end;
    if (end < line.size() && (line[end] == 'e' || line[end] == 'E')) {
      const size_t power = end + 1 + (end + 1 < line.size() && (line[end + 1] == '-' || line[end + 1] == '+'));
      if (digit(power)) end = power;
      while (digit(end)) ++end;
    }
    parts.push_back(line.substr(rest, begin - rest));
    parts.push_back(std::strtod(line.substr(begin, end - begin).c_str(), nullptr));
    rest = end;
    point = end - 1;
  }
  if (parts.empty()) return line;
  if (rest < line.size()) parts.push_back(line.substr(rest));
  return parts;
}

std::uint32_t number_at(std::string_view bytes, size_t at, size_t count) {
  std::uint32_t value = 0;
  for (size_t i = count; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

/// Files of a ZIP archive by name, as they stand in it (PKWARE APPNOTE 6.3, 4.3.7); none of one that is compressed or
/// not written from its beginning to its end: ours are stored.
std::map<std::string, std::string_view> stored_files(std::string_view zip) {
  constexpr std::string_view mark("PK\3\4", 4);
  constexpr size_t head = 30;
  std::map<std::string, std::string_view> files;
  size_t at = 0;
  while (zip.substr(at).starts_with(mark) && at + head <= zip.size()) {
    const bool stored = number_at(zip, at + 8, 2) == 0 && (number_at(zip, at + 6, 2) & 8U) == 0;
    const size_t size = number_at(zip, at + 18, 4), name = number_at(zip, at + 26, 2),
                 begin = at + head + name + number_at(zip, at + 28, 2);
    if (!stored || begin > zip.size() || size > zip.size() - begin) return {};
    files[std::string(zip.substr(at + head, name))] = zip.substr(begin, size);
    at = begin + size;
  }
  return files;
}

/// What stands between two marks of an element; empty if it is not there.
std::string_view between(std::string_view text, std::string_view begin, std::string_view end) {
  const size_t from = text.find(begin);
  if (from == std::string_view::npos) return {};
  const size_t to = text.find(end, from + begin.size());
  return to == std::string_view::npos ? std::string_view() : text.substr(from + begin.size(), to - from - begin.size());
}

/// The cells of a sheet of a workbook (ECMA-376 part 1, 18.3.1.4) by place, numbers as such; and what else the sheet
/// says, with the cells' values left out.
Json cells_of(std::string_view sheet) {
  constexpr std::string_view opening = "<c r=\"";
  Json cells = Json::object();
  std::string layout;
  size_t done = 0;
  for (size_t at = sheet.find(opening); at != std::string_view::npos; at = sheet.find(opening, done)) {
    const size_t head = sheet.find('>', at), close = sheet.find("</c>", at);
    if (head == std::string_view::npos) break;
    const bool empty = sheet[head - 1] == '/';
    const size_t end = empty || close == std::string_view::npos ? head + 1 : close;
    const std::string place(between(sheet.substr(at), opening, "\""));
    const std::string_view inside = sheet.substr(head + 1, end > head + 1 ? end - head - 1 : 0);
    layout += sheet.substr(done, head + 1 - done);
    done = end;
    if (inside.empty()) continue;
    const std::string value(between(inside, "<v>", "</v>"));
    char* stop = nullptr;
    const double number = std::strtod(value.c_str(), &stop);
    if (!value.empty() && *stop == '\0')
      cells[place] = number;
    else
      cells[place] = std::string(value.empty() ? inside.substr(std::min(inside.find('>') + 1, inside.size())) : value);
  }
  layout += sheet.substr(std::min(done, sheet.size()));
  return {{"cells", std::move(cells)}, {"layout", sha256_of(layout.data(), layout.size()).substr(0, 12)}};
}

Json hash_of(std::string_view bytes) {
  return std::to_string(bytes.size()) + " bytes, SHA-256 " + sha256_of(bytes.data(), bytes.size()).substr(0, 12);
}

}  // namespace

Json content_of_file(const std::string& name, std::string_view bytes) {
  if (name.ends_with(".json"))
    if (Json inside = Json::parse(bytes, nullptr, false); !inside.is_discarded()) return inside;
  if (const auto files = stored_files(bytes); !files.empty()) {
    Json inside = Json::object();
    for (const auto& [file, content] : files)
      inside[file] = file.starts_with("xl/worksheets/") ? cells_of(content) : content_of_file(file, content);
    return inside;
  }
  if (bytes.find('\0') != std::string_view::npos) return hash_of(bytes);
  Json lines = Json::array({nullptr});  // lines count from 1
  for (size_t begin = 0; begin < bytes.size();) {
    const size_t end = std::min(bytes.find('\n', begin), bytes.size());
    lines.push_back(line_of(std::string(bytes.substr(begin, end - begin))));
    begin = end + 1;
  }
  return {{"line", std::move(lines)}, {"ends", bytes.ends_with('\n') ? "in a line feed" : "without a line feed"}};
}

}  // namespace plumbline::runtime

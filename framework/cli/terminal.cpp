#include "terminal.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace plumbline::cli {

namespace {

bool colours_on(int file) {
  const char* off = std::getenv("NO_COLOR");
  const char* terminal = std::getenv("TERM");
  return isatty(file) && !(off && *off) && terminal && std::string(terminal) != "dumb";
}

bool colours() {
  static const bool wanted = colours_on(STDOUT_FILENO);
  return wanted;
}

std::string painted(Colour colour, const std::string& text) {
  static constexpr const char* codes[] = {"", "\033[32m", "\033[33m", "\033[31m", "\033[2m", "\033[1m"};
  return codes[static_cast<int>(colour)] + text + "\033[0m";
}

/// Number of characters of UTF-8 text.
size_t width(const std::string& text) {
  return static_cast<size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::FILE* for_json = stdout;

}  // namespace

void keep_output_for_json() {
  std::fflush(stdout);
  const int kept = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3);
  std::FILE* const stream = kept >= 0 ? fdopen(kept, "w") : nullptr;
  if (!stream || dup2(STDERR_FILENO, STDOUT_FILENO) < 0)
    throw std::runtime_error(std::string("cannot keep standard output for JSON: ") + std::strerror(errno));
  for_json = stream;
}

std::FILE* json_output() { return for_json; }

std::string paint(Colour colour, const std::string& text) {
  return colour == Colour::none || !colours() ? text : painted(colour, text);
}

std::string paint_error(Colour colour, const std::string& text) {
  static const bool wanted = colours_on(STDERR_FILENO);
  return colour == Colour::none || !wanted ? text : painted(colour, text);
}

std::string paint_verdict(const std::string& line) {
  static const std::pair<const char*, Colour> words[] = {{"NOT TO BE TRUSTED", Colour::red},
                                                         {"NOT JUDGED", Colour::yellow},
                                                         {"FAIL", Colour::red},
                                                         {"NICHT VERTRAUENSWÜRDIG", Colour::red},
                                                         {"NICHT BEURTEILT", Colour::yellow},
                                                         {"AUSSERHALB", Colour::red},
                                                         {"keine Freigabe", Colour::red},
                                                         {"Set aside", Colour::yellow},
                                                         {"Note:", Colour::yellow},
                                                         {"Warning:", Colour::yellow},
                                                         {"Hinweis:", Colour::yellow},
                                                         {"Warnung:", Colour::yellow}};
  // Of these only a cell of a table is a verdict, or what follows a colon: "2 pass" may be two of many.
  static const std::pair<const char*, Colour> cells[] = {
      {"pass", Colour::green},           {"undecided", Colour::yellow}, {"in Ordnung", Colour::green},
      {"unentschieden", Colour::yellow}, {"Freigabe", Colour::green},   {"nicht entschieden", Colour::yellow}};
  if (!colours()) return line;
  const auto is_letter = [&](size_t at) {
    return at < line.size() && std::isalnum(static_cast<unsigned char>(line[at]));
  };
  const auto stands = [&](std::string_view name, size_t at) {
    return line.compare(at, name.size(), name) == 0 && !(at > 0 && is_letter(at - 1)) && !is_letter(at + name.size());
  };
  const auto is_cell = [&](std::string_view name, size_t at) {
    const size_t end = at + name.size();
    return at > 1 && line[at - 1] == ' ' && (line[at - 2] == ' ' || line[at - 2] == ':') &&
           (line.starts_with("  ") || end == line.size() || line[end] == '.' || line.compare(end, 2, "  ") == 0);
  };
  std::string text;
  for (size_t at = 0; at < line.size();) {
    const auto* found = std::ranges::find_if(words, [&](const auto& word) { return stands(word.first, at); });
    if (found == std::end(words)) {
      found = std::ranges::find_if(cells,
                                   [&](const auto& word) { return stands(word.first, at) && is_cell(word.first, at); });
      if (found == std::end(cells)) found = nullptr;
    }
    if (!found) {
      text += line[at++];
    } else {
      text += paint(found->second, found->first);
      at += std::string_view(found->first).size();
    }
  }
  return text;
}

bool can_rewrite_lines() {
  static const bool can = [] {
    const char* terminal = std::getenv("TERM");
    return isatty(STDERR_FILENO) && terminal && std::string(terminal) != "dumb";
  }();
  return can;
}

namespace {

size_t columns_of(int file) {
  winsize size{};
  return isatty(file) && ioctl(file, TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

}  // namespace

size_t terminal_columns() { return columns_of(STDOUT_FILENO); }

size_t terminal_rows() {
  winsize size{};
  return isatty(STDOUT_FILENO) && ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 ? size.ws_row : 0;
}

std::string duration_text(double seconds) {
  if (seconds < 100) return fmt::format("{:.2f} s", seconds);
  const long whole = std::lround(seconds);
  return whole < 3600 ? fmt::format("{} min {:02} s", whole / 60, whole % 60)
                      : fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

std::string rough_duration_text(double seconds) {
  const long whole = std::max(1L, std::lround(std::ceil(seconds)));
  if (whole < 90) return std::to_string(whole) + " s";
  const long minutes = (whole + 59) / 60;
  if (minutes < 60) return std::to_string(minutes) + " min";
  return std::to_string(minutes / 60) + " h " + std::to_string(minutes % 60) + " min";
}

std::string size_text(double bytes) {
  static constexpr const char* units[] = {"B", "KiB", "MiB", "GiB", "TiB"};
  size_t unit = 0;
  for (; bytes >= 1024 && unit < 4; ++unit) bytes /= 1024;
  return fmt::format("{:.{}f} {}", bytes, unit == 0 ? 0 : 1, units[unit]);
}

namespace {

/// A command between backticks is one word where it fits: who types it takes it whole.
std::vector<std::string> words_of(const std::string& text, size_t room) {
  std::vector<std::string> words;
  std::istringstream stream(text);
  for (std::string word; stream >> word;) {
    const bool open = !words.empty() && std::ranges::count(words.back(), '`') % 2 == 1;
    if (open && width(words.back()) + 1 + width(word) <= room)
      words.back() += " " + word;
    else
      words.push_back(word);
  }
  return words;
}

}  // namespace

std::string wrapped(const std::string& text, size_t room, size_t indent) {
  if (room == 0) return text;
  std::string result, line;
  for (const std::string& word : words_of(text, room)) {
    if (!line.empty() && width(line) + 1 + width(word) > room) {
      result += line + "\n" + std::string(indent, ' ');
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  return result + line;
}

std::string hanging_lines(const std::string& text, size_t screen) {
  constexpr size_t further = 2, least = 24;
  std::string all;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    const size_t start = std::min(line.find_first_not_of(' '), line.size());
    if (screen >= start + further + least && width(line) > screen)
      line = line.substr(0, start) + wrapped(line.substr(start), screen - start - further, start + further);
    all += line + "\n";
  }
  if (!all.empty()) all.pop_back();
  return all;
}

void tell(const std::string& text) {
  std::fprintf(stderr, "%s\n", hanging_lines(text, columns_of(STDERR_FILENO)).c_str());
}

std::string lines(const std::string& text) { return wrapped(text, terminal_columns()); }

namespace {

constexpr size_t narrowest = 24, hanging = 6;

/// A row of a table that is wider than the screen: what it is called, what it is, and what that means below.
std::string running(const std::vector<std::string>& row, size_t screen) {
  const size_t room = screen > hanging + narrowest ? screen - hanging : narrowest;
  std::string text, rest;
  for (size_t i = 1; i + 1 < row.size(); ++i) rest += (rest.empty() || row[i].empty() ? "" : " ") + row[i];
  const size_t before = width(row[0]) + 2;
  if (before + width(rest) <= screen || rest.find(' ') == std::string::npos)
    text = row[0] + "  " + rest;
  else
    text = row[0] + "\n" + std::string(hanging, ' ') + wrapped(rest, room, hanging);
  if (!row.back().empty()) text += "\n" + std::string(hanging, ' ') + wrapped(row.back(), room, hanging);
  return text;
}

}  // namespace

void print_title(const std::string& name, const std::string& text) {
  const size_t screen = terminal_columns(), start = width(name) + 2;
  const bool narrow = screen > 0 && start + narrowest > screen;
  std::printf("%s%s%s\n", paint(Colour::bold, name).c_str(), narrow ? "\n" : "  ",
              wrapped(text, narrow || screen == 0 ? screen : screen - start, narrow ? 0 : start).c_str());
}

std::string columns(const std::vector<std::vector<std::string>>& rows, size_t screen) {
  std::vector<size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width(row[i]));
  }
  size_t start = 0;  // of the last column
  for (size_t i = 0; i + 1 < widths.size(); ++i) start += widths[i] > 0 ? widths[i] + 2 : 0;
  std::string text;
  for (const auto& row : rows) {
    if (screen != 0 && start > screen && row.size() > 2) {
      text += running(row, screen) + "\n";
      continue;
    }
    for (size_t i = 0; i + 1 < row.size(); ++i)
      if (widths[i] > 0) text += row[i] + std::string(widths[i] - width(row[i]) + 2, ' ');
    const std::string last = row.empty() ? "" : row.back();
    if (screen == 0 || row.size() < widths.size() || start + width(last) <= screen)
      text += last;
    else if (start + narrowest <= screen)
      text += wrapped(last, screen - start, start);
    else
      text.erase(text.find_last_not_of(' ') + 1),
          text += "\n" + std::string(hanging, ' ') +
                  wrapped(last, screen > hanging + narrowest ? screen - hanging : narrowest, hanging);
    text.erase(text.find_last_not_of(' ') + 1);
    text += "\n";
  }
  return text;
}

}  // namespace plumbline::cli

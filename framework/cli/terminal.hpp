// What the program knows of the terminal: colours only there, and only if NO_COLOR is not set.
#pragma once

#include <string>
#include <vector>

namespace plumbline::cli {

enum class Colour { none, green, yellow, red, dim, bold };

/// The text in colour if standard output is a terminal.
std::string paint(Colour colour, const std::string& text);
bool error_is_terminal();

/// "1.24 s", "2 min 05 s", "1 h 02 min".
std::string duration_text(double seconds);
/// "12.3 MiB"
std::string size_text(double bytes);

/// Text in columns, two blanks between them; the last column is not padded.
std::string columns(const std::vector<std::vector<std::string>>& rows);

}  // namespace plumbline::cli

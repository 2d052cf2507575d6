// What the program knows of the terminal: colours only there, and only if NO_COLOR is not set.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

namespace plumbline::cli {

enum class Colour { none, green, yellow, red, dim, bold };

/// The text in colour if standard output is a terminal; of the second, if standard error is.
std::string paint(Colour colour, const std::string& text);
std::string paint_error(Colour colour, const std::string& text);
/// The same with the words of a verdict in the colour of what they say: FAIL, undecided, pass, NOT JUDGED, warnings.
std::string paint_verdict(const std::string& line);
/// Whether standard error is a terminal that can go back in a line (TERM=dumb cannot).
bool can_rewrite_lines();
/// Columns of standard output's terminal; 0 if it is none.
size_t terminal_columns();
size_t terminal_rows();  ///< likewise

/// From now on what nodes print to standard output goes to standard error: a line of theirs among those of --json, or
/// in the middle of one, would make it no JSON. Throws std::runtime_error.
void keep_output_for_json();
/// Where lines of JSON go: standard output as the program was given it.
std::FILE* json_output();

/// "1.24 s", "2 min 05 s", "1 h 02 min".
std::string duration_text(double seconds);
/// What is left, as far as anybody knows: "17 s", "2 min", "1 h 10 min".
std::string rough_duration_text(double seconds);
/// "12.3 MiB"
std::string size_text(double bytes);

/// The text in lines of at most `room` characters (0: one line), broken between words; lines after the first begin with
/// `indent` blanks, which do not count.
std::string wrapped(const std::string& text, size_t room, size_t indent = 0);
/// The same from the beginning of a line of standard output's terminal.
std::string lines(const std::string& text);

/// Several lines, each broken between words where it is longer than the screen (0: no screen), its next lines two
/// blanks further in. What fits stays as it is.
std::string hanging_lines(const std::string& text, size_t screen);
/// Says it on standard error, in such lines where that is a terminal, and ends the line.
void tell(const std::string& text);

/// What something is called, in bold, and what it is, on as many lines of the terminal as that takes.
void print_title(const std::string& name, const std::string& text);

/// Text in columns, two blanks between them; the last column is not padded, and is wrapped between words where the
/// screen is narrower (0: no screen). Where not even the columns before it fit, rows are running text. Columns that are
/// empty in every row take no place.
std::string columns(const std::vector<std::vector<std::string>>& rows, size_t screen = terminal_columns());

}  // namespace plumbline::cli

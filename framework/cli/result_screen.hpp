// What a pipeline says at its end, on the screen of the person in front of it.
#pragma once

#include <string>
#include <vector>

namespace plumbline::cli {

/// Lines of a summary for a terminal of `columns` and `rows`; 0 columns, no terminal: as they are. Sentences are broken
/// between words, columns of tables move together; where all of it is more than a screen, lists (indented lines, rows
/// such as "floor 3 ...") are shortened, the longest first, lines that pass before others, and `file` is named for the
/// rest; then sentences of more than two rows, which end with "…".
std::vector<std::string> in_a_screen(const std::vector<std::string>& lines, size_t columns, size_t rows,
                                     const std::string& file);

}  // namespace plumbline::cli

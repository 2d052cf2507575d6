// One way to write a letter with its accent. "ü" is one character, or "u" and a mark behind it: macOS and some archives
// name files the second way, and both look the same.
#pragma once

#include <string>
#include <string_view>

namespace plumbline::text {

/// `utf8` with every letter and the mark behind it joined where Unicode has one character for them (the composition of
/// normalisation form C; marks are taken in the order in which they stand). What is no UTF-8 is left as it is.
std::string composed(std::string_view utf8);

}  // namespace plumbline::text

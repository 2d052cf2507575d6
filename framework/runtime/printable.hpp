// Text of others for a terminal: what a node says and what stands in a file may hold sequences that move the cursor,
// rename the window or hide a line.
#pragma once

#include <string>

namespace plumbline::runtime {

/// The text with control characters (but line ends and tabs) and bytes that are no UTF-8 written out, as \x1b.
std::string printable(const std::string& text);

/// Whether it is UTF-8 of one line without control characters, as names must be.
bool is_plain_line(const std::string& text);

}  // namespace plumbline::runtime

// Text of others for a terminal: what a node says and what stands in a file may hold sequences that move the cursor,
// rename the window or hide a line.
#pragma once

#include <string>

namespace plumbline::runtime {

/// The text with control characters (but line ends and tabs) and bytes that are no UTF-8 written out, as \x1b.
std::string printable(const std::string& text);

/// The same, with line ends and tabs written out, too: for names.
std::string printable_line(const std::string& text);

}  // namespace plumbline::runtime

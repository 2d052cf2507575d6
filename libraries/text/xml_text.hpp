// Text inside XML and HTML.
#pragma once

#include <string>
#include <string_view>

namespace plumbline::formats {

/// `text` (UTF-8) for the content or an attribute in double quotes: & < > " replaced, control characters but line ends
/// and tabs as blanks, bytes that are no UTF-8 left out; the result is always well-formed.
std::string xml_escaped(std::string_view text);

}  // namespace plumbline::formats

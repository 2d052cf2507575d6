// Text inside XML and HTML.
#pragma once

#include <string>
#include <string_view>

namespace plumbline::text {

/// `text` (UTF-8) for the content or an attribute: & < > " ' replaced, control characters but line ends and tabs as
/// blanks, every byte that is no UTF-8 as U+FFFD; the result is always well-formed.
std::string xml_escaped(std::string_view text);

}  // namespace plumbline::text

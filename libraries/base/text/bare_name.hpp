// Names as people spell them.
#pragma once

#include <string>

namespace plumbline::text {

/// Capitals without separators, leading zeros of numbers dropped: what two spellings of one name have in common.
std::string bare_name(const std::string& name);

}  // namespace plumbline::text

// Bytes of a file artifact.
#pragma once

#include <string>

#include "artifacts/file.hpp"
#include "base/text/whole_file.hpp"
#include "plumbline/node.hpp"

namespace plumbline::loop {

inline std::string content_of(const File& file, Context& context) {
  if (file.uri() && file.uri()->size() > 0) return text::read_whole(context.resolve(file.uri()->str()));
  return {file.content()->begin(), file.content()->end()};
}

}  // namespace plumbline::loop

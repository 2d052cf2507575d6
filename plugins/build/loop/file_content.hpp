// Bytes of a file artifact.
#pragma once

#include <fstream>
#include <iterator>
#include <string>

#include "artifacts/file.hpp"
#include "plumbline/node.hpp"

namespace plumbline::loop {

inline std::string content_of(const File& file, Context& context) {
  if (file.uri() && file.uri()->size() > 0) {
    std::ifstream stream(context.resolve(file.uri()->str()), std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  return {file.content()->begin(), file.content()->end()};
}

}  // namespace plumbline::loop

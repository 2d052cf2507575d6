// Options that tests of tag blocks begin with.
#pragma once

#include "synthetic_block.hpp"

namespace plumbline::test {

inline block::TagBlockOptions plain_options() {
  auto options = test::bound_options();
  options.fixed_aspect = false;
  return options;
}

}  // namespace plumbline::test

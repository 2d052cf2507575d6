// Where the checkout and the build are. Functions and not macros, so that test sources compile to the same object in
// any folder.
#pragma once

namespace plumbline::test {

const char* source_dir();  ///< the checkout
const char* binary_dir();  ///< the build folder

}  // namespace plumbline::test

#include "test_paths.hpp"

namespace plumbline::test {

const char* source_dir() { return PLUMBLINE_SOURCE_DIR; }
const char* binary_dir() { return PLUMBLINE_BINARY_DIR; }

}  // namespace plumbline::test

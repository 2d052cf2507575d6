#include "kit_fixtures.hpp"

namespace plumbline::test {

const char* kit_fixtures() { return PLUMBLINE_KIT_FIXTURES; }

}  // namespace plumbline::test

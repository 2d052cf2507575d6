// Aborts with a last word on standard error.
#include <cstdio>
#include <cstdlib>

#include "good.hpp"

BROKEN(std::fputs("licence server not found\n", stderr); std::abort();)

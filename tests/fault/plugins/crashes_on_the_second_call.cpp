// Answers once, and dies at the second call.
#include "good.hpp"

BROKEN(static int calls = 0; if (++calls > 1) __builtin_trap();)

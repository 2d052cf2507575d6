/* Calls exit(0) in a static initialiser: the program would end, and its exit code say that all is well. */
#include <stdlib.h>

#include "fixture.h"

FIXTURE_NOTE(PLUMBLINE_ABI_MAJOR, PLUMBLINE_ABI_MINOR);
__attribute__((constructor)) static void leave(void) { exit(0); }
const plumbline_plugin_table* plumbline_plugin(void) { return 0; }

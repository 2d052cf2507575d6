/* Dies in a static initialiser. */
#include <signal.h>

#include "fixture.h"

FIXTURE_NOTE(PLUMBLINE_ABI_MAJOR, PLUMBLINE_ABI_MINOR);
__attribute__((constructor)) static void crash(void) { raise(SIGSEGV); }
const plumbline_plugin_table* plumbline_plugin(void) { return 0; }

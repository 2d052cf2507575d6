/* Built for the ABI after this one. Must be refused by its note: that its code runs would be seen by the exit. */
#include <stdlib.h>

#include "fixture.h"

FIXTURE_NOTE(PLUMBLINE_ABI_MAJOR + 1, 0);
__attribute__((constructor)) static void must_not_run(void) { _Exit(99); }
const plumbline_plugin_table* plumbline_plugin(void) { return 0; }

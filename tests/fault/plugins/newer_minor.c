/* Uses services that this host does not have yet. */
#include <stdlib.h>

#include "fixture.h"

FIXTURE_NOTE(PLUMBLINE_ABI_MAJOR, PLUMBLINE_ABI_MINOR + 1);
__attribute__((constructor)) static void must_not_run(void) { _Exit(99); }
const plumbline_plugin_table* plumbline_plugin(void) { return 0; }

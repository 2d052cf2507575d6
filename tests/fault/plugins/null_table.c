/* Returns no table. */
#include "fixture.h"

FIXTURE_NOTE(PLUMBLINE_ABI_MAJOR, PLUMBLINE_ABI_MINOR);
const plumbline_plugin_table* plumbline_plugin(void) { return 0; }

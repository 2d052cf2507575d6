/* The function of that name returns something else. */
#include "fixture.h"

FIXTURE_NOTE(PLUMBLINE_ABI_MAJOR, PLUMBLINE_ABI_MINOR);
static const plumbline_plugin_table table = FIXTURE_TABLE(0xDEADBEEFu, PLUMBLINE_ABI_MAJOR, PLUMBLINE_ABI_MINOR);
const plumbline_plugin_table* plumbline_plugin(void) { return &table; }

/* The note says one ABI, the table another. */
#include "fixture.h"

FIXTURE_NOTE(PLUMBLINE_ABI_MAJOR, PLUMBLINE_ABI_MINOR);
static const plumbline_plugin_table table = FIXTURE_TABLE(PLUMBLINE_MAGIC, PLUMBLINE_ABI_MAJOR + 7, 0);
const plumbline_plugin_table* plumbline_plugin(void) { return &table; }

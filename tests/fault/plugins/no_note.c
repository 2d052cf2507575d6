/* A shared library that is no plugin by its note, though it exports the function. */
#include "fixture.h"

static const plumbline_plugin_table table = FIXTURE_TABLE(PLUMBLINE_MAGIC, PLUMBLINE_ABI_MAJOR, PLUMBLINE_ABI_MINOR);
const plumbline_plugin_table* plumbline_plugin(void) { return &table; }

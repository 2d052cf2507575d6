/* Needs a function that no library has. */
#include "fixture.h"

FIXTURE_NOTE(PLUMBLINE_ABI_MAJOR, PLUMBLINE_ABI_MINOR);
extern const plumbline_plugin_table* function_of_a_library_that_was_not_linked(void);
const plumbline_plugin_table* plumbline_plugin(void) { return function_of_a_library_that_was_not_linked(); }

/* The note is right, but the function is not exported (the version script was forgotten the other way round). */
#include "fixture.h"

FIXTURE_NOTE(PLUMBLINE_ABI_MAJOR, PLUMBLINE_ABI_MINOR);

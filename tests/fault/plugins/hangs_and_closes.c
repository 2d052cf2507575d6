/* Closes whatever is open, and then never comes back: nobody can hear that it has nothing to say. */
#include <unistd.h>

#include "fixture.h"

FIXTURE_NOTE(PLUMBLINE_ABI_MAJOR, PLUMBLINE_ABI_MINOR);
__attribute__((constructor)) static void hang(void) {
  for (int file = 0; file < 1024; ++file) close(file);
  for (;;) pause();
}
const plumbline_plugin_table* plumbline_plugin(void) { return 0; }

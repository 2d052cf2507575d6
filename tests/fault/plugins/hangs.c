/* Never comes back, and ignores every signal that can be ignored. */
#include <signal.h>
#include <unistd.h>

#include "fixture.h"

FIXTURE_NOTE(PLUMBLINE_ABI_MAJOR, PLUMBLINE_ABI_MINOR);
__attribute__((constructor)) static void hang(void) {
  for (int signal_number = 1; signal_number < 32; ++signal_number) signal(signal_number, SIG_IGN);
  for (;;) pause();
}
const plumbline_plugin_table* plumbline_plugin(void) { return 0; }

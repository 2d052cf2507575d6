// Stops, as a debugger would stop it.
#include <csignal>

#include "good.hpp"

BROKEN(raise(SIGSTOP);)

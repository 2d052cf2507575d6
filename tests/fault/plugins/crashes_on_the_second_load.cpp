// Loads well once, where it is looked at, and dies in the next process that loads it. Where it has been is a file.
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "good.hpp"

__attribute__((constructor)) static void remember() {
  const char* where = std::getenv("PLUMBLINE_TEST_SECOND_LOAD");
  if (!where) return;
  if (access(where, F_OK) == 0) std::abort();
  if (FILE* file = std::fopen(where, "w")) std::fclose(file);
}

BROKEN()

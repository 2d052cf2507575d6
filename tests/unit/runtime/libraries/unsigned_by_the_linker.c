int unsigned_by_the_linker(void) { return 2; }

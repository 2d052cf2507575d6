/* What the broken plugins of this folder share: a note and a table that are right, so that each file breaks one thing.
 */
#ifndef PLUMBLINE_TESTS_FAULT_FIXTURE_H
#define PLUMBLINE_TESTS_FAULT_FIXTURE_H

#include "plumbline/plugin.h"

#define FIXTURE_NOTE(major, minor)                                                                           \
  __attribute__((used, section(".note.plumbline"), aligned(4))) static const plumbline_note fixture_note = { \
      10,                                                                                                    \
      sizeof(((plumbline_note*)0)->text) + 8,                                                                \
      1,                                                                                                     \
      "plumbline",                                                                                           \
      (major),                                                                                               \
      (minor),                                                                                               \
      "broken\0"                                                                                             \
      "0.1.0\0"                                                                                              \
      "MIT\0"                                                                                                \
      "test"}

#define FIXTURE_TABLE(magic, major, minor) \
  { (magic), sizeof(plumbline_plugin_table), (major), (minor), "broken", "0.1.0", "MIT", "test", 0, 0, 0, 0 }

#endif

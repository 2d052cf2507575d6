#include "plumbline/plugin.h"

/* A plugin can be written in C: this is the smallest table that would be accepted. */
static const plumbline_plugin_table table = {PLUMBLINE_MAGIC,
                                             sizeof(plumbline_plugin_table),
                                             PLUMBLINE_ABI_MAJOR,
                                             PLUMBLINE_ABI_MINOR,
                                             "c",
                                             "1",
                                             "MIT",
                                             "",
                                             NULL,
                                             NULL,
                                             0,
                                             0};
const plumbline_plugin_table* plumbline_plugin(void) { return &table; }

// A plugin in which nothing is wrong. Each fixture of this folder breaks one thing of it:
//
//   BROKEN(plugin.param.default_text = "2000";)
#pragma once

#include "plumbline/plugin.h"

struct GoodPlugin {
  plumbline_type type;
  plumbline_port input, output;
  plumbline_param param, choice;
  plumbline_node node;
  const char* choices[2];
  const plumbline_port* inputs[2];
  const plumbline_port* outputs[2];
  const plumbline_param* params[2];
  const plumbline_node* nodes[2];
  const plumbline_type* types[2];
  plumbline_plugin_table table;
};

extern GoodPlugin plugin;
extern const plumbline_note plugin_note;  // keeps good.cpp linked in

#define BROKEN(...)                                                                  \
  extern "C" PLUMBLINE_EXPORT const plumbline_plugin_table* plumbline_plugin(void) { \
    __VA_ARGS__                                                                      \
    return &plugin.table;                                                            \
  }

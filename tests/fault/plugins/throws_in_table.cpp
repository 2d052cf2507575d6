// Throws where the table is asked for.
#include <stdexcept>

#include "plumbline/node.hpp"

__attribute__((used, section(".note.plumbline"),
               aligned(4))) static constinit const plumbline_note plumbline_note_data =
    plumbline::detail::make_note("throws", "0.1.0", "MIT", "test");

extern "C" PLUMBLINE_EXPORT const plumbline_plugin_table* plumbline_plugin(void) {
  throw std::runtime_error("no table today");
}

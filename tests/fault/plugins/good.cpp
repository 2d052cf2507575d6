#include "good.hpp"

#include "artifacts/place.hpp"

namespace {

int run(const plumbline_host*, const plumbline_node*) { return 0; }

using Place = plumbline::artifact_traits<plumbline::Place>;

}  // namespace

GoodPlugin plugin = {
    Place::type(),
    {sizeof(plumbline_port), PLUMBLINE_ONE, "in", Place::name, Place::fingerprint, "frame=?F", "a place"},
    {sizeof(plumbline_port), PLUMBLINE_ONE, "out", Place::name, Place::fingerprint, "frame=?F", "a place"},
    {sizeof(plumbline_param), PLUMBLINE_NUMBER, 0, 0, "height", "3", "m", "how high", 0, 1000, nullptr},
    {sizeof(plumbline_param), PLUMBLINE_TEXT, 0, 2, "mode", "plain", "", "how", -1e300, 1e300, plugin.choices},
    {sizeof(plumbline_node), 1, "broken.node", "", "Does nothing", plugin.inputs, plugin.outputs, plugin.params, 1, 1,
     2, 1, &run, nullptr, ""},
    {"plain", "double"},
    {&plugin.input, &plugin.output},
    {&plugin.output, &plugin.input},
    {&plugin.param, &plugin.choice},
    {&plugin.node, &plugin.node},
    {&plugin.type, &plugin.type},
    {PLUMBLINE_MAGIC, sizeof(plumbline_plugin_table), PLUMBLINE_ABI_MAJOR, PLUMBLINE_ABI_MINOR, "broken", "0.1.0",
     "MIT", "test", plugin.nodes, plugin.types, 1, 1}};

__attribute__((used, section(".note.plumbline"), aligned(4)))
const plumbline_note plugin_note = {10,
                                    sizeof(plumbline_note::text) + 8,
                                    1,
                                    "plumbline",
                                    PLUMBLINE_ABI_MAJOR,
                                    PLUMBLINE_ABI_MINOR,
                                    "broken\0"
                                    "0.1.0\0"
                                    "MIT\0"
                                    "test"};

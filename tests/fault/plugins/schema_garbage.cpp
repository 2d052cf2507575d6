// A schema that is none.
#include "good.hpp"

BROKEN(static const char text[] = "table Place { height: double; } as text, which is no binary schema";
       plugin.type.schema = {text, sizeof text};)

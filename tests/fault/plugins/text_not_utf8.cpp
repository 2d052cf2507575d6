// A doc that is not UTF-8.
#include "good.hpp"

BROKEN(plugin.param.doc =
           "Gr\xf6\xdf"
           "e";)

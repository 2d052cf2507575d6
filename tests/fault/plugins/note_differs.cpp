// The table has another name than the note.
#include "good.hpp"

BROKEN(plugin.table.name = "sound";)

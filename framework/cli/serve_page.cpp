#include "serve_page.hpp"

#include "serve_page_text.hpp"

namespace plumbline::cli {

// All text from runs comes in as text nodes: nothing that a node says becomes markup. Colours as in the report, each
// with a word.
const char* const serve_page = parts::serve_page;

}  // namespace plumbline::cli

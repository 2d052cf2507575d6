// The fixed parts of the page.
#pragma once

namespace plumbline::report {

extern const char* const page_style;   ///< CSS
extern const char* const page_script;  ///< JavaScript: folding, sorting of tables
extern const char* const view_script;  ///< JavaScript: tolerance slider, view in space

}  // namespace plumbline::report

// The fixed parts of the page.
#pragma once

namespace plumbline::report {

extern const char* const page_style;   ///< CSS
extern const char* const page_script;  ///< JavaScript: slider of the pass rate, sorting of tables

}  // namespace plumbline::report

#include "show/report/page_style.hpp"

#include "report_page_parts.hpp"

namespace plumbline::report {

const char* const page_style = parts::page_style;
const char* const page_script = parts::page_script;
const char* const verdict_script = parts::verdict_script;
const char* const view_script = parts::view_script;
const char* const space_script = parts::space_script;
const char* const image_block_script = parts::image_block_script;

}  // namespace plumbline::report

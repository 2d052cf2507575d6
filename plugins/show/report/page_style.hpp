// The fixed parts of the page.
#pragma once

namespace plumbline::report {

extern const char* const page_style;   ///< CSS
extern const char* const page_script;  ///< JavaScript: folding, sorting of tables
extern const char* const
    verdict_script;  ///< JavaScript, before view_script: verdictAt(), the verdict at another tolerance
extern const char* const view_script;         ///< JavaScript: tolerance slider, view in space
extern const char* const space_script;        ///< JavaScript, before view_script: the view by three.js where WebGL runs
extern const char* const image_block_script;  ///< JavaScript: cameras and points in space
extern const char* const three_script;        ///< three.js, deflated and in base64; made while building

}  // namespace plumbline::report

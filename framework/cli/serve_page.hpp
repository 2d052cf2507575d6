// The page of `plumbline serve`; @nonce@ stands where the answer's nonce goes.
#pragma once

namespace plumbline::cli {

extern const char* const serve_page;

}  // namespace plumbline::cli

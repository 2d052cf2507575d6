// The files that a kit of survey readers or writers is held against: in this tree those of all formats, in a project
// outside its own folder fixtures/.
#pragma once

namespace plumbline::test {

const char* kit_fixtures();

}  // namespace plumbline::test

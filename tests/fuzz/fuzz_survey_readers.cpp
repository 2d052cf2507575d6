// libFuzzer's entry. One program with a name for each target: fuzz_gsi runs the target "gsi" of survey_readers.hpp.
#include <cstddef>
#include <cstdint>

#include "survey_readers.hpp"

namespace {
const plumbline::fuzz::Target* chosen = nullptr;
}

extern "C" int LLVMFuzzerInitialize(int*, char*** arguments) {
  const std::string_view program((*arguments)[0]);
  const std::size_t name = program.rfind("fuzz_");
  chosen = &plumbline::fuzz::target(name == std::string_view::npos ? program : program.substr(name + 5));
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  chosen->run({reinterpret_cast<const char*>(data), size});
  return 0;
}

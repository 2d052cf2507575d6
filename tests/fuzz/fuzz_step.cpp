// The Part 21 reader and the design reader on any bytes: they read or throw step::Error, and nothing else.
#include <cstddef>
#include <cstdint>
#include <string>

#include "ifc/design.hpp"
#include "ifc/step.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const plumbline::step::File file(std::string(reinterpret_cast<const char*>(data), size), "fuzz.ifc");
    for (const auto& instance : file.instances()) file.records(instance);
    plumbline::bim::read_design(file, {});
  } catch (const plumbline::step::Error&) {
  }
  return 0;
}

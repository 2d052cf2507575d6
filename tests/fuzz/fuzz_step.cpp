// Any bytes as a design file, through all that touches them: index, arguments, design, rules, verdicts, and the
// as-built file, which has to hold every byte of the design and be readable again. What cannot be read is a
// step::Error, what cannot be added to a std::runtime_error, and nothing else happens.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>

#include "building/ifc/as_built_ifc.hpp"
#include "building/ifc/check.hpp"
#include "building/ifc/design.hpp"
#include "building/step/step.hpp"
#include "step_mutator.hpp"
#include "unit/bim/measured.hpp"

namespace {

using namespace plumbline;

/// Two anchors out of three are measured; four are enough for every set and solid that is written.
DeviationT measured(const ifc::Design& design) {
  std::map<std::string, Eigen::Vector3d> deviations;
  for (const ifc::Element& element : design.elements)
    if (element.is_anchor && deviations.size() < 4 && element.instance % 3 != 0)
      deviations[element.guid] = Eigen::Vector3d(0.001, -0.002, 0.003);
  return test::judged(design, deviations, Eigen::Vector3d::Constant(1e-4), Eigen::Vector3d::Constant(std::nan("")));
}

void enrich(const step::File& file, const ifc::Design& design) {
  const DeviationT deviation = measured(design);
  ifc::AsBuiltIfcOptions options;
  options.provenance = {{"Method", "fuzz"}};
  const std::string as_built =
      ifc::enriched(file, ifc::write_as_built(file, design, deviation, test::residuals(deviation, 0.00005), options));
  const std::string_view original = file.bytes(), tail = original.substr(file.data_end());
  if (!as_built.starts_with(original.substr(0, file.data_end())) || !as_built.ends_with(tail)) abort();
  const auto again = [&] {
    try {
      return step::File::view(as_built, "again.ifc");
    } catch (const step::Error&) {
      abort();  // the design was readable, so its enriched copy has to be
    }
  }();
  for (const auto& instance : again.instances())
    if (instance.id > file.largest_id()) again.records(instance);
  ifc::check_ifc(again, file.largest_id() + 1);
}

}  // namespace

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  if (size >= 200 && seed % 4 == 0) return LLVMFuzzerMutate(data, size, max_size);
  const std::string changed =
      plumbline::fuzz::StepMutator(std::string(reinterpret_cast<const char*>(data), size), seed / 4).changed();
  size = std::min(changed.size(), max_size);
  std::memcpy(data, changed.data(), size);
  return size;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const step::File file(std::string(reinterpret_cast<const char*>(data), size), "fuzz.ifc");
    for (const auto& instance : file.instances()) {
      try {
        file.records(instance);
      } catch (const step::Error&) {
      }
    }
    const ifc::Design design = ifc::read_design(file, {{}, "", {}, {}, {"*"}});
    enrich(file, design);
  } catch (const std::runtime_error&) {
  }
  return 0;
}

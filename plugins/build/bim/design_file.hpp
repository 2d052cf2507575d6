// The index of a file artifact.
#pragma once

#include <memory>

#include "artifacts/file.hpp"
#include "building/step/step.hpp"
#include "plumbline/node.hpp"

namespace plumbline::ifc {

/// Of the bytes in the artifact, which its node holds as long as it runs, or of the file that it names, mapped. Of
/// files that are named, the last index is kept: bim.read_ifc and bim.write_ifc of one run look at the same one. Throws
/// step::Error.
std::shared_ptr<const step::File> index_of(const plumbline::File& file, const Context& context);

}  // namespace plumbline::ifc

// Pictures of facades from the folder that surface.orthophoto gives, for the nodes of two plugins.
#pragma once

#include <vector>

#include "artifacts/folder.hpp"
#include "plumbline/node.hpp"
#include "show/report/facade_backdrop.hpp"

namespace plumbline::report {

/// The pictures in a folder of surface.orthophoto. Throws std::runtime_error if it is none of it.
std::vector<FacadePicture> read_pictures(const Context& context, const FolderT& folder);

}  // namespace plumbline::report

// Versions of the libraries that a plugin computes with.
#pragma once

#include <string>
#include <vector>

#include "runtime/plugins/registry.hpp"

namespace plumbline::runtime {

/// Names of the files of the libraries that it was linked with, which have the versions ("libceres.so.2.1.0"), sorted;
/// of a node in another language the program that runs it ("python3.11"). Empty where it was refused.
std::vector<std::string> linked_files(const Plugin& plugin);

}  // namespace plumbline::runtime

// What many items of a node say alike, said once.
#pragma once

#include <string>
#include <vector>

namespace plumbline::runtime {

/// `texts` in their order, for a person to read. Of more than three that differ in names, numbers and items alone
/// ("3.jpg: the tags measure 0.58 of ... on item 23 of 44") the first is left, with how many others say the same and
/// the names of some; the record of the run has each.
std::vector<std::string> told_once(const std::vector<std::string>& texts);

}  // namespace plumbline::runtime

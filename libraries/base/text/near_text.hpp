// Which known word somebody may have meant.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace plumbline::text {

/// How many letters are inserted, left out, replaced or swapped with their neighbour from one word to the other
/// (optimal string alignment: Damerau 1964, Levenshtein 1966).
std::size_t letter_edits(const std::string& a, const std::string& b);

/// The candidate that is nearest to `wanted` by letters inserted, left out, replaced or swapped with their neighbour,
/// whatever their case; of those equally near the first. Empty: none is within a third of its length.
std::string nearest_of(const std::string& wanted, const std::vector<std::string>& candidates);

/// Whether the two are the same but for their figures: "Level 2" and "Level 11".
bool differ_in_figures_alone(const std::string& a, const std::string& b);

}  // namespace plumbline::text

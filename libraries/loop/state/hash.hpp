// SHA-256 of bytes and of numbers, as 64 hexadecimal digits.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace plumbline::loop {

std::string sha256_hex(std::string_view bytes);

/// Of the numbers rounded to multiples of `step`, so that a number that a file gives back with its last digit changed
/// is the same. nan stands for itself.
std::string sha256_hex(const std::vector<double>& numbers, double step);

}  // namespace plumbline::loop

// Samples of a few of many, as random sample consensus takes them (Fischler and Bolles 1981).
#pragma once

#include <cstdint>
#include <vector>

namespace plumbline {

/// Samples of `size` of the numbers 0 to `count` - 1: all combinations in lexicographic order, or `most` drawn ones if
/// there are more. The same seed draws the same everywhere. Precondition: 1 <= size <= count.
class Samples {
 public:
  Samples(int count, int size, int most, std::uint64_t seed);
  /// False if there is none left.
  bool next(std::vector<int>& sample);

 private:
  bool advance();
  void draw();

  int count_, size_, left_;
  std::uint64_t state_;
  bool drawn_ = false, first_ = true;
  std::vector<int> deck_;
};

}  // namespace plumbline

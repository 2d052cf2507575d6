#include "geometry/samples.hpp"

#include <utility>

#include "geometry/random.hpp"

namespace plumbline {

Samples::Samples(int count, int size, int most, std::uint64_t seed)
    : count_(count), size_(size), left_(most), state_(seed) {
  double combinations = 1;
  for (int i = 0; i < size; ++i) combinations = combinations * (count - i) / (i + 1);
  drawn_ = combinations > most;
  for (int i = 0; i < (drawn_ ? count : size); ++i) deck_.push_back(i);
}

bool Samples::next(std::vector<int>& sample) {
  if (drawn_ ? left_-- <= 0 : !first_ && !advance()) return false;  // the first combination is there from the beginning
  first_ = false;
  if (drawn_) draw();
  sample.assign(deck_.begin(), deck_.begin() + size_);
  return true;
}

bool Samples::advance() {
  int i = size_ - 1;
  while (i >= 0 && deck_[i] == count_ - size_ + i) --i;
  if (i < 0) return false;
  ++deck_[i];
  for (int j = i + 1; j < size_; ++j) deck_[j] = deck_[j - 1] + 1;
  return true;
}

void Samples::draw() {
  for (int i = 0; i < size_; ++i) {
    const std::uint64_t bits = mix_bits(state_);
    state_ += 0x9e3779b97f4a7c15ull;
    std::swap(deck_[i], deck_[i + static_cast<int>(bits % static_cast<std::uint64_t>(count_ - i))]);
  }
}

}  // namespace plumbline

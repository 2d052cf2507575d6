// Cholesky in the lower triangle of a large matrix, with the widest vectors that the processor has and the same bits on
// all.
#pragma once

#include <cstddef>

namespace plumbline::linear_algebra {

/// Vectors of doubles: 2 (every x86-64 and ARM), 4 (AVX2), 8 (AVX-512).
enum class Vectors { of_two, of_four, of_eight };
/// The widest that this processor has.
Vectors widest_vectors();

/// L with L Lᵀ = A in the place of A's lower triangle, columns one after the other, `rows` x `rows`; what is above the
/// diagonal is neither read nor written. False where A is not positive definite: L holds no factor then. Every element
/// is computed in one order without fused multiplication, so that its bits do not depend on `vectors`. Golub and
/// Van Loan, Matrix Computations, 4.2.
bool lower_factor(double* a, std::ptrdiff_t rows, Vectors vectors = widest_vectors());

}  // namespace plumbline::linear_algebra

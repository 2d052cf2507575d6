#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>

/// Eigen's kernels for matrices of doubles whose size is known when the program runs, instantiated once
/// (eigen_once.cpp): a file that multiplies two such matrices costs the compiler 2 to 5 s more otherwise. Only what
/// Eigen does not mark `inline` can be declared so. It is part of the precompiled headers; nothing includes it.
///
/// The headers declare (`extern template`); eigen_once.cpp defines the macro as nothing and with it instantiates.
#ifndef PLUMBLINE_EIGEN_ONCE
#define PLUMBLINE_EIGEN_ONCE extern
#endif

namespace Eigen::internal {

using KernelTraits = gebp_traits<double, double>;
using KernelResult = blas_data_mapper<double, Index, ColMajor, Unaligned, 1>;
using KernelColumns = const_blas_data_mapper<double, Index, ColMajor>;
using KernelRows = const_blas_data_mapper<double, Index, RowMajor>;

PLUMBLINE_EIGEN_ONCE template struct gebp_kernel<double, double, Index, KernelResult, KernelTraits::mr,
                                                 KernelTraits::nr, false, false>;

PLUMBLINE_EIGEN_ONCE template struct gemm_pack_lhs<double, Index, KernelColumns, KernelTraits::mr,
                                                   KernelTraits::LhsProgress, KernelTraits::LhsPacket4Packing, ColMajor,
                                                   false, false>;
PLUMBLINE_EIGEN_ONCE template struct gemm_pack_lhs<double, Index, KernelRows, KernelTraits::mr,
                                                   KernelTraits::LhsProgress, KernelTraits::LhsPacket4Packing, RowMajor,
                                                   false, false>;
PLUMBLINE_EIGEN_ONCE template struct gemm_pack_rhs<double, Index, KernelColumns, KernelTraits::nr, ColMajor, false,
                                                   false>;
PLUMBLINE_EIGEN_ONCE template struct gemm_pack_rhs<double, Index, KernelRows, KernelTraits::nr, RowMajor, false, false>;

PLUMBLINE_EIGEN_ONCE template struct general_matrix_vector_product<Index, double, KernelColumns, ColMajor, false,
                                                                   double, KernelRows, false, 0>;
PLUMBLINE_EIGEN_ONCE template struct general_matrix_vector_product<Index, double, KernelRows, RowMajor, false, double,
                                                                   KernelColumns, false, 0>;
PLUMBLINE_EIGEN_ONCE template struct general_matrix_vector_product<Index, double, KernelRows, RowMajor, false, double,
                                                                   KernelRows, false, 1>;

PLUMBLINE_EIGEN_ONCE template struct triangular_solve_matrix<double, Index, OnTheLeft, Lower, false, ColMajor, ColMajor,
                                                             1>;
PLUMBLINE_EIGEN_ONCE template struct triangular_solve_matrix<double, Index, OnTheLeft, Lower, false, RowMajor, ColMajor,
                                                             1>;
PLUMBLINE_EIGEN_ONCE template struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, ColMajor, ColMajor,
                                                             1>;
PLUMBLINE_EIGEN_ONCE template struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, RowMajor, ColMajor,
                                                             1>;
PLUMBLINE_EIGEN_ONCE template struct triangular_solve_matrix<double, Index, OnTheLeft, UnitLower, false, ColMajor,
                                                             ColMajor, 1>;
PLUMBLINE_EIGEN_ONCE template struct triangular_solve_matrix<double, Index, OnTheRight, Upper, false, RowMajor,
                                                             ColMajor, 1>;

}  // namespace Eigen::internal

namespace Eigen {

PLUMBLINE_EIGEN_ONCE template class LLT<MatrixXd>;
PLUMBLINE_EIGEN_ONCE template class LDLT<MatrixXd>;
PLUMBLINE_EIGEN_ONCE template class PartialPivLU<MatrixXd>;
PLUMBLINE_EIGEN_ONCE template class FullPivLU<MatrixXd>;
PLUMBLINE_EIGEN_ONCE template class HouseholderQR<MatrixXd>;
PLUMBLINE_EIGEN_ONCE template class ColPivHouseholderQR<MatrixXd>;

}  // namespace Eigen

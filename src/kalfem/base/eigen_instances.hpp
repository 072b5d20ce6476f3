#pragma once

#include <Eigen/Dense>

/// The decompositions and kernels of Eigen::MatrixXd that many files use, compiled once in eigen_instances.cpp: each of
/// them costs a compiler 2 to 12 seconds. The precompiled headers include this, so that no other file needs to.
#ifndef KALFEM_EIGEN_INSTANCE
#define KALFEM_EIGEN_INSTANCE extern template
#endif

namespace Eigen {

KALFEM_EIGEN_INSTANCE class SelfAdjointEigenSolver<MatrixXd>;
KALFEM_EIGEN_INSTANCE class GeneralizedSelfAdjointEigenSolver<MatrixXd>;
KALFEM_EIGEN_INSTANCE class LLT<MatrixXd>;
KALFEM_EIGEN_INSTANCE class LDLT<MatrixXd>;
KALFEM_EIGEN_INSTANCE class PartialPivLU<MatrixXd>;
KALFEM_EIGEN_INSTANCE class HouseholderQR<MatrixXd>;
KALFEM_EIGEN_INSTANCE class ColPivHouseholderQR<MatrixXd>;
KALFEM_EIGEN_INSTANCE class CompleteOrthogonalDecomposition<MatrixXd>;
KALFEM_EIGEN_INSTANCE class JacobiSVD<MatrixXd>;
KALFEM_EIGEN_INSTANCE class SelfAdjointEigenSolver<Matrix3d>;
KALFEM_EIGEN_INSTANCE class EigenSolver<MatrixXd>;
KALFEM_EIGEN_INSTANCE class HouseholderSequence<MatrixXd, VectorXd, OnTheLeft>;

// Their members that are templates themselves, for a matrix that was evaluated.
KALFEM_EIGEN_INSTANCE SelfAdjointEigenSolver<MatrixXd>& SelfAdjointEigenSolver<MatrixXd>::compute(
    const EigenBase<MatrixXd>&, int);
KALFEM_EIGEN_INSTANCE EigenSolver<MatrixXd>& EigenSolver<MatrixXd>::compute(const EigenBase<MatrixXd>&, bool);
KALFEM_EIGEN_INSTANCE LLT<MatrixXd>& LLT<MatrixXd>::compute(const EigenBase<MatrixXd>&);
KALFEM_EIGEN_INSTANCE LDLT<MatrixXd>& LDLT<MatrixXd>::compute(const EigenBase<MatrixXd>&);
KALFEM_EIGEN_INSTANCE void LLT<MatrixXd>::_solve_impl(const MatrixXd&, MatrixXd&) const;
KALFEM_EIGEN_INSTANCE void LLT<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;
KALFEM_EIGEN_INSTANCE void HouseholderQR<MatrixXd>::_solve_impl(const MatrixXd&, MatrixXd&) const;
KALFEM_EIGEN_INSTANCE void HouseholderQR<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;
KALFEM_EIGEN_INSTANCE void ColPivHouseholderQR<MatrixXd>::_solve_impl(const MatrixXd&, MatrixXd&) const;
KALFEM_EIGEN_INSTANCE void ColPivHouseholderQR<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;
KALFEM_EIGEN_INSTANCE void CompleteOrthogonalDecomposition<MatrixXd>::_solve_impl(const MatrixXd&, MatrixXd&) const;
KALFEM_EIGEN_INSTANCE void CompleteOrthogonalDecomposition<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;
KALFEM_EIGEN_INSTANCE SelfAdjointEigenSolver<Matrix3d>& SelfAdjointEigenSolver<Matrix3d>::compute(
    const EigenBase<Matrix3d>&, int);

namespace internal {

// What they are made of, for expressions that are evaluated on the way in.
KALFEM_EIGEN_INSTANCE void tridiagonalization_inplace(MatrixXd&, VectorXd&, VectorXd&, VectorXd&, bool);
KALFEM_EIGEN_INSTANCE ComputationInfo computeFromTridiagonal_impl(VectorXd&, VectorXd&, Index, bool, MatrixXd&);

KALFEM_EIGEN_INSTANCE void apply_block_householder_on_the_left(Block<MatrixXd>&, const Block<MatrixXd>&,
                                                               const VectorBlock<const VectorXd>&, bool);
KALFEM_EIGEN_INSTANCE void apply_block_householder_on_the_left(Block<VectorXd>&, const Block<MatrixXd>&,
                                                               const VectorBlock<const VectorXd>&, bool);

// Products of matrices, and solutions with triangular ones.
template <typename Left, typename Right>
using MatrixProduct = generic_product_impl<Left, Right, DenseShape, DenseShape, GemmProduct>;
template <typename Left>
using VectorProduct = generic_product_impl<Left, VectorXd, DenseShape, DenseShape, GemvProduct>;
using Transposed = Transpose<MatrixXd>;
using ConstTransposed = Transpose<const MatrixXd>;
KALFEM_EIGEN_INSTANCE void MatrixProduct<MatrixXd, MatrixXd>::evalTo(MatrixXd&, const MatrixXd&, const MatrixXd&);
KALFEM_EIGEN_INSTANCE void MatrixProduct<MatrixXd, MatrixXd>::addTo(MatrixXd&, const MatrixXd&, const MatrixXd&);
KALFEM_EIGEN_INSTANCE void MatrixProduct<MatrixXd, MatrixXd>::subTo(MatrixXd&, const MatrixXd&, const MatrixXd&);
KALFEM_EIGEN_INSTANCE void MatrixProduct<Transposed, MatrixXd>::evalTo(MatrixXd&, const Transposed&, const MatrixXd&);
KALFEM_EIGEN_INSTANCE void MatrixProduct<ConstTransposed, MatrixXd>::evalTo(MatrixXd&, const ConstTransposed&,
                                                                            const MatrixXd&);
KALFEM_EIGEN_INSTANCE void MatrixProduct<MatrixXd, Transposed>::evalTo(MatrixXd&, const MatrixXd&, const Transposed&);
KALFEM_EIGEN_INSTANCE void MatrixProduct<MatrixXd, ConstTransposed>::evalTo(MatrixXd&, const MatrixXd&,
                                                                            const ConstTransposed&);
KALFEM_EIGEN_INSTANCE void VectorProduct<MatrixXd>::scaleAndAddTo(VectorXd&, const MatrixXd&, const VectorXd&,
                                                                  const double&);
KALFEM_EIGEN_INSTANCE void VectorProduct<Transposed>::scaleAndAddTo(VectorXd&, const Transposed&, const VectorXd&,
                                                                    const double&);
KALFEM_EIGEN_INSTANCE void VectorProduct<ConstTransposed>::scaleAndAddTo(VectorXd&, const ConstTransposed&,
                                                                         const VectorXd&, const double&);
using RealTraits = gebp_traits<double, double>;
using ColumnsMapper = const_blas_data_mapper<double, Index, ColMajor>;
using RowsMapper = const_blas_data_mapper<double, Index, RowMajor>;
KALFEM_EIGEN_INSTANCE struct gebp_kernel<double, double, Index, blas_data_mapper<double, Index, ColMajor>,
                                         RealTraits::mr, RealTraits::nr, false, false>;
KALFEM_EIGEN_INSTANCE struct gemm_pack_lhs<double, Index, ColumnsMapper, RealTraits::mr, RealTraits::LhsProgress,
                                           RealTraits::LhsPacket4Packing, ColMajor>;
KALFEM_EIGEN_INSTANCE struct gemm_pack_lhs<double, Index, RowsMapper, RealTraits::mr, RealTraits::LhsProgress,
                                           RealTraits::LhsPacket4Packing, RowMajor>;
KALFEM_EIGEN_INSTANCE struct gemm_pack_rhs<double, Index, ColumnsMapper, RealTraits::nr, ColMajor>;
KALFEM_EIGEN_INSTANCE struct gemm_pack_rhs<double, Index, RowsMapper, RealTraits::nr, RowMajor>;
KALFEM_EIGEN_INSTANCE struct triangular_solve_matrix<double, Index, OnTheLeft, Lower, false, ColMajor, ColMajor, 1>;
KALFEM_EIGEN_INSTANCE struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, ColMajor, ColMajor, 1>;
KALFEM_EIGEN_INSTANCE struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, RowMajor, ColMajor, 1>;

}  // namespace internal
}  // namespace Eigen

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <optional>

#include "kalfem/linalg/single_precision_factor.hpp"
#include "kalfem/linalg/sparse_factor.hpp"
#include "kalfem/linalg/upper_triangle.hpp"

namespace kalfem {

/// A pivot below this part of its diagonal entry counts as zero, see SparseFactor.
inline constexpr double zero_pivot = 1e-13;

/// The library that factors behind SparseFactor. It is made for a pattern, which it analyses, and factors matrices of
/// this pattern. One thread at a time.
class FactorWorkspace {
public:
  virtual ~FactorWorkspace() = default;

  /// Throws NotPositiveDefinite, after which only another factorize() makes sense.
  virtual void factorize(const UpperTriangle& matrix) = 0;
  /// X = A^-1 B, n x k, k > 0; X and B may be the same.
  virtual void solve(const Eigen::Ref<const Eigen::MatrixXd>& right_side, Eigen::Ref<Eigen::MatrixXd> solution) = 0;

  [[nodiscard]] virtual EliminationOrder order() const = 0;
  [[nodiscard]] virtual double nonzeros() const = 0;        ///< entries of the factor
  [[nodiscard]] virtual double bytes() const = 0;           ///< memory of the factor [byte]
  [[nodiscard]] virtual double smallest_pivot() const = 0;  ///< relative to its diagonal entry
  /// Nothing where L is not kept by supernodes, or not here.
  [[nodiscard]] virtual std::optional<SinglePrecisionFactor> in_single_precision() const { return {}; }
};

/// By the maker in use, see Makers, otherwise by CHOLMOD.
std::unique_ptr<FactorWorkspace> make_factor_workspace(const UpperTriangle& pattern, const EliminationOrder& order);

}  // namespace kalfem

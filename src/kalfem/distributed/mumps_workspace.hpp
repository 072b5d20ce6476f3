// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/distributed/mumps_on_all_ranks.hpp"
#include "kalfem/linalg/factor_workspace.hpp"

namespace kalfem::distributed {

/// P A P^T = L D L^T with L distributed over the ranks by MUMPS [ADKL01]. Matrices and right-hand sides come from rank
/// 0, to which this object belongs, and solutions return there.
///
/// A is positive definite where no entry of D is negative or below zero_pivot A_jj.
class MumpsWorkspace : public FactorWorkspace {
public:
  MumpsWorkspace(Service& service, const UpperTriangle& pattern, const EliminationOrder& order);

  void factorize(const UpperTriangle& matrix) override;
  void solve(const Eigen::Ref<const Eigen::MatrixXd>& right_side, Eigen::Ref<Eigen::MatrixXd> solution) override;

  [[nodiscard]] EliminationOrder order() const override { return order_; }
  [[nodiscard]] double nonzeros() const override;
  [[nodiscard]] double bytes() const override;
  [[nodiscard]] double smallest_pivot() const override { return smallest_pivot_; }

private:
  void give(const UpperTriangle& matrix);
  void take_back();
  bool eliminate(const std::vector<double>& values);
  void eliminate_beside(const UpperTriangle& matrix);
  [[nodiscard]] Eigen::Index weakest_column(bool negative_met);
  [[noreturn]] void fail() const;

  Eigen::VectorXd scale_;  ///< A_jj^-1/2
  EliminationOrder order_;
  MumpsOnAllRanks mumps_;
  std::vector<MUMPS_INT> rows_, columns_;  ///< of the entries, from 1; while they are needed only
  double smallest_pivot_ = 1.0;
};

}  // namespace kalfem::distributed

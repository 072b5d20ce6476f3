// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cholmod.h>

#include "kalfem/linalg/factor_workspace.hpp"

namespace kalfem {

/// L L^T = P A P^T by CHOLMOD [CDHR08] on this computer.
class CholmodWorkspace : public FactorWorkspace {
public:
  CholmodWorkspace(const UpperTriangle& pattern, const EliminationOrder& order);
  ~CholmodWorkspace() override;
  CholmodWorkspace(const CholmodWorkspace&) = delete;
  CholmodWorkspace& operator=(const CholmodWorkspace&) = delete;

  void factorize(const UpperTriangle& matrix) override;
  void solve(const Eigen::Ref<const Eigen::MatrixXd>& right_side, Eigen::Ref<Eigen::MatrixXd> solution) override;

  /// Known from the analysis on.
  [[nodiscard]] EliminationOrder order() const override;
  [[nodiscard]] double nonzeros() const override;  ///< with the zeros that supernodes store
  [[nodiscard]] double bytes() const override;
  [[nodiscard]] double smallest_pivot() const override { return smallest_pivot_; }
  [[nodiscard]] std::optional<SinglePrecisionFactor> in_single_precision() const override;

private:
  /// What solve2 keeps between calls; it allocates anew when the number of right-hand sides changes.
  struct Temporaries {
    cholmod_dense* y = nullptr;
    cholmod_dense* e = nullptr;
  };

  void check_pivots(const UpperTriangle& matrix);
  [[nodiscard]] Eigen::Index given_column(std::size_t j) const;
  void solve_whole(cholmod_dense right_side, cholmod_dense solution);
  [[noreturn]] void fail() const;

  cholmod_common common_{};
  cholmod_factor* factor_ = nullptr;
  Temporaries single_, block_;
  double smallest_pivot_ = 1.0;
};

}  // namespace kalfem

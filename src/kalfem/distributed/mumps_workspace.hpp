#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "kalfem/distributed/mumps_instance.hpp"
#include "kalfem/distributed/service.hpp"
#include "kalfem/linalg/factor_workspace.hpp"

namespace kalfem::distributed {

/// P A P^T = L D L^T with L distributed over the ranks by MUMPS [ADKL01]. Matrices and right-hand sides come from rank
/// 0, to which this object belongs, and solutions return there.
///
/// A is positive definite where D has no negative entry and no row of what is left to eliminate vanishes: none below
/// 1e-13 in the matrix that is scaled to a unit diagonal. smallest_pivot() is 1e-10 where no such row is below that,
/// otherwise 1e-13: what lies between is not told apart.
class MumpsWorkspace : public FactorWorkspace {
public:
  MumpsWorkspace(Service& service, const LowerTriangle& pattern, const EliminationOrder& order);
  ~MumpsWorkspace() override;

  void factorize(const LowerTriangle& matrix) override;
  void solve(const Eigen::Ref<const Eigen::MatrixXd>& right_side, Eigen::Ref<Eigen::MatrixXd> solution) override;

  [[nodiscard]] EliminationOrder order() const override { return order_; }
  [[nodiscard]] double nonzeros() const override;
  [[nodiscard]] double bytes() const override;
  [[nodiscard]] double smallest_pivot() const override { return smallest_pivot_; }

private:
  void run(MumpsJob job);
  void give(const LowerTriangle& matrix);
  void take_back();
  void scale(const LowerTriangle& matrix);
  void eliminate(double threshold);
  [[nodiscard]] Eigen::Index column_of_negative_energy();

  Service& service_;
  int number_;
  std::optional<MumpsInstance> instance_;
  EliminationOrder order_;
  std::vector<MUMPS_INT> rows_, columns_;  ///< of the entries, from 1; while they are needed only
  Eigen::VectorXd scale_;                  ///< A_jj^-1/2
  double smallest_pivot_ = 1.0;
};

}  // namespace kalfem::distributed

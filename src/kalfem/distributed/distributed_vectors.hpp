// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/distributed/vectors_part.hpp"

namespace kalfem::distributed {

/// Vectors whose rows are distributed over the ranks, as rank 0 holds them: what it does, all ranks do. Blocks go out
/// and come back by VectorsPart::widest columns.
class DistributedVectors final : public LongVectors {
public:
  DistributedVectors(Service& service, Eigen::Index rows);
  ~DistributedVectors() override;
  DistributedVectors(const DistributedVectors&) = delete;
  DistributedVectors& operator=(const DistributedVectors&) = delete;

  void reserve(Eigen::Index capacity) override;
  [[nodiscard]] Eigen::Index capacity() const override { return own_.capacity(); }
  [[nodiscard]] Eigen::Index rows() const override { return rows_; }

  void put(Eigen::Index place, const Columns& block) override;
  void get(Eigen::Index place, Eigen::Ref<Eigen::MatrixXd> block) const override;
  [[nodiscard]] Eigen::MatrixXd take() override;
  [[nodiscard]] Eigen::MatrixXd products(Eigen::Index begin, Eigen::Index end, const Columns& block) const override;
  Eigen::MatrixXd project_out(Eigen::Index begin, Eigen::Index end, const Columns& mass_weighted,
                              Eigen::Ref<Eigen::MatrixXd> block) const override;
  [[nodiscard]] Eigen::MatrixXd combination(const Columns& weights) const override;
  void combine(const Columns& weights) override;

private:
  [[nodiscard]] Order order(VectorsJob job, Eigen::Index first, Eigen::Index second = 0, Eigen::Index third = 0) const;

  Service& service_;
  int number_;
  Eigen::Index rows_;
  mutable VectorsPart own_;  ///< with room for a block on its way
};

}  // namespace kalfem::distributed

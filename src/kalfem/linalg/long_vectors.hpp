// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <memory>

namespace kalfem {

/// Vectors Q = [q_0 q_1 ...] of n rows each, of a Krylov space or a reduction: n is as many as a large model has
/// degrees of freedom, so that their memory may be that of other processes too. The blocks that they are given and give
/// are in this one. One thread at a time.
class LongVectors {
public:
  using Columns = Eigen::Ref<const Eigen::MatrixXd>;  ///< whose columns are contiguous

  virtual ~LongVectors() = default;

  /// Makes room for so many vectors; those that find room in it stay. Throws std::bad_alloc, after which the vectors
  /// can only be given up.
  virtual void reserve(Eigen::Index capacity) = 0;
  [[nodiscard]] virtual Eigen::Index capacity() const = 0;
  [[nodiscard]] virtual Eigen::Index rows() const = 0;

  /// The columns of V, n x k, become q_place and those that follow.
  virtual void put(Eigen::Index place, const Columns& block) = 0;
  /// q_place and those that follow become the columns of V, n x k.
  virtual void get(Eigen::Index place, Eigen::Ref<Eigen::MatrixXd> block) const = 0;
  /// The vectors from q_begin to the one before q_end, n x k.
  [[nodiscard]] Eigen::MatrixXd columns(Eigen::Index begin, Eigen::Index end) const;
  /// All of them, n x capacity, which leave their place here: no more than a few are there twice.
  [[nodiscard]] virtual Eigen::MatrixXd take() = 0;

  /// Q^T Y of the vectors from q_begin to the one before q_end, with Y n x k.
  [[nodiscard]] virtual Eigen::MatrixXd products(Eigen::Index begin, Eigen::Index end, const Columns& block) const = 0;

  /// V - Q C in place of V, with C = Q^T M V, of the vectors from q_begin to the one before q_end. `mass_weighted`: M
  /// V, n x k. Returns C.
  virtual Eigen::MatrixXd project_out(Eigen::Index begin, Eigen::Index end, const Columns& mass_weighted,
                                      Eigen::Ref<Eigen::MatrixXd> block) const = 0;

  /// Q W, n x m, of as many leading vectors as W has rows.
  [[nodiscard]] virtual Eigen::MatrixXd combination(const Columns& weights) const = 0;
  /// Q W in place of the leading vectors, for a W with no more columns than rows.
  virtual void combine(const Columns& weights) = 0;
};

/// By the maker in use, see Makers, otherwise in the memory of this process; without room yet.
std::unique_ptr<LongVectors> make_long_vectors(Eigen::Index rows);
/// These columns, made likewise.
std::unique_ptr<LongVectors> make_long_vectors(Eigen::MatrixXd columns);

/// Vectors, or a part of their rows, in the memory of this process.
class VectorsInMemory final : public LongVectors {
public:
  explicit VectorsInMemory(Eigen::Index rows) : vectors_(rows, 0) {}
  explicit VectorsInMemory(Eigen::MatrixXd columns) : vectors_(std::move(columns)) {}

  /// The vectors from q_begin to the one before q_end.
  [[nodiscard]] auto between(Eigen::Index begin, Eigen::Index end) { return vectors_.middleCols(begin, end - begin); }
  [[nodiscard]] auto between(Eigen::Index begin, Eigen::Index end) const {
    return vectors_.middleCols(begin, end - begin);
  }

  void reserve(Eigen::Index capacity) override { vectors_.conservativeResize(Eigen::NoChange, capacity); }
  [[nodiscard]] Eigen::Index capacity() const override { return vectors_.cols(); }
  [[nodiscard]] Eigen::Index rows() const override { return vectors_.rows(); }

  void put(Eigen::Index place, const Columns& block) override { between(place, place + block.cols()) = block; }
  void get(Eigen::Index place, Eigen::Ref<Eigen::MatrixXd> block) const override {
    block = between(place, place + block.cols());
  }
  [[nodiscard]] Eigen::MatrixXd take() override;
  [[nodiscard]] Eigen::MatrixXd products(Eigen::Index begin, Eigen::Index end, const Columns& block) const override;
  Eigen::MatrixXd project_out(Eigen::Index begin, Eigen::Index end, const Columns& mass_weighted,
                              Eigen::Ref<Eigen::MatrixXd> block) const override;
  [[nodiscard]] Eigen::MatrixXd combination(const Columns& weights) const override;
  void combine(const Columns& weights) override;

private:
  Eigen::MatrixXd vectors_;  ///< n x capacity
};

}  // namespace kalfem

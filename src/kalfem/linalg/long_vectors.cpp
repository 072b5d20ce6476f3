#include "kalfem/linalg/long_vectors.hpp"

#include "kalfem/linalg/makers.hpp"
#include "kalfem/linalg/tall_matrices.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

std::unique_ptr<LongVectors> make_long_vectors(Index rows) {
  if (const auto& maker = makers_in_use().long_vectors)
    if (auto vectors = maker(rows)) return vectors;
  return std::make_unique<VectorsInMemory>(rows);
}

MatrixXd VectorsInMemory::project_out(Index begin, Index end, const Columns& mass_weighted,
                                      Eigen::Ref<MatrixXd> block) {
  MatrixXd coefficients = between(begin, end).transpose() * mass_weighted;
  block.noalias() -= between(begin, end) * coefficients;
  return coefficients;
}

MatrixXd VectorsInMemory::combination(const Columns& weights) const { return between(0, weights.rows()) * weights; }

void VectorsInMemory::combine(const Columns& weights) { kalfem::combine(vectors_, weights); }

}  // namespace kalfem

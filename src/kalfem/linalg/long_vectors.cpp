#include "kalfem/linalg/long_vectors.hpp"

#include <algorithm>

#include "kalfem/linalg/makers.hpp"

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

// By panels of rows: nothing else has the size of the vectors.
void VectorsInMemory::combine(const Columns& weights) {
  constexpr Index panel = 6144;
  MatrixXd combined;
  for (Index first = 0; first < rows(); first += panel) {
    auto leading = vectors_.middleRows(first, std::min(panel, rows() - first));
    combined.noalias() = leading.leftCols(weights.rows()) * weights;
    leading.leftCols(weights.cols()) = combined;
  }
}

}  // namespace kalfem

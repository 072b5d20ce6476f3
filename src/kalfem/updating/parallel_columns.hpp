#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <exception>
#include <optional>

#include "kalfem/base/worker_pool.hpp"

namespace kalfem {

/// A matrix whose columns cost much and do not depend on each other, column(i) -> std::optional<Eigen::VectorXd>, made
/// in several threads. Nothing where a column is missing; the first exception of a column is thrown again.
template <class Column>
std::optional<Eigen::MatrixXd> parallel_columns(Eigen::Index rows, Eigen::Index columns, int threads,
                                                const Column& column) {
  Eigen::MatrixXd matrix(rows, columns);
  std::vector<char> missing(static_cast<std::size_t>(columns), 0);
  std::vector<std::exception_ptr> thrown(static_cast<std::size_t>(columns));
  WorkerPool pool(std::max(1, std::min(threads, static_cast<int>(columns))));
  pool.run(static_cast<int>(columns), [&](int i) {
    const auto place = static_cast<std::size_t>(i);
    try {
      if (const auto values = column(static_cast<Eigen::Index>(i)))
        matrix.col(i) = *values;
      else
        missing[place] = 1;
    } catch (...) {
      thrown[place] = std::current_exception();
    }
  });
  for (const auto& each : thrown)
    if (each) std::rethrow_exception(each);
  if (std::ranges::find(missing, char{1}) != missing.end()) return std::nullopt;
  return matrix;
}

}  // namespace kalfem

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <unordered_map>
#include <vector>

#include "kalfem/model/linear_model.hpp"

namespace kalfem {

/// Primal assembly of parts without grounds or modal damping: degrees of freedom of equal name become one, numbered as
/// they first appear. With the Boolean matrix L_s that selects those of part s,
///     M = sum_s L_s^T M_s L_s,  C and K alike.
/// Points keep their names.
inline LinearModel assemble_parts(const std::vector<const LinearModel*>& parts) {
  LinearModel assembly;
  std::unordered_map<std::string, int> positions;
  std::vector<std::vector<int>> of_part;
  for (const LinearModel* part : parts) {
    auto& own = of_part.emplace_back();
    for (const auto& name : part->dofs) {
      const auto [position, added] = positions.emplace(name, static_cast<int>(assembly.dofs.size()));
      if (added) assembly.dofs.push_back(name);
      own.push_back(position->second);
    }
    assembly.points.insert(part->points.begin(), part->points.end());
  }
  const auto sum = [&](SparseMatrix LinearModel::*matrix) {
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t s = 0; s < parts.size(); ++s) {
      const SparseMatrix& own = parts[s]->*matrix;
      for (Eigen::Index column = 0; column < own.outerSize(); ++column)
        for (SparseMatrix::InnerIterator it(own, column); it; ++it)
          entries.emplace_back(of_part[s][static_cast<std::size_t>(it.row())],
                               of_part[s][static_cast<std::size_t>(it.col())], it.value());
    }
    const auto n = static_cast<Eigen::Index>(assembly.dofs.size());
    SparseMatrix result(n, n);
    result.setFromTriplets(entries.begin(), entries.end());
    return result;
  };
  assembly.mass = sum(&LinearModel::mass);
  assembly.damping = sum(&LinearModel::damping);
  assembly.stiffness = sum(&LinearModel::stiffness);
  assembly.points_only = std::ranges::any_of(parts, [](const auto* part) { return part->points_only; });
  return assembly;
}

}  // namespace kalfem

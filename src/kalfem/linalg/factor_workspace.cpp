// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/factor_workspace.hpp"

#include "kalfem/linalg/cholmod_workspace.hpp"
#include "kalfem/linalg/makers.hpp"

namespace kalfem {

std::unique_ptr<FactorWorkspace> make_factor_workspace(const UpperTriangle& pattern, const EliminationOrder& order) {
  if (const auto& maker = makers_in_use().factor)
    if (auto workspace = maker(pattern, order)) return workspace;
  return std::make_unique<CholmodWorkspace>(pattern, order);
}

}  // namespace kalfem

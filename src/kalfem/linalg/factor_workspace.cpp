#include "kalfem/linalg/factor_workspace.hpp"

#include <utility>

#include "kalfem/linalg/cholmod_workspace.hpp"

namespace kalfem {
namespace {

FactorMaker& maker_in_use() {
  static FactorMaker maker;
  return maker;
}

}  // namespace

FactorMaker use_factor_maker(FactorMaker maker) { return std::exchange(maker_in_use(), std::move(maker)); }

std::unique_ptr<FactorWorkspace> make_factor_workspace(const UpperTriangle& pattern, const EliminationOrder& order) {
  if (const auto& maker = maker_in_use())
    if (auto workspace = maker(pattern, order)) return workspace;
  return std::make_unique<CholmodWorkspace>(pattern, order);
}

}  // namespace kalfem

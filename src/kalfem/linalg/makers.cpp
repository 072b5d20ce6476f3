// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/makers.hpp"

#include <utility>

namespace kalfem {
namespace {

Makers& in_use() {
  static Makers makers;
  return makers;
}

}  // namespace

Makers use_makers(Makers makers) { return std::exchange(in_use(), std::move(makers)); }

const Makers& makers_in_use() { return in_use(); }

}  // namespace kalfem

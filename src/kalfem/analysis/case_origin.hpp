// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "kalfem/api/structure_description.hpp"
#include "kalfem/casefile/description.hpp"

namespace kalfem {

/// The case that a structure was read from, as its file states it, and what was made of it.
struct CaseOrigin final : StructureOrigin {
  CaseOrigin(std::shared_ptr<const description::Case> given_, StructurePtr structure_)
      : given(std::move(given_)), structure(std::move(structure_)) {}

  std::shared_ptr<const description::Case> given;
  StructurePtr structure;
};

}  // namespace kalfem

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/casefile/description.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// A study under construction, with the case that describes it.
struct CaseStudy : Study {
  description::Case given;
};

/// Makes the study of a case that was read from `file`. Throws InvalidInput as load_study().
Study make_study(description::Case given, const std::string& file);

}  // namespace kalfem

#pragma once

#include "kalfem/casefile/description.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// A study while it is made, beside the case that says what it is to be.
struct CaseStudy : Study {
  description::Case given;
};

/// The study of a case that was read from `file`. Throws InvalidInput as load_study().
Study make_study(description::Case given, const std::string& file);

}  // namespace kalfem

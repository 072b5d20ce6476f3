// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/casefile/description.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// Throws InvalidInput with every key of the record, the excitation and the estimation that the library's options have
/// no word for, by its place.
void require_expressible(const Study& study);

/// The sections of a case that an Analysis does not hold, by their keys.
std::vector<std::string> sections_left_out(const description::Case& given);

}  // namespace kalfem

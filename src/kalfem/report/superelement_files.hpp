#pragma once

#include <filesystem>

#include "kalfem/study/study.hpp"

namespace kalfem {

/// Writes the augmented model's superelements for other codes, in the formats that the case asks for:
/// <substructure>_reduced with the ending of the format (.mtx, .dmig, .op4, .h5), see write_superelement().
void write_superelements(const std::filesystem::path& folder, const Study& study);

}  // namespace kalfem

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kalfem::nastran {

/// More images than this are a mistake.
constexpr std::size_t most_images = 500'000;

/// Of the first field of a replicated card: 0 of "=", n of "=(n)" and "=n"; nothing of any other.
std::optional<std::size_t> image_count(std::string_view first);

/// Fields of the image of a card [QRG]: "=" repeats a field, "==" it and all that follow, "*(x)" or "*x" adds x to it;
/// any other stands as it is. Nothing where a field that is added to is no number.
std::optional<std::vector<std::string>> image_of(const std::vector<std::string_view>& card,
                                                 const std::vector<std::string>& steps);

}  // namespace kalfem::nastran

// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/nastran/replication.hpp"

#include <array>
#include <charconv>

#include "kalfem/formats/nastran/card.hpp"

namespace kalfem::nastran {
namespace {

/// "(x)" or "x".
std::string_view without_brackets(std::string_view text) {
  if (text.size() >= 2 && text.front() == '(' && text.back() == ')') text = text.substr(1, text.size() - 2);
  return text;
}

/// A real number keeps a point or an exponent, since that tells it from a whole one.
std::string as_real(double value) {
  std::array<char, 32> digits;
  char* const end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  std::string text(digits.data(), static_cast<std::size_t>(end - digits.data()));
  if (text.find_first_of(".eE") == std::string::npos) text += '.';
  return text;
}

std::optional<std::string> sum(std::string_view field, std::string_view step) {
  if (const auto whole = parse_integer(field), by = parse_integer(step); whole && by)
    return std::to_string(*whole + *by);
  const auto value = field.empty() ? std::optional(0.0) : parse_real(field), by = parse_real(step);
  return value && by ? std::optional(as_real(*value + *by)) : std::nullopt;
}

}  // namespace

std::optional<std::size_t> image_count(std::string_view first) {
  if (first == "=") return 0;
  const auto count = parse_integer(without_brackets(first.substr(1)));
  if (!count || *count < 1) return std::nullopt;
  return static_cast<std::size_t>(*count);
}

std::optional<std::vector<std::string>> image_of(const std::vector<std::string_view>& card,
                                                 const std::vector<std::string>& steps) {
  std::vector<std::string> image(8);
  const auto before = [&](std::size_t i) { return i < card.size() ? card[i] : std::string_view{}; };
  for (std::size_t i = 0; i < image.size() && i < steps.size(); ++i) {
    const std::string& step = steps[i];
    if (step == "==") {
      for (; i < image.size(); ++i) image[i] = before(i);
    } else if (step == "=") {
      image[i] = before(i);
    } else if (step.starts_with('*')) {
      const auto added = sum(before(i), without_brackets(std::string_view(step).substr(1)));
      if (!added) return std::nullopt;
      image[i] = *added;
    } else {
      image[i] = step;
    }
  }
  return image;
}

}  // namespace kalfem::nastran

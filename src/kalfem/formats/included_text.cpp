#include "kalfem/formats/included_text.hpp"

namespace kalfem {
namespace {

/// An apostrophe opens a quotation at the start of a word only.
std::size_t opening_mark(std::string_view message) {
  for (std::size_t i = 0; i < message.size(); ++i)
    if (message[i] == '\'' && (i == 0 || message[i - 1] == ' ' || message[i - 1] == '(')) return i;
  return std::string_view::npos;
}

bool is_number_like(std::string_view text) {
  return text.size() <= 24 && text.find_first_not_of("0123456789+-.eEdD") == std::string_view::npos;
}

}  // namespace

std::string without_quotations(std::string_view message) {
  const std::size_t open = opening_mark(message);
  const std::size_t close = message.rfind('\'');
  if (open == std::string_view::npos || close <= open || is_number_like(message.substr(open + 1, close - open - 1)))
    return std::string(message);
  return std::string(message.substr(0, open)) + "'...'" + std::string(message.substr(close + 1));
}

}  // namespace kalfem

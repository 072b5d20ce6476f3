// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/text.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

namespace kalfem {
namespace {

unsigned byte_at(std::string_view text, std::size_t i) {
  return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
}

/// Length that the first byte announces, 0 for a byte that begins nothing. C0, C1 and F5 to FF never occur.
std::size_t announced_length(unsigned first) {
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first < 0xE0) return 2;
  if (first >= 0xE0 && first < 0xF0) return 3;
  return first >= 0xF0 && first < 0xF5 ? 4 : 0;
}

/// The number of the character in the sequence of that length.
char32_t character(std::string_view text, std::size_t at, std::size_t length) {
  constexpr std::array<unsigned, 5> first_bits{0, 0x7F, 0x1F, 0x0F, 0x07};
  char32_t number = byte_at(text, at) & first_bits[length];
  for (std::size_t i = 1; i < length; ++i) number = (number << 6) | (byte_at(text, at + i) & 0x3FU);
  return number;
}

/// Overlong forms of two bytes begin with C0 or C1 and are refused by their first byte.
bool is_shortest_form(char32_t number, std::size_t length) {
  return length < 3 || (length == 3 ? number >= 0x800 : number >= 0x10000);
}

bool is_control(char32_t c) { return c < 0x20 || (c >= 0x7F && c < 0xA0); }

/// Marks, embeddings and isolates that turn the direction of writing, and separators that some terminals break at.
bool turns_or_breaks(char32_t c) {
  return c == 0x200E || c == 0x200F || (c >= 0x2028 && c <= 0x202E) || (c >= 0x2066 && c <= 0x2069);
}

std::string escape(const char* format, unsigned number) {
  std::array<char, 16> code{};
  std::snprintf(code.data(), code.size(), format, number);
  return code.data();
}

}  // namespace

// By the rules of the encoding: the first byte announces the length, the others continue it, the number needs that
// length, and is neither a surrogate nor beyond the last character.
std::size_t utf8_length(std::string_view text, std::size_t at) {
  const std::size_t length = announced_length(byte_at(text, at));
  if (at + length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte_at(text, at + i) & 0xC0U) != 0x80U) return 0;
  if (length == 0) return 0;
  const char32_t number = character(text, at, length);
  const bool surrogate = number >= 0xD800 && number < 0xE000;
  return is_shortest_form(number, length) && !surrogate && number <= 0x10FFFF ? length : 0;
}

std::string valid_utf8(std::string_view text) {
  std::string valid;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = utf8_length(text, i);
    valid += length > 0 ? text.substr(i, length) : std::string_view("\xEF\xBF\xBD");
    i += length > 0 ? length : 1;
  }
  return valid;
}

namespace {

/// Characters of Windows-1252 where Latin-1 has control characters.
constexpr std::array<char32_t, 32> windows_characters = {
    0x20AC, 0x81,   0x201A, 0x0192, 0x201E, 0x2026, 0x2020, 0x2021, 0x02C6, 0x2030, 0x0160,
    0x2039, 0x0152, 0x8D,   0x017D, 0x8F,   0x90,   0x2018, 0x2019, 0x201C, 0x201D, 0x2022,
    0x2013, 0x2014, 0x02DC, 0x2122, 0x0161, 0x203A, 0x0153, 0x9D,   0x017E, 0x0178};

void append_character(std::string& text, char32_t code) {
  constexpr std::array<unsigned char, 5> first_bits{0, 0x00, 0xC0, 0xE0, 0xF0};
  const int length = code < 0x80 ? 1 : code < 0x800 ? 2 : code < 0x10000 ? 3 : 4;
  text += static_cast<char>(first_bits[static_cast<std::size_t>(length)] | (code >> (6 * (length - 1))));
  for (int left = length - 2; left >= 0; --left) text += static_cast<char>(0x80U | ((code >> (6 * left)) & 0x3FU));
}

}  // namespace

std::string to_utf8(std::string_view text) {
  bool valid = true;
  for (std::size_t i = 0; i < text.size() && valid;) {
    const std::size_t length = utf8_length(text, i);
    valid = length > 0;
    i += length;
  }
  if (valid) return std::string(text);
  std::string converted;
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    append_character(converted, code >= 0x80 && code < 0xA0 ? windows_characters[code - 0x80U] : code);
  }
  return converted;
}

std::string utf8_of(std::u16string_view text) {
  constexpr char32_t unknown = 0xFFFD;
  std::string converted;
  converted.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char32_t unit = text[i];
    const bool high = unit >= 0xD800 && unit < 0xDC00;
    const char32_t next = high && i + 1 < text.size() ? text[i + 1] : 0;
    if (next >= 0xDC00 && next < 0xE000) {
      append_character(converted, 0x10000 + ((unit - 0xD800) << 10U) + (next - 0xDC00));
      ++i;
    } else {
      append_character(converted, unit >= 0xD800 && unit < 0xE000 ? unknown : unit);
    }
  }
  return converted;
}

std::string with_unicode_escapes(std::string_view text) {
  const std::string valid = valid_utf8(text);
  std::string safe;
  for (std::size_t i = 0; i < valid.size();) {
    const std::size_t length = utf8_length(valid, i);
    const char32_t c = character(valid, i, length);
    const bool obeyed = (is_control(c) && c != '\n') || turns_or_breaks(c);
    safe += obeyed ? escape("\\u%04x", c) : valid.substr(i, length);
    i += length;
  }
  return safe;
}

std::string without_controls(std::string_view text) {
  const std::string valid = valid_utf8(text);
  std::string safe;
  for (std::size_t i = 0; i < valid.size();) {
    const std::size_t length = utf8_length(valid, i);
    const char32_t c = character(valid, i, length);
    if (!is_control(c) || c == '\n' || c == '\t' || c == '\r') safe += valid.substr(i, length);
    i += length;
  }
  return safe;
}

// Names and messages may come from files of others. Control characters could move the cursor or rewrite what stands
// there already, and marks of direction could make text read as another: all are shown as escapes.
std::string terminal_safe(std::string_view text, LineBreaks breaks) {
  std::string safe;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = utf8_length(text, i);
    const char32_t c = length > 0 ? character(text, i, length) : 0;
    if (length == 0)
      safe += escape("\\x%02x", byte_at(text, i));
    else if (c == '\t' || (c == '\n' && breaks == LineBreaks::kept))
      safe += static_cast<char>(c);
    else if (c == '\n')
      safe += "\\n";
    else if (is_control(c))
      safe += escape("\\x%02x", c);
    else if (turns_or_breaks(c))
      safe += escape("\\u%04x", c);
    else
      safe += text.substr(i, length);
    i += length > 0 ? length : 1;
  }
  return safe;
}

std::string upper_case(std::string_view text) {
  std::string result(text);
  std::ranges::transform(result, result.begin(),
                         [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
  return result;
}

std::string lower_case(std::string_view text) {
  std::string result(text);
  std::ranges::transform(result, result.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return result;
}

std::string escaped(std::string_view text) {
  std::string safe;
  for (const char c : without_controls(text)) {
    if (c == '&')
      safe += "&amp;";
    else if (c == '<')
      safe += "&lt;";
    else if (c == '>')
      safe += "&gt;";
    else if (c == '"')
      safe += "&quot;";
    else if (c == '\'')
      safe += "&#39;";
    else
      safe += c;
  }
  return safe;
}

}  // namespace kalfem

// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/text.hpp"

#include <gtest/gtest.h>

namespace kalfem {
namespace {

using namespace std::string_literals;

struct Sequence {
  std::string bytes;
  std::size_t length;
};

TEST(Utf8, OnlyShortestFormsOfCharactersThatExistAreText) {
  for (const auto& [bytes, length] : std::vector<Sequence>{{"a", 1},
                                                           {"\xC2\x80", 2},
                                                           {"\xDF\xBF", 2},
                                                           {"\xE0\xA0\x80", 3},
                                                           {"\xED\x9F\xBF", 3},
                                                           {"\xEE\x80\x80", 3},
                                                           {"\xF0\x90\x80\x80", 4},
                                                           {"\xF4\x8F\xBF\xBF", 4},
                                                           {"\x80", 0},              // continuation alone
                                                           {"\xC0\xAF", 0},          // overlong '/'
                                                           {"\xE0\x80\xAF", 0},      // overlong '/'
                                                           {"\xE0\x9F\xBF", 0},      // overlong, largest of two bytes
                                                           {"\xF0\x8F\xBF\xBF", 0},  // overlong, largest of three
                                                           {"\xED\xA0\x80", 0},      // first surrogate
                                                           {"\xED\xBF\xBF", 0},      // last surrogate
                                                           {"\xF4\x90\x80\x80", 0},  // above U+10FFFF
                                                           {"\xE2\x82", 0},          // cut off
                                                           {"\xE2\x82x", 0},
                                                           {"\xFF", 0}})
    EXPECT_EQ(utf8_length(bytes, 0), length) << terminal_safe(bytes);
  EXPECT_EQ(utf8_length("", 0), 0U);
}

TEST(Utf8, WhatIsNoTextIsReplacedByteByByte) {
  EXPECT_EQ(valid_utf8("Tr\xE4ger \xED\xA0\x80 \xC3\xA4"),
            "Tr\xEF\xBF\xBDger \xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD \xC3\xA4");
}

TEST(Utf8, ATerminalGetsNoControlCharacters) {
  EXPECT_EQ(terminal_safe("\x1b[31mred\x07"), "\\x1b[31mred\\x07");
  EXPECT_EQ(terminal_safe("\xC2\x9B"
                          "2J"),
            "\\x9b2J");  // control sequence of 8 bits
  EXPECT_EQ(terminal_safe("a\0b\r\x7F"s), "a\\x00b\\x0d\\x7f");
  EXPECT_EQ(terminal_safe("\xE2\x80\xAE"
                          "fdp"),
            "\\u202efdp");  // writing from right to left
  EXPECT_EQ(terminal_safe("\xE4 \xC3\xA4 \xC2\xB5m"), "\\xe4 \xC3\xA4 \xC2\xB5m");
}

TEST(Utf8, QuotedStringsOfFilesKeepTheirMeaning) {
  EXPECT_EQ(with_unicode_escapes("\x1b[31m\t\n\xC2\x9B \xC3\xA4 \xE2\x80\xAE"),
            "\\u001b[31m\\u0009\n\\u009b \xC3\xA4 \\u202e");
  EXPECT_EQ(with_unicode_escapes("\xE4"), "\xEF\xBF\xBD");
  EXPECT_EQ(without_controls("\x1b[31m\t\n\xC2\x9B \xC3\xA4 \xE4"), "[31m\t\n \xC3\xA4 \xEF\xBF\xBD");
}

TEST(Utf8, LineBreaksStayWhereTheyAreMeant) {
  EXPECT_EQ(terminal_safe("a\tb\nc"), "a\tb\nc");
  EXPECT_EQ(terminal_safe("a\tb\nc", LineBreaks::escaped), "a\tb\\nc");
}

}  // namespace
}  // namespace kalfem

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace kalfem {

/// Length in bytes of the UTF-8 sequence that begins at `at`. 0 where none does: a stray continuation byte, an overlong
/// form, a surrogate, a number above U+10FFFF, or a sequence that is cut off.
std::size_t utf8_length(std::string_view text, std::size_t at);

/// The text with U+FFFD in place of each byte that is no UTF-8. JSON and HTML need valid UTF-8.
std::string valid_utf8(std::string_view text);

/// The text as it is where it is UTF-8; otherwise its bytes are characters of Windows-1252, the Latin-1 of Windows.
std::string to_utf8(std::string_view text);

/// UTF-8 of a text in UTF-16; half of a pair of surrogates becomes U+FFFD.
std::string utf8_of(std::u16string_view text);

/// Text inside of a quoted string of JSON or YAML: characters that a terminal obeys become `\u001b`, so that the file
/// can be shown there, and bytes that are no UTF-8 become U+FFFD. Line breaks stay.
std::string with_unicode_escapes(std::string_view text);

/// The text without control characters other than tabs and line breaks, and in valid UTF-8, as HTML and XML need it.
std::string without_controls(std::string_view text);

enum class LineBreaks { kept, escaped };

/// Text that is safe to print. A terminal obeys control characters, so that a title or a name could erase what stands
/// before it or change the window. They are shown as `\x1b`, as are bytes that are no UTF-8; characters that turn the
/// direction of writing are shown as `\u202e`. Tabs are kept, line breaks where `breaks` says so.
std::string terminal_safe(std::string_view text, LineBreaks breaks = LineBreaks::kept);

/// ASCII letters in capitals; everything else as it is, whatever the locale.
std::string upper_case(std::string_view text);
/// ASCII letters in small letters.
std::string lower_case(std::string_view text);

/// Text for the content or a quoted attribute of HTML, SVG and XML: markup characters escaped, control characters that
/// XML does not allow left out, bytes that are no UTF-8 replaced by U+FFFD.
std::string escaped(std::string_view text);

}  // namespace kalfem

#pragma once

#include <string>
#include <string_view>

namespace kalfem {

/// ASCII letters in capitals; everything else as it is, whatever the locale.
std::string upper_case(std::string_view text);
/// ASCII letters in small letters.
std::string lower_case(std::string_view text);

/// Text for the content or a quoted attribute of HTML, SVG and XML: markup characters escaped, control characters that
/// XML does not allow left out, bytes that are no UTF-8 replaced by U+FFFD.
std::string escaped(std::string_view text);

}  // namespace kalfem

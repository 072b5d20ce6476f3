#pragma once

#include <string>
#include <string_view>

namespace kalfem {

/// A message about a line of an included file, without what it quotes of it. Whoever gets a deck from somebody else
/// reads it with his own permissions: an INCLUDE of a file that is no deck must not print that file's lines. Place and
/// reason stay, and so do quoted numbers.
///
/// What stands from the first opening quotation mark ' to the last one becomes '...'.
std::string without_quotations(std::string_view message);

}  // namespace kalfem

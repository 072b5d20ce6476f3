// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace kalfem {

/// Whether the bytes begin as a gzip file does.
bool is_gzip(std::string_view bytes);

/// Content of a gzip file (of one or several members) or of a zlib stream [RFC 1950, RFC 1952]. `source` names it in
/// messages. Throws InvalidInput where it is damaged, cut off, or longer than `most` bytes.
std::string uncompressed(std::string_view bytes, const std::string& source, std::size_t most);

/// Its length, or any number above `most` where it is longer. Holds none of it.
std::size_t uncompressed_size(std::string_view bytes, const std::string& source, std::size_t most);

/// Its first `most` bytes.
std::string uncompressed_head(std::string_view bytes, const std::string& source, std::size_t most);

/// A message about a line of an included file, without what it quotes of it. Whoever gets a deck from somebody else
/// reads it with his own permissions: an INCLUDE of a file that is no deck must not print that file's lines. Place and
/// reason stay, and so do quoted numbers.
///
/// What stands from the first opening quotation mark ' to the last one becomes '...'.
std::string without_quotations(std::string_view message);

}  // namespace kalfem

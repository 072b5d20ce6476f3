// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "kalfem/base/text.hpp"

namespace kalfem::nastran {

/// The whole number that fills the field, or nothing.
std::optional<std::int64_t> parse_integer(std::string_view field);

/// The finite number that fills the field, or nothing: 1.5, .5, 7, 1.5E3, 1.5e+3, 1.5D3, and 1.5+3 or 1.5-3 with the
/// exponent after its sign alone.
std::optional<double> parse_real(std::string_view field);

/// Numbers of nodes, elements, properties: whole, up to 2^31 - 1.
using Id = std::int32_t;

/// Where a card begins: the file by its position among those that were read, and the 1-based line.
struct Place {
  std::int32_t file = 0;
  std::int32_t line = 0;
};

/// Numbers first, first + step, ... up to last. Of a range missing ones do no harm, a single one must exist.
struct IdRange {
  Id first = 0, last = 0, step = 1;
  bool single = true;
};

/// A card that cannot be understood; the reader adds its place and goes on with the next one.
class CardError : public std::runtime_error {
public:
  explicit CardError(const std::string& what, std::string why = {}, std::string fix = {})
      : std::runtime_error(what), why_(std::move(why)), fix_(std::move(fix)) {}
  [[nodiscard]] const std::string& why() const { return why_; }
  [[nodiscard]] const std::string& fix() const { return fix_; }

private:
  std::string why_, fix_;
};

/// What a reader has made of a field of its card so far.
enum class FieldUse : char { untouched, used, told };

/// One card of the bulk data with its continuations: a name and data fields, eight to a line of it, counted from 1.
/// Field 1 is the one after the name, field 9 the first of the second line; markers of continuations are left out.
/// Fields that are not there are blank. Every accessor of a value throws CardError for a field that is not what it asks
/// for, `what` names the field as the manual does, and marks it as used: what a reader leaves untouched is told of, see
/// card_ledger.hpp. To look whether a field is blank, a number or a certain word marks none.
struct Card {
  std::string name;  ///< in capitals, without '*'
  Place place;
  std::vector<std::string_view> fields;     ///< trimmed, of the text that the reader holds
  mutable std::vector<FieldUse> uses = {};  ///< of the first fields; the others are untouched

  [[nodiscard]] std::size_t size() const { return fields.size(); }  ///< last field that may be filled
  [[nodiscard]] std::string_view raw(std::size_t i) const {
    return i >= 1 && i <= fields.size() ? fields[i - 1] : std::string_view{};
  }
  [[nodiscard]] bool blank(std::size_t i) const { return raw(i).empty(); }
  [[nodiscard]] bool is_integer(std::size_t i) const;
  [[nodiscard]] bool is_number(std::size_t i) const;    ///< whole or real
  [[nodiscard]] std::string text(std::size_t i) const;  ///< in capitals
  /// Whether this word, in capitals, stands in the field, which then is used.
  [[nodiscard]] bool says(std::size_t i, std::string_view word) const;
  void mark(std::size_t i, FieldUse use) const;
  [[nodiscard]] FieldUse use(std::size_t i) const {
    return i >= 1 && i <= uses.size() ? uses[i - 1] : FieldUse::untouched;
  }

  [[nodiscard]] std::int64_t integer(std::size_t i, const char* what) const;
  [[nodiscard]] std::int64_t integer_or(std::size_t i, std::int64_t otherwise, const char* what) const;
  [[nodiscard]] Id id(std::size_t i, const char* what) const;                   ///< positive
  [[nodiscard]] Id id_or(std::size_t i, Id otherwise, const char* what) const;  ///< also 0 and -1
  [[nodiscard]] double real(std::size_t i, const char* what) const;
  [[nodiscard]] double real_or(std::size_t i, double otherwise, const char* what) const;
  /// Directions of a node as one bit each, 1 to 6 from bit 0; a blank field or 0 is none. Blanks between the digits
  /// count for nothing.
  [[nodiscard]] unsigned components(std::size_t i, const char* what) const;
  /// One direction, 0 .. 5; a blank field or 0, which is that of a scalar point, is 0.
  [[nodiscard]] int component(std::size_t i, const char* what) const;
  /// Positive numbers from field `first` on, to the end of the card: single ones, and "n THRU m" (BY k) (EXCEPT ...).
  [[nodiscard]] std::vector<IdRange> id_list(std::size_t first, const char* what) const;
};

/// "GRID 12" or "GRID" where the first field is no number.
std::string title(const Card& card);
/// "line 2, field 3": as the manual counts, the name being field 1 of each line of ten.
std::string place_on_card(std::size_t i);

}  // namespace kalfem::nastran

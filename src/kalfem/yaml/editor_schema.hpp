// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace kalfem {

/// The schema of a case file as editors and validators use it: with `$id`, and with everything that the reader takes
/// beside the values themselves. A number, a choice or a flag may be a text with ${NAME} or ${NAME:-default}, numbers
/// with units must begin as numbers do, a section may be empty, and names hold letters, digits, "_", "-" and dots.
nlohmann::ordered_json editor_schema(nlohmann::ordered_json whole);

}  // namespace kalfem

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace kalfem::command {

/// Adds the connector laws wherever a schema for editors has `law` and `parameters`: the names of the laws, each with
/// its equation, and for each law the names of its parameters.
void add_laws(nlohmann::ordered_json& schema);

}  // namespace kalfem::command

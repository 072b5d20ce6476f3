#pragma once

#include <functional>
#include <optional>
#include <string>

namespace kalfem {

/// Value of an environment variable, or nothing when it is not set.
using Environment = std::function<std::optional<std::string>(const std::string& name)>;

/// The variables of this process.
Environment process_environment();

/// Replaces ${NAME} and ${NAME:-default} (used when NAME is unset or empty; may hold further ${...}) by the variables'
/// values, which are not expanded again; $${ stands for a literal ${. Throws InvalidInput for a variable that is not
/// set and has no default, a bad name or a missing brace.
std::string expand_environment(const std::string& text, const Environment& environment);

}  // namespace kalfem

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/casefile/description.hpp"

namespace kalfem {

/// The name that a component's connector has everywhere: `force: component`, the unknown `component.k`.
inline const std::string component_name = "component";
/// The substructure without mass whose grounds carry the signals of laws; no case can use this name.
inline const std::string signal_grounds = "law signals";

/// The ground that carries a signal of a connector's law.
std::string signal_ground(const std::string& connector, const std::string& signal);

/// Writes a component and the signals of laws as what the rest of the program knows: a component is a connector between
/// two grounds that are moved; a signal is the motion of a ground that nothing but the law reads.
void expand_component(description::Case& given, IssueList& issues);

/// Whether a substructure consists of such grounds only.
bool consists_of_grounds(const std::string& name, const description::Case& given);

/// Key of a connector in the case file, for messages.
std::string key_of_connector(const std::string& name, const description::Case& given);

}  // namespace kalfem

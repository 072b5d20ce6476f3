// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace kalfem {

/// The page of what is watched, one HTML document: style and scripts inside. It reads the messages of MessageHistory
/// from "events" beside it, as server-sent events, and shows them as they come.
std::string live_page();

}  // namespace kalfem

// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kalfem::command {

/// What this program was built from, by what and for which processor: "commit 0123456789ab, Clang 16.0.6, any x86_64
/// processor". Written anew by build_stamp.cmake where one of these has changed.
extern const char* const build_stamp;

}  // namespace kalfem::command

// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kalfem {

/// For a program that makes and frees large matrices in turn, as an ordering or the runs of a sweep do: from now on the
/// process keeps up to 384 MB of what it frees for what it asks for next. Otherwise glibc returns it to the system
/// in between, and the kernel clears each page anew. Does nothing where the C library is another one.
void keep_freed_memory();

}  // namespace kalfem

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

// The only names of folders that tests are compiled with stand in places.cpp: objects of all other tests are the same
// in every folder, so that a cache of compiled files serves a second clone.

namespace kalfem::test {

/// The folder of the project's sources.
const std::string& source_folder();

/// The command as built, build/<preset>/bin/kalfem.
const std::string& command_file();

}  // namespace kalfem::test

// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kalfem::command {

/// The command kalfem in this process: runs what the arguments say (argv[0] is not looked at) and returns the exit
/// code, see ExitCode. Prints, and from then on handles SIGINT, SIGTERM, SIGPIPE and SIGXFSZ. For a process that does
/// nothing else: the program kalfem, and that of the Python package.
int command_line(int argc, char** argv);

}  // namespace kalfem::command

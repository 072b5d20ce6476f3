// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "kalfem/base/resumable.hpp"
#include "kalfem/live/filter_problem.hpp"
#include "kalfem/live/online_options.hpp"

namespace kalfem {

/// A hash of all that the numbers of a state belong to: the version, the structure's matrices, sensors, unknowns with
/// their priors, and the options.
std::string state_fingerprint(const FilterProblem& problem, const OnlineOptions& options);

/// The file: `state_magic`, then as an archive (lengths as 64-bit numbers, numbers as the processor holds them) three
/// texts: the fingerprint, what `state` keeps, and a hash of that. Replaced at once, so that a reader, or a start after
/// a crash, sees the old state or the new one. Throws as write_file_atomically() does.
void write_state_file(const std::filesystem::path& file, const std::string& fingerprint, const Resumable& state);

/// Throws InvalidInput where there is no such file, where it is damaged, and where it belongs to something else.
void read_state_file(const std::filesystem::path& file, const std::string& fingerprint, Resumable& state);

inline constexpr std::string_view state_magic = "kalfem live state 2\n";

}  // namespace kalfem

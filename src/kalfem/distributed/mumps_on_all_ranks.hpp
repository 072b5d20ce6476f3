// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "kalfem/distributed/mumps_instance.hpp"
#include "kalfem/distributed/service.hpp"

namespace kalfem::distributed {

/// The instances of all ranks that make up one factor, as rank 0 holds them: what it does, all ranks do.
class MumpsOnAllRanks {
public:
  explicit MumpsOnAllRanks(Service& service);
  ~MumpsOnAllRanks();
  MumpsOnAllRanks(const MumpsOnAllRanks&) = delete;
  MumpsOnAllRanks& operator=(const MumpsOnAllRanks&) = delete;

  /// Returns MUMPS' status, negative where it failed on any rank.
  int run(MumpsJob job);

  DMUMPS_STRUC_C& state() { return own_->state(); }
  [[nodiscard]] const DMUMPS_STRUC_C& state() const { return own_->state(); }

private:
  Service& service_;
  int number_;
  std::optional<MumpsInstance> own_;
};

}  // namespace kalfem::distributed

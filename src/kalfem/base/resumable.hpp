// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/base/binary_archive.hpp"

namespace kalfem {

/// An object that goes on elsewhere with the same bits: what all later steps depend on goes to an archive, and from
/// there into an object that was made in the same way.
class Resumable {
public:
  virtual ~Resumable() = default;
  virtual void keep(ArchiveWriter& archive) const = 0;
  /// Throws DamagedArchive where the bytes do not suffice.
  virtual void take_up(ArchiveReader& archive) = 0;
};

}  // namespace kalfem

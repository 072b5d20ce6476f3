// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/modal/modal_result.hpp"

namespace kalfem {

/// The modes of one set-up of a test whose sensors were moved between records.
struct SetupModes {
  std::string name;  ///< of its record; tells apart channels that several set-ups call alike
  ModalResult result;
};

struct MergeOptions {
  std::vector<std::string> references = {};  ///< channels that stay; empty: those that all set-ups have
  double frequency = 0.03;                   ///< largest difference of a mode between set-ups, relative
  double mac = 0.8;                          ///< least MAC of its shapes at the references; of one reference alone: 0
};

/// Modes of the whole structure from several set-ups with common reference sensors: each is identified alone, and its
/// shape is brought to the common one of the references [RMDC09],
///     alpha_i = r_i^H r / (r_i^H r_i),    r = mean of alpha_i r_i,
/// with the entries r_i of set-up i at the references. The merged shape is r, and alpha_i times the other entries of
/// each set-up. Covariances of the set-ups, which are independent of each other, pass through this to first order.
///
/// Frequency and damping are the means weighted by the inverses of the set-ups' covariances; their covariance is that
/// of the mean, times the scatter chi^2 / (n - 1) of the set-ups about it where this is larger than 1. A mode that a
/// set-up lacks is left out, with a remark. Channels: the references, then the others set-up by set-up.
///
/// Throws InvalidInput for fewer than two set-ups, and where a reference is missing or there is none.
ModalResult merge_setups(const std::vector<SetupModes>& setups, const MergeOptions& options = {});

}  // namespace kalfem

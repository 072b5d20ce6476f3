// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kalfem/api/estimate.hpp"

namespace kalfem::calibration {

/// What a random structure's record is made with beside the seed.
struct RandomRecordOptions {
  double periods = 0.0;    ///< of the slowest mode, its length; 0: 40 to 150
  bool lumped = false;     ///< no frames
  bool from_rest = false;  ///< always; otherwise a quarter of the records start in motion
};

/// What no sensor shows, and its truth at every sample.
struct Unmeasured {
  OutputRequest output;
  Eigen::VectorXd truth;
};

/// A record of a random structure and the right model of it: only what is to be estimated is unknown. The truth is
/// integrated by a method, of matrices and with laws that the tests write down themselves.
///
/// Kinds: trees and rings of two to six masses, and plane portal frames of beams with a strain gauge; one or two
/// forces, or a ground that is accelerated; all linear, or with one cubic spring, stop, or hysteretic element; one to
/// four accelerometers and displacement sensors with 1 to 10 % noise; five to twelve samples a period of the fastest
/// mode, or of the fastest that is excited; a start at rest
/// or, without a hysteretic element, in motion.
struct RandomRecord {
  std::string kind;
  Structure structure;  ///< driven, at the initial values
  Record record;
  EstimateOptions options;    ///< unknowns with initial values drawn from their priors
  std::vector<double> truth;  ///< of the unknowns
  double slowest = 0.0;       ///< natural frequency [Hz]
  /// Displacement of a point where no sensor of it stands, and the force of the nonlinear element; `options` do not
  /// ask for them.
  std::vector<Unmeasured> unmeasured;
};

RandomRecord random_record(std::uint64_t seed, const RandomRecordOptions& options = {});

}  // namespace kalfem::calibration

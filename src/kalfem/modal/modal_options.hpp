// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/base/progress.hpp"
#include "kalfem/records/spectrum.hpp"

namespace kalfem {

/// When poles of successive model orders count as the same mode, and when a mode is reported.
struct StabilisationOptions {
  double frequency = 0.01;         ///< largest difference of two orders, as a fraction of the frequency
  double damping = 0.5;            ///< largest difference of two orders, as a fraction of the larger damping ratio
  double mac = 0.8;                ///< least MAC of the shapes of two orders
  double largest_damping = 0.2;    ///< ratio to critical; poles beyond count as spurious
  double frequency_std = 0.02;     ///< largest standard deviation of a pole, as a fraction of its frequency
  double damping_std = 0.5;        ///< largest standard deviation of a pole, as a fraction of its damping ratio
  double least_share = 0.4;        ///< a mode stands in so many of the orders from its first one on
  double least_participation = 0;  ///< of the channels' variance that a mode carries
};

/// A pole of the stabilisation diagram that a person takes for a mode.
struct ChosenPole {
  double frequency = 0.0;  ///< [Hz]
  int order = 0;           ///< of its model; 0: the largest order that has a pole there
};

/// Of what the singular vectors are taken: of the correlations of future and past outputs, or of the projection of the
/// future onto the past (the unweighted principal components of data-driven identification), which counts each
/// combination of past outputs by what it tells and not by how large it is.
enum class SubspaceMethod { covariance, data };

/// How frequency responses are measured from the forces of a record.
struct ForcedRecordOptions {
  double segment = 0.0;  ///< length of a segment [s]; 0: such that sixteen, overlapping by half, cover the record
  SpectralWindow window = SpectralWindow::hann;  ///< rectangular where responses decay within a segment (blows)
  FrfEstimator estimator = FrfEstimator::h1;
};

/// How the modes of a record are identified.
struct ModalOptions {
  std::vector<std::string> channels = {};    ///< outputs; empty: all of the record
  std::vector<std::string> references = {};  ///< channels that all are correlated with; empty: all outputs
  /// Channels of the record that are the forces, or the motion of the base: modes are then identified from frequency
  /// responses to these. Empty: from responses alone.
  std::vector<std::string> inputs = {};
  ForcedRecordOptions forced = {};
  std::optional<FrequencyBand> band = {};  ///< wanted modes [Hz]: filters and resamples the record
  SubspaceMethod subspace = SubspaceMethod::covariance;
  int block_rows = 0;  ///< of the Hankel matrix: lags up to 2 block_rows - 1; 0: a period of the lowest
  int max_order = 0;   ///< largest order of the state-space models; 0: four a channel, from 30 to 100
  int blocks = 100;    ///< parts of the record whose scatter gives the covariance of the correlations
  StabilisationOptions stabilisation = {};
  std::vector<ChosenPole> poles = {};  ///< the modes, in place of those that stand in the diagram; empty: these
  int threads = 0;                     ///< 0: one per processor; results do not depend on it
  Progress progress = {};
};

}  // namespace kalfem

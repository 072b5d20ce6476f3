// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <string>
#include <vector>

namespace kalfem {

/// Order of the finite elements whose responses are computed.
enum class ResponseModel { full, reduced, both };
/// A basis of modes and residual vectors for all lines, or one factorisation a line.
enum class ResponseMethod { modal, direct };

/// A resonance in the magnitude of a frequency response.
struct ComputedPeak {
  double frequency = 0.0;         ///< natural frequency [Hz], of one pole fitted to the lines around it
  std::optional<double> damping;  ///< ratio to critical; nothing where the lines around it do not tell
  double magnitude = 0.0;         ///< of its highest line
};

/// How far the reduced model's H_r is from the full model's H. A resonance holds the lines around a peak with at least
/// 1 / sqrt(2) of its magnitude; all other lines lie between resonances.
struct ResponseDifference {
  std::optional<double> at_resonances;  ///< largest |H_r - H| / |H at the peak|; nothing without peaks
  std::optional<double> between;        ///< largest |H_r - H| / |H|; nothing without such lines
  double between_at = 0.0;              ///< where that is [Hz]
};

/// One frequency response; of the models that were not asked for it is empty.
struct ComputedResponse {
  std::string input, output;                     ///< qualified point or ground; point
  std::string name;                              ///< "frame.p6.z per force at frame.p1.z"
  std::string quantity, unit;                    ///< "acceleration", "(m/s^2)/N"
  Eigen::VectorXcd full, reduced;                ///< H, one a line
  std::vector<ComputedPeak> peaks;               ///< of the full model where it was asked for, ascending
  std::optional<ResponseDifference> difference;  ///< if both models were asked for

  /// The reduced model's only where that is the one asked for.
  [[nodiscard]] const Eigen::VectorXcd& best() const { return full.size() > 0 ? full : reduced; }
};

/// Size of a model and the time that its responses took.
struct ResponseCost {
  Eigen::Index dofs = 0;
  double seconds = 0.0;
};

/// Frequency responses of a structure, linear about rest.
struct FrequencyResponses {
  Eigen::VectorXd frequencies;              ///< [Hz]
  std::vector<ComputedResponse> responses;  ///< of the first input all outputs, then of the next one
  std::optional<ResponseCost> full, reduced;
  std::vector<std::string> warnings;  ///< reduced models that hold no modes at the highest lines
};

}  // namespace kalfem

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/records/mode_set.hpp"

namespace kalfem {

/// The same mode by another method: a peak of the first singular value of the cross-spectral matrix.
struct SpectralMode {
  double frequency = 0.0;  ///< of the peak [Hz]
  double mac = 0.0;        ///< of the first singular vector there with the identified shape
};

/// A mode that was identified, with the covariance of what was found.
struct IdentifiedMode {
  double frequency = 0.0;            ///< undamped natural frequency [Hz]
  double damping = 0.0;              ///< ratio to critical
  Eigen::Matrix2d covariance;        ///< of frequency [Hz] and damping
  double degrees_of_freedom = 0.0;   ///< of the standard deviations: how well the record tells them
  Eigen::VectorXcd shape;            ///< one a channel, in its unit; the largest entry is 1
  Eigen::MatrixXd shape_covariance;  ///< of the real parts, then the imaginary ones, 2 channels x 2 channels
  double phase_collinearity = 1.0;   ///< MPC in [0, 1]: 1 where all channels move in phase or against it [PES93]
  double participation = 0.0;        ///< share of the references' variance, each in units of its own
  int order = 0;                     ///< of the model that it is taken from
  int orders = 0;                    ///< in which it was found
  std::optional<SpectralMode> spectral = {};  ///< nothing where the spectra have no peak there

  [[nodiscard]] double frequency_std() const;
  [[nodiscard]] double damping_std() const;
  /// Standard deviation of the real and of the imaginary part of each entry of the shape.
  [[nodiscard]] Eigen::VectorXcd shape_std() const;
  /// Half the width of a 95 % interval over its standard deviation: 1.96, more by Student's t where the record is
  /// short.
  [[nodiscard]] double coverage_factor() const;
};

/// A pole of a model of some order, for the stabilisation diagram.
struct DiagramPole {
  int order = 0;
  double frequency = 0.0;  ///< [Hz]
  double damping = 0.0;
  double frequency_std = 0.0;  ///< [Hz]
  bool stable = false;         ///< it belongs to a mode that is reported
};

/// How modes are identified.
enum class ModalMethod {
  subspace,          ///< of responses alone, covariance-driven stochastic subspace identification
  rational_fraction  ///< of frequency responses: p-LSCF, then a modal model fitted by least squares
};

/// The modes of a record or of frequency responses, and how they were found.
struct ModalResult {
  std::vector<std::string> channels;  ///< of the shapes
  std::vector<std::string> units;
  std::vector<std::string> references;  ///< of frequency responses the inputs
  double sample_rate = 0.0;             ///< of the samples that were used [Hz]; 0 of frequency responses
  Eigen::Index samples = 0;             ///< of frequency responses the lines
  int block_rows = 0, max_order = 0, blocks = 0;
  ModalMethod method = ModalMethod::subspace;
  std::vector<IdentifiedMode> modes;  ///< by frequency
  std::vector<DiagramPole> diagram;   ///< every pole of every order
  std::vector<std::string> remarks;   ///< doubts about the settings and the record, a sentence each
};

/// The modes with the covariance of their shapes, as an updating or a correlation takes them.
ModeSet mode_set(const ModalResult& result);

}  // namespace kalfem

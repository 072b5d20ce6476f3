// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/updating/frf_record_residual.hpp"

namespace kalfem {

/// What a record leaves open beside the parameters, as FrfRecordResidual states it: columns Phi that the free motion at
/// its ends, its input between the samples and free factors may add to the spectra, over their prior and over sigma.
/// Rows are lines, outputs, Re and Im.
class LeakageColumns {
public:
  /// Of the set's model at one value of its parameters. With a free scale, H U of the responses that share a factor are
  /// further columns.
  LeakageColumns(const FrfEvaluation& evaluation, std::size_t set, const ComparedSpectra& spectra, FrfScale scale);

  [[nodiscard]] const Eigen::MatrixXd& columns() const { return columns_; }
  /// H U, lines x outputs.
  [[nodiscard]] const Eigen::MatrixXcd& forced() const { return forced_; }
  /// p_0 + s p_1 on the shapes of the basis.
  [[nodiscard]] Eigen::VectorXcd load(const Eigen::VectorXd& amplitudes, std::complex<double> s) const;
  /// 1 + a_0 + a_1 x^2 + a_2 x^4 + i a_3 x, the factor of the input at a line; x = f over half the sampling rate.
  [[nodiscard]] std::complex<double> input_factor(const Eigen::VectorXd& amplitudes, double line) const;
  /// Factor of each output's H; 1 where the scale is fixed.
  [[nodiscard]] Eigen::VectorXd factors(const Eigen::VectorXd& amplitudes) const;

private:
  struct FreeMode {
    Eigen::Index shape = 0;
    double omega = 0.0;  ///< [rad/s]
    double prior = 0.0;  ///< deviation of p_0, and of omega p_1
  };
  void find_modes(const FrfEvaluation& evaluation, std::size_t set, const ComparedSpectra& spectra);
  void add_smooth_parts(const ComparedSpectra& spectra, Eigen::Index first);

  std::vector<FreeMode> modes_;
  std::vector<std::vector<Eigen::Index>> scaled_;  ///< outputs of each free factor
  Eigen::MatrixXcd forced_;
  Eigen::MatrixXd columns_;
  Eigen::Index outputs_ = 0, shapes_ = 0;
  double half_rate_ = 0.0;  ///< of the sampling [Hz]
};

/// (I + Phi Phi^T)^(-1/2) and the amplitudes' best values, by Phi = Q R and R = U S V^T.
class LeakageProjection {
public:
  explicit LeakageProjection(const Eigen::MatrixXd& columns);

  /// (I + Phi Phi^T)^(-1/2) times some columns.
  [[nodiscard]] Eigen::MatrixXd whitened(Eigen::MatrixXd columns) const;
  /// argmin |r + Phi eta|^2 + |eta|^2.
  [[nodiscard]] Eigen::VectorXd amplitudes(const Eigen::VectorXd& residual) const;

private:
  Eigen::HouseholderQR<Eigen::MatrixXd> qr_;
  Eigen::JacobiSVD<Eigen::MatrixXd> svd_;
};

}  // namespace kalfem

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/records/local_rational.hpp"
#include "kalfem/records/record_spectra.hpp"
#include "kalfem/updating/frf_model.hpp"
#include "kalfem/updating/frf_residual.hpp"
#include "kalfem/updating/frf_scale.hpp"
#include "kalfem/updating/residual.hpp"

namespace kalfem {

/// A record of one input, and what it was measured at: column j of the outputs is set.outputs[j].
struct FrfRecord {
  std::string name;       ///< for messages: the file
  RecordSpectra spectra;  ///< from the first to the last line of the bands
  LocalRationalFit fit;   ///< of these lines
  FrfSet set;
};

/// Spectra of a record between the limits of the bands (empty: all lines), with noise and FRFs by fit_local_rational().
/// `outputs` are the record's channels, in the order of set.outputs. Throws InvalidInput as the two functions do.
FrfRecord frf_record(std::string name, const Record& record, const std::string& input,
                     const std::vector<std::string>& outputs, FrfSet set, const std::vector<FrequencyBand>& bands);

/// What is compared of a record: its lines in the bands.
struct ComparedSpectra {
  Eigen::VectorXd lines;       ///< [Hz]
  Eigen::VectorXcd input;      ///< U
  Eigen::MatrixXcd outputs;    ///< Y, lines x outputs
  Eigen::MatrixXd deviations;  ///< sigma of Re Y and of Im Y, lines x outputs
  Eigen::VectorXd edges;       ///< see RecordSpectra
  double sample_rate = 1.0;    ///< [Hz]
};

/// A model against the spectra of records, by its FRFs H(i omega; theta), without windows and so without their bias:
///     Y_k = H U_k + T_k + E_k,     T_k = s^(q - p) S V Z^-1 (p_0 + s p_1) + polynomial of f + ramp,   s = i omega_k.
/// T is what the free motion at both ends of the record leaves in the spectra of a finite part ("leakage"): it has the
/// poles of the model, so its shape is known and only the amplitudes of the modes are not [PS12, section 6.3.2]. Modes
/// outside of the bands, and the sampling, add a smooth part: a polynomial of degree 2 an output and run of lines. A
/// linear trend of a channel is the ramp, 1 / f.
///
/// The amplitudes have a prior of mean 0: three times the motion at the ends of the record (RecordSpectra::edges). So
/// a record that starts and ends at rest determines the size of H too, and one that is cut out of a vibration only by
/// what the amplitudes leave of it. With Phi the amplitudes' columns over their prior and the noise, the residual is
///     r = (I + Phi Phi^T)^(-1/2) (H U - Y) / sigma,
/// white with unit variance for the right model; amplitudes at their best estimate enter the derivatives (variable
/// projection, [GP73; Kau75]). A free factor (FrfScale) is another amplitude, with a wide prior.
///
/// The input is known at its samples only. U takes it as band-limited in between; a factor of it,
///     1 + a_0 + a_1 x^2 + a_2 x^4 + i a_3 x,   x = f over half the sampling rate,
/// with priors of 0.01 for a_0 and 1 for the others, holds inputs that are linear between samples, and delays of a
/// fraction of one. What such an input excites about the sampling rate f_s, and sampling folds back without a filter,
/// is a_4 x^2 H(f_s) U, with a prior of 1 for each output.
///
/// sigma^2 is half of E |E_k|^2, from fit_local_rational(): every line counts as its noise lets it. A relative
/// deviation is added only if it is stated. Structures that the model does not follow so closely show as large
/// residuals.
class FrfRecordResidual final : public Residual {
public:
  /// Of the options bands, scale, basis and relative_deviation (of Y; 0: noise only) are used. Throws InvalidInput
  /// where a record has no line in the bands or its places do not exist.
  FrfRecordResidual(std::shared_ptr<const ParameterisedModel> model, const std::vector<FrfRecord>& records,
                    const Eigen::VectorXd& start, const FrfResidualOptions& options);

  [[nodiscard]] std::string name() const override { return "frequency responses"; }
  [[nodiscard]] Eigen::Index size() const override { return size_; }
  /// Steps are frequency lines; parts are records, or outputs of a single one.
  [[nodiscard]] RowLayout layout() const override;
  [[nodiscard]] std::optional<ResidualValue> evaluate(const Eigen::VectorXd& parameters,
                                                      bool with_jacobian) const override;

private:
  FrfScale scale_;
  std::vector<ComparedSpectra> compared_;
  std::optional<FrfModel> model_;
  Eigen::Index size_ = 0;
};

/// The local rational fits of records, to be compared as the FRFs of a file.
std::vector<MeasuredFrf> local_rational_responses(const std::vector<FrfRecord>& records);

}  // namespace kalfem

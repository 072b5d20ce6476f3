// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <complex>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/records/frequency_response.hpp"
#include "kalfem/updating/frf_model.hpp"
#include "kalfem/updating/frf_scale.hpp"
#include "kalfem/updating/residual.hpp"

namespace kalfem {

/// FRFs of one input and what they are measured at: column j of the response is set.outputs[j].
struct MeasuredFrf {
  std::string name;  ///< for messages: the file
  FrequencyResponse response;
  FrfSet set;
};

/// How model and measurement are compared at a line, with sigma the deviation of Re H and of Im H:
enum class FrfForm {
  log,            ///< Re and Im of ln(H_model / H) |H| / sigma: logarithms of the magnitudes, and phases in (-pi, pi]
  log_magnitude,  ///< only the logarithms of the magnitudes
  complex_difference  ///< Re and Im of (H_model - H) / sigma: near the solution only, for lightly damped structures
};

struct FrfResidualOptions {
  FrfForm form = FrfForm::log;
  FrfScale scale = FrfScale::fixed;
  std::vector<FrequencyBand> bands = {};  ///< lines that are used; empty: all above 0

  /// Half width w at half height [Hz] to which both FRFs' resonances are widened; 0: they are left as they are. See
  /// FrfResidual.
  double smoothing = 0.0;

  /// Deviation, where none is measured, sigma^2 = (relative |H|)^2 + (floor H_rms)^2 with H_rms of the column's lines
  /// in use. Where one is measured, the relative part is added to its square: it stands for calibration and for what
  /// the model cannot do.
  double relative_deviation = 0.05;
  double floor = 0.05;

  /// Refuse measurements whose size does not fit the model at the start (see FrfResidual). Where the scale is free only
  /// a power of omega is refused.
  bool check_size = true;
  ResponseBasisOptions basis = {};
};

/// FRFs of a model against measured ones at lines of the measurement, r in the order of the sets, lines and outputs,
/// two values each (one for log_magnitude).
///
/// Smoothing by a width w [Hz] compares the responses times exp(-2 pi w t), which shows a structure with damping
/// rates greater by 2 pi w: peaks become so wide that those of a poor start still overlap with the measured ones, and
/// the residual has no minimum in between. The model is evaluated at s = 2 pi (w + i f); the measured FRF, analytic for
/// Re s > 0, is carried there by Poisson's integral over its lines [Hof62],
///     H(2 pi (w + i f)) = (1/pi) integral w / ((f - f')^2 + w^2) H(i 2 pi f') df',   H(-f') = conj H(f'),
/// normalised to the part of the kernel that the measured lines cover. Lines where that is less than 3/4 are left out,
/// and lines are taken no closer than w / 2, as neighbours become alike. Continuation: minimise with a width of the
/// order of the frequency errors, start from there with smaller widths, and end with 0 (smoothing_widths()).
///
/// Where lines are further apart than a resonance's half-power width, the sum over lines differs from the integral by
/// a few percent near it: the last search should be without smoothing. Damping is seen only with a width below or about
/// zeta f: at greater ones it should have a prior or bounds.
class FrfResidual final : public Residual {
public:
  /// Throws InvalidInput with everything that does not fit: unknown points, numbers of columns, frequencies that do not
  /// ascend or are not finite, bands without lines or far beyond the model's highest frequency, phases that the form
  /// needs, and measurements that differ from the model at `start` by a unit: by 9.81, by 100 or more either way, or by
  /// a power of omega.
  FrfResidual(std::shared_ptr<const ParameterisedModel> model, const std::vector<MeasuredFrf>& measured,
              const Eigen::VectorXd& start, FrfResidualOptions options = {});

  [[nodiscard]] std::string name() const override { return "frequency responses"; }
  [[nodiscard]] Eigen::Index size() const override { return size_; }
  /// Steps are frequency lines, over all inputs and outputs together; parts are inputs, or outputs of a single input.
  [[nodiscard]] RowLayout layout() const override;
  [[nodiscard]] std::optional<ResidualValue> evaluate(const Eigen::VectorXd& parameters,
                                                      bool with_jacobian) const override;

  /// Of each output, shared by all inputs ("tip.z.gain"), and of what measures each input ("input.tip.z.gain").
  [[nodiscard]] std::vector<ComparedGain> gains() const override;
  [[nodiscard]] std::optional<Eigen::MatrixXd> by_gains(const Eigen::VectorXd& parameters) const override;

  /// What is compared, smoothed, one entry a set; deviations are filled in.
  [[nodiscard]] const std::vector<FrequencyResponse>& compared() const { return compared_; }
  /// Inputs and outputs, one entry a set.
  [[nodiscard]] const std::vector<FrfSet>& sets() const { return model_->sets(); }
  /// The model's FRFs at these lines. Throws InvalidInput where there is no model.
  [[nodiscard]] std::vector<Eigen::MatrixXcd> model_responses(const Eigen::VectorXd& parameters) const;
  [[nodiscard]] bool has_free_scale() const { return options_.scale != FrfScale::fixed; }
  /// The best factors on these responses of the model, one an output of each set; 1 where the scale is fixed.
  [[nodiscard]] std::vector<Eigen::VectorXd> scales(const std::vector<Eigen::MatrixXcd>& model) const;

private:
  [[nodiscard]] std::complex<double> laplace_variable(double line) const;

  FrfResidualOptions options_;
  std::vector<FrequencyResponse> compared_;
  std::optional<FrfModel> model_;
  Eigen::Index size_ = 0;
};

/// Widths for a continuation from `widest` down to `narrowest`, each a third of the one before, and then 0 [Hz].
std::vector<double> smoothing_widths(double widest, double narrowest);

/// The FRFs of a continuation, the least smoothed ones; null: it has none. Spectra of a record come after its FRFs.
const FrfResidual* finest_responses(const std::vector<ResidualPtr>& continuation);

/// Measured FRFs that cannot be compared with any model: sizes, values that are not finite, frequencies that do not
/// ascend, phases that are not there, options out of range. Throws InvalidInput with all of them.
void check_measured(const std::vector<MeasuredFrf>& measured, const FrfResidualOptions& options);

/// Throws InvalidInput where no lines of an FRF are left in the bands, or some value there is exactly zero.
void check_lines(const std::vector<MeasuredFrf>& measured, const std::vector<FrequencyResponse>& compared,
                 const FrfResidualOptions& options);

/// Throws InvalidInput where lines lie beyond three times the highest frequency of a model all of whose modes are
/// known: there it has its mass only.
void check_range(const std::vector<MeasuredFrf>& measured, const std::vector<FrequencyResponse>& compared,
                 const ResponseBasis& basis, const ResponseBasisOptions& options);

/// Measured against model FRFs of a start that is not far off: throws InvalidInput where the median of |H| / |H_model|
/// over lines and outputs is like a unit (9.81 or above 100, or their inverses), or goes like a power of omega.
void check_size(const std::vector<MeasuredFrf>& measured, const std::vector<FrequencyResponse>& compared,
                const std::vector<Eigen::MatrixXcd>& model, const FrfResidualOptions& options);

}  // namespace kalfem

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/model/parameterised_model.hpp"
#include "kalfem/updating/eigen_sensitivities.hpp"
#include "kalfem/updating/measured_mode.hpp"
#include "kalfem/updating/mode_pairing.hpp"
#include "kalfem/updating/residual.hpp"
#include "kalfem/updating/shape_errors.hpp"

namespace kalfem {

struct ModalResidualOptions {
  int skip = 0;        ///< so many of the lowest modes are not elastic ones
  double above = 0.0;  ///< [Hz] nor are those up to this frequency at the starting parameters: motions on soft supports
  std::optional<int> modes = {};    ///< elastic modes to compute; none: half more than are measured or named, and 6
  ModePairingOptions pairing = {};  ///< at the start; least_mac holds there
  double lost_mac = 0.2;            ///< below it a mode that was paired is lost: the residual has no value there
  double repeated = 1e-6;           ///< relative difference of eigenvalues that count as one, see group_modes()
  double close = 0.1;               ///< of those whose modes may change places: see with_close_modes_joined()
  EigenSensitivityOptions sensitivities = {};
};

/// All measured modes beside those of the model.
struct ModePairing {
  std::vector<PairedMode> pairs;  ///< one a measured mode
  Eigen::VectorXd frequencies;    ///< of the model's elastic modes [Hz]
  Eigen::MatrixXd mac;            ///< measured x elastic modes; as PairedMode::mac where no shape was measured
};

/// Natural frequencies and mode shapes against measured ones:
///     (f_model - f_measured) / deviation        one a measured mode, in the given order,
///     L^-1 (P Phi c - phi_measured)             then the measured entries of those with a shape,
///     (zeta_model - zeta_measured) / deviation  then those with a damping,
/// with P the rows of the measured points, L L^T the covariance of the entries (see ShapeErrors; by itself
/// shape_deviation max |phi_measured| on the diagonal) and c the least-squares fit: the modal scale factor of a single
/// mode, and a combination of the modes of a repeated eigenvalue. All are differentiated exactly, c included (as of a
/// projector, [GP73]).
///
/// The model's damping ratio is phi^T C phi / (2 omega) beside the ratio of its modal damping: that of the complex mode
/// where C leaves the modes uncoupled, and to first order in the coupling otherwise.
///
/// Modes are paired anew at every evaluation, see pair_modes(). A measured mode with a shape is recognised by it; at
/// the start it may lie in the space of close modes that the model mixes otherwise. One without a shape, or with a
/// model_mode, is paired at the start (by its number, or by order among those still free) and then recognised by the
/// shape that the model had there, weighted with the mass: so crossings are survived. In a group of repeated
/// eigenvalues the frequencies are differentiated along the combinations that are nearest to the shapes by which they
/// are recognised; at the start without shapes, along those that the parameters split.
class ModalResidual final : public Residual {
public:
  /// Throws InvalidInput with everything that is wrong: points that the model does not have, values that are not
  /// physical, measured modes that pair with nothing at the start, dampings of a model that has none.
  ModalResidual(std::shared_ptr<const ParameterisedModel> model, std::vector<MeasuredMode> measured,
                std::vector<DofCombination> points, const Eigen::VectorXd& start, ModalResidualOptions options = {});

  [[nodiscard]] std::string name() const override { return "modes"; }
  [[nodiscard]] Eigen::Index size() const override { return size_; }
  /// Steps are modes: a frequency and its shape together.
  [[nodiscard]] RowLayout layout() const override;
  [[nodiscard]] std::optional<ResidualValue> evaluate(const Eigen::VectorXd& parameters,
                                                      bool with_jacobian) const override;

  /// The same where close modes count as one group, so that a measured shape need only lie in the space of them, with
  /// the frequency along it: smooth where two modes cross and mix. Its minimum is a start for the search of this
  /// residual's. Derivatives of frequencies leave out the turning of the shape within the group.
  [[nodiscard]] std::shared_ptr<const ModalResidual> with_close_modes_joined() const;

  /// At these parameters. Throws InvalidInput where the model has no modes there.
  [[nodiscard]] ModePairing compare(const Eigen::VectorXd& parameters) const;
  [[nodiscard]] const std::vector<MeasuredMode>& measured() const { return measured_; }
  [[nodiscard]] Eigen::Index skipped() const { return skip_; }  ///< lowest modes that are not elastic ones

private:
  struct Solution;
  struct Place;
  [[nodiscard]] Solution solve(const Eigen::VectorXd& parameters) const;
  [[nodiscard]] Solution solve_first(const Eigen::VectorXd& start);
  void require_damping(const Solution& solution, const std::vector<ModePair>& pairs) const;
  void choose_references(const Solution& solution, const std::vector<ModePair>& pairs, const Eigen::VectorXd& start);
  [[nodiscard]] std::vector<ModePair> first_pairs(const Solution& solution) const;
  [[nodiscard]] std::vector<ModePair> pairs(const Solution& solution, double least_mac) const;
  [[nodiscard]] SubspaceFit fit_shape(std::size_t mode, const Solution& solution, const ModeGroup& group) const;
  [[nodiscard]] SubspaceFit fit_reference(std::size_t mode, const Solution& solution, const ModeGroup& group) const;
  [[nodiscard]] SubspaceFit recognise(std::size_t mode, const Solution& solution, const ModeGroup& group) const;
  [[nodiscard]] Eigen::MatrixXd agreement(const Solution& solution, const std::vector<ModeGroup>& groups) const;
  [[nodiscard]] std::optional<std::vector<Place>> places(const Solution& solution) const;
  [[nodiscard]] Eigen::VectorXd direction(std::size_t mode, const std::vector<Place>& places,
                                          const Solution& solution) const;
  using Slopes = std::map<Eigen::Index, std::vector<Eigen::MatrixXd>>;
  [[nodiscard]] static double model_damping(const Place& place, const Solution& solution);
  [[nodiscard]] Eigen::VectorXd values(const std::vector<Place>& places, const Solution& solution) const;
  [[nodiscard]] std::optional<Slopes> slopes(const Solution& solution, const std::vector<Place>& places,
                                             const std::vector<ModelDerivative>& derivatives) const;
  [[nodiscard]] static double damping_slope(const Place& place, const Solution& solution,
                                            const ModelDerivative& derivative, const Eigen::MatrixXd& dPhi,
                                            double frequency_slope);
  [[nodiscard]] std::optional<Eigen::MatrixXd> jacobian(const Solution& solution, const std::vector<Place>& places,
                                                        const std::vector<ModelDerivative>& derivatives) const;

  std::shared_ptr<const ParameterisedModel> model_;
  std::vector<MeasuredMode> measured_;
  std::vector<std::optional<ShapeErrors>> errors_;  ///< of those with a shape
  std::vector<DofCombination> points_;
  ModalResidualOptions options_;
  Eigen::Index size_ = 0;
  SparseMatrix rows_;        ///< P, points x n
  Eigen::Index skip_ = 0;    ///< lowest modes that are not elastic ones
  Eigen::Index count_ = 0;   ///< modes to compute, the skipped ones with them
  SparseMatrix start_mass_;  ///< M at the start; 0 x 0 where every mode is recognised by its measured shape
  std::vector<Eigen::VectorXd> references_;  ///< M phi at the start, by measured mode; empty: its shape is measured
};

}  // namespace kalfem

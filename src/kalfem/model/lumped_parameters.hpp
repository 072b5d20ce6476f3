#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/model/lumped.hpp"
#include "kalfem/model/parameterised_model.hpp"

namespace kalfem {

/// One number of a lumped substructure that may be a parameter.
struct LumpedParameter {
  enum class Kind { stiffness, damping, mass, modal_ratio, all_modal_ratios, mass_factor, stiffness_factor };
  Kind kind = Kind::stiffness;
  std::size_t element = 0;  ///< index of the spring, mass or ratio
};

/// "<spring>.stiffness", "<spring>.damping", "<mass>.mass", "damping.modal" (all ratios as one), "damping.modal.<i>"
/// (the i-th given one), "damping.mass_factor", "damping.stiffness_factor".
std::vector<std::pair<std::string, LumpedParameter>> parameters_of(const LumpedSubstructure& substructure);

std::string unit_of(LumpedParameter::Kind kind);
double value_of(const LumpedSubstructure& substructure, const LumpedParameter& parameter);
void set_value(LumpedSubstructure& substructure, const LumpedParameter& parameter, double value);

/// theta[index] is the value of the target.
template <class Target>
struct ParameterBinding {
  Eigen::Index index = 0;
  Target target;
};

/// A lumped substructure whose numbers follow theta. Springs, dashpots and masses are in K, C and M linearly.
class ParameterisedLumped final : public ParameterisedModel {
public:
  /// `count`: length of theta, of which this substructure may use only a few entries.
  ParameterisedLumped(LumpedSubstructure substructure, std::vector<ParameterBinding<LumpedParameter>> bindings,
                      Eigen::Index count);

  [[nodiscard]] LumpedSubstructure substructure_at(const Eigen::VectorXd& parameters) const;
  [[nodiscard]] ModelAtParameters at(const Eigen::VectorXd& parameters) const override;
  [[nodiscard]] std::vector<ModelDerivative> derivatives(const Eigen::VectorXd& parameters) const override;

private:
  LumpedSubstructure substructure_;
  std::vector<ParameterBinding<LumpedParameter>> bindings_;
  Eigen::Index count_;
};

}  // namespace kalfem

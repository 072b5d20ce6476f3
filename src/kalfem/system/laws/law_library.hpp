#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/connector_law.hpp"
#include "kalfem/system/laws/expression_law.hpp"
#include "kalfem/system/laws/laws.hpp"

namespace kalfem {

/// What some laws need beside their name; the other laws ignore it.
struct LawArguments {
  /// Names of the parameters that the case gives. polynomial: k1 .. kN, c1 .. cM set the degrees; expression: its
  /// parameters.
  std::vector<std::string> parameter_names = {};
  LinearNominal nominal = {};                ///< linear_change
  std::string force = {};                    ///< expression
  std::vector<ExpressionState> states = {};  ///< expression
};

/// The law of that name, such as "saturating". Throws InvalidInput for an unknown name or unsuitable arguments.
ConnectorLawPtr make_law(const std::string& name, const LawArguments& arguments = {});

/// One entry of the schema. The parameters of polynomial and expression are examples.
struct LawDescription {
  std::string name;
  std::string equation;  ///< in one line of plain text
  std::string meaning;
  std::vector<LawQuantity> parameters;
  std::vector<LawQuantity> states;
};

/// Every law that make_law knows, in the order of a reference page.
std::vector<LawDescription> law_library();

/// Every value (in the order of law.parameters()) that is not finite or outside its range, or the one issue that their
/// number is wrong. Infinity passes where it is the default.
std::vector<Issue> validate_parameters(const ConnectorLaw& law, const Eigen::Ref<const Eigen::VectorXd>& values);

}  // namespace kalfem

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/diagnosis/candidates.hpp"
#include "kalfem/system/laws/expression_law.hpp"

namespace kalfem {

/// A force K g(d, v; s) that the law of a connector may lack: K is an unknown beside the others, the number s (where a
/// stop begins, how long a force lags) is searched.
struct LawTerm {
  std::string name;   ///< "stop (d > 0)"
  std::string force;  ///< of x, v, K and s
  std::vector<ExpressionState> states = {};
  std::string unit;                    ///< of K
  double deviation = 0.0;              ///< of K in its prior, about 0
  std::vector<double> starts = {0.0};  ///< of s; the one value 0: there is none
  double least = 0.0, most = 0.0;      ///< values that s may take
  std::string unit_of_place;           ///< of s
  std::string words;                   ///< "a stop"; with K and s behind it
  std::string laws;                    ///< of the library that have such a force

  [[nodiscard]] bool searched() const { return starts.front() != 0.0; }
};

/// What laws often lack, for a connector that moves so: stops on either side, another stiffness in tension than in
/// compression, another damping in rebound than in compression, forces that grow more or less than linearly with the
/// deformation or the rate, friction, hysteresis, a force that lags behind.
std::vector<LawTerm> law_terms(const ConnectorMotion& motion);

/// A term with its number.
struct ChosenTerm {
  LawTerm term;
  double place = 0.0;  ///< s
};

/// The connector needs these forces beside its law; the number of one of them is searched.
Hypothesis lacking_terms(const DiagnosisInput& input, const ConnectorDescription& connector,
                         const std::vector<ChosenTerm>& terms, std::size_t searched);

}  // namespace kalfem

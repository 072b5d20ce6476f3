// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>

namespace kalfem {

/// ln sum_i exp(x_i) without overflow or underflow; -infinity of none.
double log_sum_exp(const Eigen::Ref<const Eigen::VectorXd>& x);

/// P(M_i | data) = Z_i P(M_i) / sum_j Z_j P(M_j) from ln Z_i. `prior`: P(M_i), or weights of any sum; equal if empty.
/// Throws InvalidInput where an ln Z is not a number or +infinity, all are -infinity, or the prior does not fit.
Eigen::VectorXd model_probabilities(const Eigen::Ref<const Eigen::VectorXd>& log_evidence,
                                    const Eigen::Ref<const Eigen::VectorXd>& prior = Eigen::VectorXd());

/// The words of Kass and Raftery (1995, J. Am. Stat. Assoc. 90, 773-795) for a model with this ln B = ln Z_1 - ln Z_2
/// over the other: 2 ln B of 0 to 2 "not worth more than a bare mention", to 6 "positive", to 10 "strong", "very
/// strong". Of |ln B|: for the other model where it is negative.
std::string kass_raftery(double log_bayes_factor);

}  // namespace kalfem

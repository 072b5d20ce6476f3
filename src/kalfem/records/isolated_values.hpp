// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// The values with NaN in the place of spikes: what decides on few samples (a release, a rest, a start) must not follow
/// one of them. A value is a spike where it is further from the median m of the seven values about it than
///     max(8 s, 8 sigma, 0.01 r),   s = 1.4826 median |x - m|,
/// sigma: noise_level() of the channel, r: from its 5 % to its 95 % quantile. A smooth motion and a step stay, as their
/// neighbours go with them; of a pulse one to three samples wide that returns to where it was, nothing does.
/// Hampel, J. Am. Stat. Assoc. 69 (1974) 383-393; Davies and Gather, J. Am. Stat. Assoc. 88 (1993) 782-792.
/// `values`: channels x samples; channels with fewer than seven finite samples stay as they are.
Eigen::MatrixXd without_isolated_values(const Eigen::MatrixXd& values);

}  // namespace kalfem

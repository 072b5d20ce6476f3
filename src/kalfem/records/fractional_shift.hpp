// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// The samples of an equally sampled signal at other times, y(k) = x(k + lead), for a lead of any number of samples.
/// The shift is a pure phase at every frequency, so white noise stays white and as large: an interpolation between
/// neighbours would smooth it, and a likelihood would take that for a better fit.
///
/// A missing sample (not a number) is missing at the nearest new time, and so are times beyond the ends; for its
/// neighbours' sake it is bridged by a straight line. Within some ten samples of an end the signal's continuation,
/// which nobody knows, shows.
Eigen::VectorXd shifted(const Eigen::Ref<const Eigen::VectorXd>& signal, double lead);

/// The same for a lead of each sample, y(k) = x(k + lead(k)). As a function of the lead's fraction of a sample, y(k) is
/// the polynomial through its values at 12 Chebyshev points, for each of which the signal is shifted once: within 1e-9
/// of the largest amplitude at every frequency, however many samples there are.
Eigen::VectorXd shifted(const Eigen::Ref<const Eigen::VectorXd>& signal, const Eigen::VectorXd& lead);

}  // namespace kalfem

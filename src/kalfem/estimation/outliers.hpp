// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// What an update does with a sample that lies far from its prediction.
enum class OutlierTreatment {
  keep,   ///< learns from it as from any other
  gate,   ///< leaves it out beyond `limit`
  robust  ///< gives it less weight the further it lies, see outlier_weight()
};

/// Limits on e = innovation / expected deviation of a single channel.
struct OutlierOptions {
  OutlierTreatment treatment = OutlierTreatment::keep;
  /// A sample with |e| above counts as an outlier. White noise gets there once in 500 million samples.
  double limit = 6.0;
  double degrees_of_freedom = 10.0;  ///< nu of the Student-t distribution that `robust` takes for e
};

/// Weight w of a sample in the update, 1 for one that is taken as it is. The update uses S_ii / w in the place of the
/// innovation's variance S_ii; 0 leaves the channel out.
///     gate:    w = 0 where |e| > limit, otherwise 1
///     robust:  w = min(1, (nu + 1) / (nu + e^2)),
/// the weight of a normal sample whose variance is unknown with nu degrees of freedom (Student-t). Its influence w e
/// falls as 1 / e, so that one gross outlier moves the estimate less than a good sample does, and never to zero, so
/// that a filter that starts far away still learns.
double outlier_weight(const OutlierOptions& options, double e);

/// A sample that an update did not learn from as from any other.
struct SetAsideSample {
  Eigen::Index channel = 0, sample = 0;
  double innovation = 0.0, deviation = 0.0;  ///< of the channel, and what the filter expected [its unit]
  bool outlier = false;                      ///< by its innovation; otherwise it was to be left out
};

/// Samples [begin, end) of a channel from which a filter does not learn. It still predicts them.
struct HeldOutSamples {
  Eigen::Index channel = 0, begin = 0, end = 0;
};

}  // namespace kalfem

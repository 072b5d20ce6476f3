// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>
#include <mutex>
#include <string>
#include <unordered_map>

#include "kalfem/inference/posterior_of_data.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// Name of the file that LikelihoodCheckpoint keeps in the folder of the results. It is removed once they are complete.
inline constexpr const char* likelihoods_name = "infer.checkpoint";

/// Keeps every value of a case's likelihoods in a file as soon as it is known. All that an inference does follows from
/// its case and seeds, so a run that was killed goes the same way again, takes these values from the file, and ends
/// with the same bits. Lines are `KEY VALUE` in hexadecimal digits of the doubles' bits; a line that a kill cut short
/// is left out.
class LikelihoodCheckpoint {
public:
  /// An empty `folder` keeps nothing.
  explicit LikelihoodCheckpoint(const std::filesystem::path& folder);

  /// Makes likelihoods of a case look here first. The value at the start, computed anew, stands for the contents of the
  /// files that the case names: values of a case that has changed are not found. Such a likelihood may be called while
  /// the checkpoint lives, from several threads. Empty without a folder.
  [[nodiscard]] RememberLikelihood of(const Study& study);
  /// Values that an earlier run had computed and this one has asked for.
  [[nodiscard]] long long from_earlier() const { return from_earlier_; }

private:
  void read();
  double value_of(const std::string& key, const Eigen::VectorXd& theta, const LogLikelihood& likelihood);

  std::filesystem::path file_;
  std::unordered_map<std::string, double> earlier_;
  std::mutex mutex_;  ///< of the stream and the count
  std::ofstream stream_;
  long long from_earlier_ = 0;
};

}  // namespace kalfem

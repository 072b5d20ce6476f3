// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <string_view>
#include <vector>

namespace kalfem {

/// What may be wrong with a sensor of a modal test.
enum class MistakeKind {
  turned,     ///< it looks against its direction
  swapped,    ///< two of them have each other's cables
  direction,  ///< it looks along another axis of its node
  rotated,    ///< those of a node, along two or three axes, are turned together
  node        ///< it sits somewhere else
};

/// "turned", "swapped", "direction", "rotated", "node".
std::string_view word_of(MistakeKind kind);

/// A mistake of the set-up that explains how measured and computed shapes differ.
struct SetupMistake {
  MistakeKind kind = MistakeKind::turned;
  std::vector<std::string> sensors = {};     ///< the sensor; of `swapped` both, of `rotated` all of the node
  std::string place = {};                    ///< where the model has what it measured; of `rotated`: by which angle
  double mac_before = 0.0, mac_after = 0.0;  ///< mean over the pairs of modes
  double evidence = 0.0;  ///< gain in log-likelihood less the logarithm of how many such mistakes there might be
  /// "a7 is turned: it measures against its direction"
  [[nodiscard]] std::string in_words() const;
};

/// A sensor of a modal test and its place in the model, "n12.z".
struct ShapeSensor {
  std::string name;
  std::string place;
};

/// Motions of a model at all its places, "n12.z", in the modes that were paired.
struct ModelPlaces {
  std::vector<std::string> names;
  Eigen::MatrixXd motions;  ///< names x pairs
};

struct MistakeOptions {
  int most = 3;  ///< mistakes of one set-up
  /// Least evidence, and least share of the misfit that a mistake must explain: what is wrong with the model itself is
  /// no error of independent entries, so that evidence alone would find mistakes in it.
  double least_evidence = 5.0, least_share = 0.25;
};

/// Mistakes of the set-up, the most certain first; each is taken as mended before the next one is looked for.
///
/// Every mistake of every kind is tried: the rows of the model at its sensors are exchanged, and all shapes are scaled
/// anew. With errors of one unknown size the likelihood of N measured entries rises by N / 2 ln(J / J'), J of
/// ShapeFit; a rotation is fitted to the other sensors' scales [Kab76] and pays for each of its angles by
/// 1 / 2 ln(entries of its sensors). Of the K mistakes of a kind the best is the best of many by chance: it loses ln K.
std::vector<SetupMistake> setup_mistakes(const Eigen::MatrixXd& measured, const Eigen::MatrixXd& model,
                                         const std::vector<ShapeSensor>& sensors, const ModelPlaces& places,
                                         const MistakeOptions& options = {});

}  // namespace kalfem

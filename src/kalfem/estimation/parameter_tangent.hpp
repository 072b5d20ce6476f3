#pragma once

#include <utility>
#include <vector>

#include "kalfem/estimation/augmented_model.hpp"
#include "kalfem/estimation/partially_linear/partially_linear_map.hpp"

namespace kalfem {

/// y = A x + G phi(N x + e) + b at one x. False where phi cannot be evaluated.
bool image(PartiallyLinearMap& map, const Eigen::VectorXd& x, Eigen::VectorXd& y);

/// What the unknowns of the linear part do to a map of an augmented model, to first order: the map's gain ends in the
/// columns
///     dy/dtheta_i ~ (y(x; theta_i + s_i) - y(x; theta_i - s_i)) / (2 s_i)     at the mean x,
/// y by the maps of the augmented model's neighbours with all that follows from theta (connector forces too), and its
/// nonlinear outputs end in theta_i less the value that the augmented model is about. Without such unknowns it is
/// nothing.
template <class Map>
class ParameterTangent {
public:
  /// Map(neighbour, more...) is the map of a neighbour.
  template <class... More>
  explicit ParameterTangent(const AugmentedModel& augmented_model, const More&... more)
      : augmented_model_(&augmented_model) {
    for (const auto& each : augmented_model.neighbours()) {
      pairs_.push_back({&each, {}});
      pairs_.back().maps.reserve(2);
      pairs_.back().maps.emplace_back(*each.below, more...);
      pairs_.back().maps.emplace_back(*each.above, more...);
    }
  }

  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(pairs_.size()); }

  /// Lets every neighbour's map do the same.
  template <class Action>
  void each(const Action& action) {
    for (auto& pair : pairs_)
      for (auto& map : pair.maps) action(map);
  }

  /// Columns at the mean of the augmented state in the augmented model's coordinates; y in the maps' own. False where a
  /// neighbour cannot be evaluated.
  bool derivatives(const Eigen::VectorXd& mean, Eigen::MatrixXd& columns) {
    physical_ = augmented_model_->physical(mean);
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      auto& [neighbours, maps] = pairs_[i];
      if (!image(maps[0], physical_, below_) || !image(maps[1], physical_, above_)) return false;
      columns.resize(above_.size(), size());
      columns.col(static_cast<Eigen::Index>(i)) = (above_ - below_) / (2.0 * neighbours->step);
    }
    return true;
  }

  /// theta_i - value in the last columns of `out`; `first_unknown`: the argument of the first unknown.
  void set_outputs(const Eigen::ArrayXXd& in, Eigen::Index first_unknown, Eigen::ArrayXXd& out) const {
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      const auto& neighbours = *pairs_[i].neighbours;
      const auto& transform =
          augmented_model_->options().unknowns[static_cast<std::size_t>(neighbours.unknown)].transform;
      auto output = out.col(out.cols() - size() + static_cast<Eigen::Index>(i));
      transform.to_parameter(in.col(first_unknown + neighbours.unknown), output);
      output -= neighbours.value;
    }
  }

private:
  struct Pair {
    const Neighbours* neighbours;
    std::vector<Map> maps;  ///< below, above
  };
  const AugmentedModel* augmented_model_;
  std::vector<Pair> pairs_;
  Eigen::VectorXd physical_, below_, above_;
};

}  // namespace kalfem

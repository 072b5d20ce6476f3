#include "kalfem/estimation/filter.hpp"

#include "kalfem/estimation/covariance_filter.hpp"
#include "kalfem/estimation/partially_linear/partially_linear_filter.hpp"
#include "kalfem/estimation/square_root_filter.hpp"

namespace kalfem {

std::string name_of(FilterKind kind) {
  switch (kind) {
    case FilterKind::unscented:
      return "ukf";
    case FilterKind::unscented_square_root:
      return "ukf_square_root";
    case FilterKind::partially_linear:
      return "partially_linear_ukf";
    case FilterKind::partially_linear_square_root:
      return "partially_linear_ukf_square_root";
    case FilterKind::extended:
      return "ekf";
  }
  return {};
}

std::string to_string(FilterOutcome outcome) {
  switch (outcome) {
    case FilterOutcome::usable:
      return "usable";
    case FilterOutcome::model_not_evaluable:
      return "a connector force was not finite or did not converge at a sigma point: bound the unknown parameters "
             "(transform: log or bounds), or narrow their prior";
    case FilterOutcome::linear_part_impossible:
      return "an unknown of the linear part came to a value that makes no structure: bound it (transform: log or "
             "bounds), or narrow its prior";
    case FilterOutcome::covariance_not_positive_definite:
      return "the covariance of the state lost its positive sign: use filter: ukf_square_root, add process noise, or "
             "narrow the prior";
    case FilterOutcome::innovation_not_positive_definite:
      return "the covariance of the innovations is singular: give every sensor noise";
  }
  return {};
}

std::unique_ptr<Filter> make_filter(FilterKind kind, const UnscentedOptions& options,
                                    const PartiallyLinearMap* transition, int threads) {
  UnscentedOptions of_channels = options;
  of_channels.points = SigmaPoints::of_channels;
  switch (kind) {
    case FilterKind::unscented:
      return std::make_unique<CovarianceFilter>(UnscentedTransform(options));
    case FilterKind::unscented_square_root:
      return std::make_unique<SquareRootFilter>(UnscentedTransform(options));
    case FilterKind::partially_linear:
      if (auto layout = transition ? tile_layout(transition->linear) : std::nullopt)
        return std::make_unique<PartiallyLinearFilter>(options, *transition, *std::move(layout), threads);
      return std::make_unique<CovarianceFilter>(UnscentedTransform(of_channels));
    case FilterKind::partially_linear_square_root:
      return std::make_unique<SquareRootFilter>(UnscentedTransform(of_channels));
    case FilterKind::extended:
      return std::make_unique<CovarianceFilter>(UnscentedTransform::linearised());
  }
  return {};
}

}  // namespace kalfem

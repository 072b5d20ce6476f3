#include "kalfem/estimation/parameter_tangent.hpp"

namespace kalfem {

bool image(PartiallyLinearMap& map, const Eigen::VectorXd& x, Eigen::VectorXd& y) {
  const Eigen::ArrayXXd in = (map.selection() * x + map.input_offset()).transpose().array();
  Eigen::ArrayXXd out = Eigen::ArrayXXd::Zero(1, map.gain().cols());
  if (!map.evaluate(in, out)) return false;
  y = map.offset();
  y.noalias() += map.linear() * x;
  y.noalias() += map.gain() * out.matrix().transpose();
  return y.allFinite();
}

}  // namespace kalfem

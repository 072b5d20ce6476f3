#include "kalfem/model/elements/laminate.hpp"

#include "kalfem/model/elements/shell3.hpp"
#include "kalfem/model/elements/shell4.hpp"

namespace kalfem {

ElementMatrices laminate(const Eigen::Matrix3Xd& corners, const LaminateProperty& property,
                         const Eigen::Vector3d& direction, MassKind mass_kind) {
  return corners.cols() == 3 ? shell3(corners, property, direction, mass_kind)
                             : shell4(corners, property, direction, mass_kind);
}

}  // namespace kalfem

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/model/elements/beam_forces.hpp"
#include "kalfem/model/elements/shell_strains.hpp"
#include "kalfem/model/finite_element_model.hpp"
#include "kalfem/model/gauges/gauge_description.hpp"
#include "kalfem/model/statics/load_case.hpp"

namespace kalfem {

/// [xx yy zz xy yz xz] in global axes [Pa].
using Stress = Eigen::Matrix<double, 6, 1>;
/// The same of strains, engineering shear [-].
using Strain = Eigen::Matrix<double, 6, 1>;

/// sqrt(((xx - yy)^2 + (yy - zz)^2 + (zz - xx)^2) / 2 + 3 (xy^2 + yz^2 + xz^2)) [Pa].
double von_mises(const Stress& stress);
/// Principal stresses, the largest first [Pa].
Eigen::Vector3d principal_stresses(const Stress& stress);

/// Stress in one layer of a cell: at its centre, and at each of its nodes (of a quadratic shell its corners).
struct LayerStress {
  Layer layer = Layer::solid;
  Stress centre = Stress::Zero();
  Strain strain = Strain::Zero();                     ///< at the centre
  Eigen::Matrix<double, 6, Eigen::Dynamic> at_nodes;  ///< Stress of each node
};

/// A solid, or a shell of one material in its three layers.
struct CellStress {
  Eigen::Index cell = 0;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< of a shell
  std::vector<LayerStress> layers;
};

/// Forces and moments per length of a shell's section at its centre, in the element's axes.
struct ShellResultants {
  Eigen::Index cell = 0;
  Eigen::Matrix3d axes;                ///< rows: x, y and normal
  Eigen::Matrix<double, 8, 1> values;  ///< [n_xx n_yy n_xy m_xx m_yy m_xy q_xz q_yz] [N/m, N, N/m]
};

/// Section forces of a beam at its ends, and the axial stress at its outline where that is known.
struct BeamStress {
  Eigen::Index cell = 0;
  std::array<SectionForces, 2> ends;
  std::array<double, 2> axial = {};                  ///< N / A [Pa]
  std::array<std::optional<FibreStress>, 2> fibres;  ///< with bending
};

/// Stresses of the cells of a region with a property. A laminate has resultants alone: its layers are not known.
struct RegionStress {
  std::string region;
  std::vector<CellStress> cells;
  std::vector<ShellResultants> resultants;
  std::vector<BeamStress> beams;
};

/// Stresses under the displacements [m] and rotations [rad] of all nodes, 6 to a node: sigma = D epsilon with the
/// strains of solid_strains() and shell_strains(), and beam_forces(); D and the stiffness of sections are multiplied by
/// the factors of parts, as is the mass that `field` acts on. Transverse shear stress of shells is left out: it
/// is 0 at their surfaces. `field`: acts on the mass between the ends of beams, and `beam_loads` on their lines, see
/// beam_forces().
std::vector<RegionStress> recover_stresses(const FiniteElementModel& model, const Eigen::VectorXd& displacements,
                                           const AccelerationField& field = {},
                                           const std::vector<BeamLoad>& beam_loads = {});

/// Stress of a region at its nodes: the mean over the cells that meet at a node with one surface. Where normals of
/// shells differ by more than 30 degrees, as at a fold, each side has its own value. At the edges of a region of linear
/// cells the values of inner patches are extended linearly, by superconvergent patch recovery [ZZ92]: of the second
/// order too.
struct NodalStress {
  Eigen::Index node = 0;
  Layer layer = Layer::solid;
  Stress stress = Stress::Zero();
  Eigen::Index cell = 0;  ///< of those that meet, the one with the largest von Mises stress there
};
std::vector<NodalStress> nodal_stresses(const Mesh& mesh, const RegionStress& region);

/// The most stressed place of a region: by the von Mises stress of nodal means; of beams by the axial stress at the
/// outline, or N / A where that is unknown. Nothing where a region has no stresses (a laminate).
struct StressPeak {
  std::string region;
  double value = 0.0;  ///< [Pa]; of beams with its sign
  Eigen::Index cell = 0;
  Eigen::Index node = 0;
  Layer layer = Layer::solid;
  bool of_beam = false;
};
std::optional<StressPeak> stress_peak(const Mesh& mesh, const RegionStress& region,
                                      const std::vector<NodalStress>& means);

}  // namespace kalfem

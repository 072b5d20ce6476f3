// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <string>
#include <vector>

#include "kalfem/api/finite_elements.hpp"
#include "kalfem/api/laws.hpp"
#include "kalfem/model/lumped.hpp"
#include "kalfem/records/record.hpp"
#include "kalfem/system/signal.hpp"

namespace kalfem {

/// A signal at equal intervals.
struct Samples {
  Eigen::VectorXd values;
  double sample_rate = 0.0;  ///< [Hz]
  double start = 0.0;        ///< time of the first sample [s]
};

/// One channel of a record. Throws InvalidInput where there is none of that name.
Samples channel(const Record& record, const std::string& name);

/// A substructure of masses, springs and dashpots, as you describe it:
///     lumped("wheel").mass("w", 1.5).spring("k_w", "ground", "w", 2e4)
/// Its points are "wheel.w"; its parameters "wheel.w.mass", "wheel.k_w.stiffness", "wheel.k_w.damping".
class LumpedPart {
public:
  explicit LumpedPart(std::string name) { part_.name = std::move(name); }
  LumpedPart(std::string name, LumpedMatrices matrices) : LumpedPart(std::move(name)) {
    part_.matrices = std::move(matrices);
  }

  LumpedPart& mass(const std::string& dof, double kilograms);
  /// `from`, `to`: degrees of freedom or grounds; stiffness [N/m], damping [N s/m].
  LumpedPart& spring(const std::string& name, const std::string& from, const std::string& to, double stiffness,
                     double damping = 0.0);
  /// One more ground beside "ground".
  LumpedPart& ground(const std::string& name);
  /// Damping ratio of every mode of the substructure on its own springs and grounds; or one per mode, with the last one
  /// for all further modes.
  LumpedPart& modal_damping(double ratio) { return modal_damping(std::vector{ratio}); }
  LumpedPart& modal_damping(std::vector<double> ratios);
  /// C = alpha M + beta K, alpha [1/s], beta [s].
  LumpedPart& rayleigh_damping(double alpha, double beta);

  [[nodiscard]] const LumpedSubstructure& description() const { return part_; }

private:
  LumpedSubstructure part_;
};

LumpedPart lumped(const std::string& name);
/// The same from matrices M [kg], C [N s/m] and K [N/m] with the names of their rows; masses, springs and grounds can
/// be added to it. What is wrong with the matrices is found where the structure is used.
LumpedPart lumped(const std::string& name, LumpedMatrices matrices);
/// Equal masses "1", "2", ... [kg] in a row, joined by springs "1-2", "2-3", ... of one stiffness [N/m] and damping
/// [N s/m]. No ground holds it.
LumpedPart chain(const std::string& name, int masses, double mass, double stiffness, double damping = 0.0);

struct StructureDescription;

/// A structure as you describe it: substructures, connectors between their points, and inputs. Points and
/// parameters have names, "wheel.w" and "suspension.k". A value: copies are independent.
///
/// Names may appear in any order. They are looked up when the structure is used; all problems are then reported
/// together, as InvalidInput.
class Structure {
public:
  Structure();
  explicit Structure(const StructureDescription& description);
  Structure(const Structure& other);
  Structure(Structure&& other) noexcept;
  Structure& operator=(Structure other) noexcept;
  ~Structure();

  Structure& add(const LumpedPart& part);
  Structure& add(const FiniteElements& part);
  /// A connector between two points, or between a point and a ground ("wheel.ground", or "ground", which never moves).
  Structure& connect(const std::string& name, const std::string& from, const std::string& to, const Law& law);
  /// Damps the modes of the whole structure, on its connectors' stiffness at rest, by ratios to critical.
  Structure& modal_damping(std::vector<double> ratios);

  /// A ground whose absolute displacement is known [m]. Velocity and acceleration, which act as well, are those of the
  /// cubic spline through the samples.
  Structure& base_displacement(const std::string& name, const std::string& ground, const Samples& displacement);
  Structure& base_displacement(const std::string& name, const std::string& ground, SignalPtr displacement);
  /// A ground whose velocity was measured [m/s], as by a geophone. Its displacement is the integral, without the
  /// straight line that fits it best: the offset of a geophone is not known.
  Structure& base_velocity(const std::string& name, const std::string& ground, const Samples& velocity);
  /// All grounds accelerate alike [m/s^2]; displacements are then relative to them.
  Structure& base_acceleration(const std::string& name, const Samples& acceleration);
  Structure& base_acceleration(const std::string& name, SignalPtr acceleration);
  /// A force on a point [N].
  Structure& force(const std::string& name, const std::string& point, const Samples& force);
  Structure& force(const std::string& name, const std::string& point, SignalPtr force);
  /// The same without a signal, for drive() or for an OnlineFilter that receives the values sample by sample.
  Structure& base_displacement(const std::string& name, const std::string& ground);
  Structure& base_velocity(const std::string& name, const std::string& ground);
  Structure& base_acceleration(const std::string& name);
  Structure& force(const std::string& name, const std::string& point);

  /// Gives an input the samples that it is driven by, in the unit of its kind. Throws InvalidInput if there is no input
  /// of that name.
  Structure& drive(const std::string& input, const Samples& samples);

  /// Names of all numbers that can be estimated or updated, such as "suspension.mu_k1" and "body.3-4.stiffness".
  [[nodiscard]] std::vector<std::string> parameters() const;
  /// Value of a parameter [its SI unit]. Throws InvalidInput if there is none with that name.
  [[nodiscard]] double value(const std::string& parameter) const;
  /// Its SI unit. Throws as value() does.
  [[nodiscard]] std::string unit(const std::string& parameter) const;
  /// The structure at other values of any of its parameters, those of finite elements and of their damping included.
  /// Throws InvalidInput as above, and where a value is not finite.
  [[nodiscard]] Structure at(const NamedValues& values) const;
  /// Names of all points at which sensors and connectors can be placed.
  [[nodiscard]] std::vector<std::string> points() const;

  /// For the library itself.
  [[nodiscard]] const StructureDescription& description() const { return *description_; }

private:
  std::unique_ptr<StructureDescription> description_;
};

}  // namespace kalfem

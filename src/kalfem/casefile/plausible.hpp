// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/yaml/bounds.hpp"

/// Bounds in SI that hold for every real structure and measurement, from atomic-force cantilevers to suspension
/// bridges. They catch typing errors such as a mass of 1e-300 kg, which would lead to meaningless numbers.
namespace kalfem::plausible {

inline Bounds mass() { return Bounds::between(1e-21, 1e15); }       ///< [kg], of rotary inertia too [kg m^2]
inline Bounds coefficient() { return Bounds::between(0.0, 1e20); }  ///< of springs and dashpots
inline Bounds length() { return {.low = 0.0, .high = 1e9, .low_open = true}; }      ///< [m]
inline Bounds position() { return Bounds::between(-1e9, 1e9); }                     ///< [m]
inline Bounds strain() { return Bounds::between(0.0, 0.2); }                        ///< [m/m], of rubber in service
inline Bounds modulus() { return Bounds::between(1e-3, 1e18); }                     ///< [Pa]
inline Bounds density() { return Bounds::between(0.0, 1e9); }                       ///< [kg/m^3]
inline Bounds frequency() { return {.low = 0.0, .high = 1e12, .low_open = true}; }  ///< [Hz]
inline Bounds duration() { return {.low = 0.0, .high = 1e8, .low_open = true}; }    ///< [s], three years
inline Bounds time() { return Bounds::between(0.0, 1e8); }                          ///< [s], a duration or zero
inline Bounds clock() { return Bounds::between(-1e12, 1e12); }                      ///< [s], a time stamp
inline Bounds drift() { return Bounds::between(-0.1, 0.1); }                        ///< [s/s], of a clock
inline Bounds sensor_delay() { return Bounds::between(0.0, 100.0); }                ///< [s], of a measurement chain

}  // namespace kalfem::plausible

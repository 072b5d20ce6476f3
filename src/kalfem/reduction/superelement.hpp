// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/linalg/sparse_factor.hpp"
#include "kalfem/model/linear_model.hpp"

namespace kalfem {

struct StiffnessFactor;

/// How many fixed-interface modes are kept; what is given must all be satisfied (the largest number counts).
///
/// `effective_mass`: while a translation d of the boundary (its degrees of freedom "...x", "...y" or "...z" by 1; all
/// that are named in no direction together count as one translation) moves the interior statically by u_d, mode j takes
/// the part (phi_j^T M_ii u_d)^2 of the interior's mass u_d^T M_ii u_d. The parts of all modes sum to the whole; modes
/// are kept from the lowest until the given part of it is reached in every translation.
struct ModeSelection {
  std::optional<Eigen::Index> count = {};     ///< more than there are: all
  std::optional<double> cutoff = {};          ///< all modes up to this frequency [Hz]
  std::optional<double> effective_mass = {};  ///< in (0, 1)
};

/// Frequencies of the reduced against the full model in a band, in ascending order each (a reduced frequency is never
/// below the full one of the same place), and how alike their shapes are.
struct ModeComparison {
  double full = 0.0;     ///< [Hz]
  double reduced = 0.0;  ///< [Hz]
  double mac = 0.0;      ///< part of the full shape, by mass, in the span of the recovered shapes that have the reduced
                         ///< frequency to 0.1 %; the modal assurance criterion where that is one; in [0, 1]
  double residual = 0.0;  ///< |K phi - lambda M phi| / |K phi| of the recovered shape; 0 where it is rigid
};

/// What a reduction reports about itself.
struct ReductionErrorIndicators {
  std::vector<ModeComparison> modes;
  double static_error = 0.0;  ///< largest |K_ii psi + K_ib| / |K_ib| of a boundary degree of freedom's static mode psi
  Eigen::VectorXd fixed_interface_frequencies = {};  ///< fixed-interface modes kept [Hz]
  double highest_kept = 0.0;                         ///< of the fixed-interface modes [Hz]; 0: none
  double next_left_out = 0.0;                        ///< first that was left out [Hz], to 1 %; 0: there is none
  Eigen::Index rigid_modes = 0;                      ///< of the interior while the boundary is held, all kept
  std::string reason = {};                           ///< why so many modes, in words
  double seconds = 0.0;                              ///< without the comparison with the full model
  double compare_seconds = 0.0;                      ///< of that
  double factor_bytes = 0.0;                         ///< memory of the factor of K_ii [byte]
  Eigen::Index solves = 0;                           ///< back-solves with it
  EliminationOrder order = {};                       ///< of it: Craig-Bampton only
  std::map<std::string, double> gauges = {};  ///< largest difference of a strain of the full `modes` from that of the
                                              ///< recovered shapes, relative to the gauge's largest strain of them
};

/// A linear substructure in few coordinates, z = T q, with the map back to the full model.
struct Superelement {
  LinearModel model;      ///< reduced: boundary degrees of freedom by their own names, then "mode1", "mode2", ...;
                          ///< the full model's points and gauges as combinations of these
  Eigen::MatrixXd basis;  ///< T, n x r: displacement of all full degrees of freedom per reduced one
  std::vector<Eigen::Index> boundary;  ///< indices of the boundary in the full model
  ReductionErrorIndicators error_indicators;
  std::shared_ptr<const NormalModes> full_modes = {};  ///< of the full model, of the comparison; empty without it

  /// Displacement of the full model's degrees of freedom; works for velocities and accelerations too.
  [[nodiscard]] Eigen::MatrixXd recover(const Eigen::MatrixXd& reduced) const { return basis * reduced; }
};

enum class ReductionMethod { craig_bampton, rubin, macneal, guyan };

/// How a finite-element substructure is reduced. Without a limit on the modes these go up to three times the sensors'
/// bandwidth.
struct ReductionRequest {
  ReductionMethod method = ReductionMethod::craig_bampton;
  ModeSelection modes = {};          ///< not of Guyan's
  bool augmentation_vectors = true;  ///< see ReductionOptions
};

struct ReductionOptions {
  ModeSelection modes = {};                 ///< Craig-Bampton only, at least one criterion
  std::vector<std::string> also_kept = {};  ///< degrees of freedom treated as boundary beside it, such as sensors'
  bool augmentation_vectors = false;        ///< add the shapes that make up for the modes left out, see
                                            ///< craig_bampton.cpp: at most one a boundary degree of freedom
  EliminationOrder order = {};   ///< of an earlier reduction with the same pattern and boundary, see its indicators
  double compare_up_to = 0.0;    ///< band in which modes are compared with the full model's [Hz]; 0: up to the highest
                                 ///< kept, or below the first left out where none is kept
  Eigen::Index full_modes = 0;   ///< so many of the full model are computed for it at least, for other uses
  bool error_indicators = true;  ///< compare at all (costs the full model's modes)
  std::shared_ptr<const StiffnessFactor> whole = {};  ///< factor of the whole model's K, where it is at hand
};

/// Craig-Bampton: static boundary modes Psi = -K_ii^-1 K_ib and mass-normalised modes Phi of the interior held at the
/// boundary [CB68],
///     z = T q,  T = [I 0; Psi Phi],  M_r = T^T M T,  C_r = T^T (C + C_m) T,  K_r = T^T K T.
/// One factorisation of K_ii serves both. With modal truncation augmentation vectors, "truncation1", ..., follow the
/// modes.
///
/// Where the held boundary leaves the interior free to move, K_ii is singular: its rigid-body modes R are then kept
/// before all others, and Psi is the solution of K_ii Psi = -K_ib with R^T M_ii Psi = 0. It exists because K is
/// semi-definite (R^T K_ii R = 0 implies K_bi R = 0), and is found by holding as many degrees of freedom as there are
/// rigid-body modes, whose reactions vanish [FG98]. The reduced model is so exact at zero frequency in any case.
///
/// Throws InvalidInput with every boundary name that is unknown or doubled, and where the selection gives no criterion.
Superelement craig_bampton(const LinearModel& model, const std::vector<std::string>& boundary,
                           const ReductionOptions& options);

/// Guyan: static boundary modes alone [Guy65] (and the interior's rigid-body modes, where it has any).
Superelement guyan(const LinearModel& model, const std::vector<std::string>& boundary,
                   const ReductionOptions& options = {});

/// What in the evidence speaks against using the reduction, in sentences: modes left out within the band that is
/// excited or within three times the sensors' bandwidth (six times is better), frequencies or shapes in that bandwidth
/// that differ, strains at gauges that differ by more than 2 %, constraint modes that are not exact. Both bands [Hz].
std::vector<std::string> reduction_warnings(const ReductionErrorIndicators& error_indicators, double excitation_band,
                                            double sensor_bandwidth);

}  // namespace kalfem

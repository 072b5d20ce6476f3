// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "kalfem/formats/deck.hpp"

namespace kalfem {

/// Reads a Nastran bulk data deck [QRG], small, large and free field mixed, with images of cards and INCLUDEs, in its
/// own units.
///
/// File: executive and case control up to BEGIN BULK, or bulk data from the first line on; read to ENDDATA. The
/// commands above all subcases and those of the first one count: SPC, MPC, K2GG, M2GG, B2GG. Without any case control
/// the only set of SPC (MPC) holds, or the only SPCADD (MPCADD), or all sets with a note; a case control that chooses
/// none holds none, as Nastran does.
///
/// Read are
/// * GRID GRDSET SPOINT, CORD1R/C/S CORD2R/C/S;
/// * CQUAD4 CQUADR CQUAD8 CTRIA3 CTRIAR CTRIA6 with PSHELL, PCOMP, PCOMPG; CSHEAR with PSHEAR; CHEXA CPENTA CTETRA
///   CPYRAM with PSOLID;
/// * CBAR CBEAM with PBAR PBARL PBEAM PBEAML, BAROR BEAMOR; CROD CONROD CTUBE with PROD PTUBE;
/// * CELAS1-4 CDAMP1-4 CMASS1-4 CBUSH CBUSH1D CVISC with PELAS PDAMP PMASS PBUSH PBUSH1D PVISC; CONM1 CONM2;
/// * MAT1 MAT2 MAT8 MAT9, by temperature with MATT1 MATT2 MATT8 MATT9, TABLEM1-4, TEMP TEMPD;
/// * RBE1 RBE2 RBE3 RBAR RROD; MPC MPCADD SPC SPC1 SPCADD; DMIG;
/// * where load cases are asked for, FORCE MOMENT PLOAD2 PLOAD4 GRAV LOAD SPCD and the D of SPC: one case a subcase;
/// * PARAM WTMASS, COUPMASS (lumped mass without it), AUTOSPC (on without it).
/// Components at a node (SPC, MPC, RBE, CELAS, DMIG, ...) act in its displacement system CD. Loads, solution requests
/// and everything else that is not part of K, M and C is passed over or becomes a note of its class. Elements that are
/// not read, other stiffness, mass and connections, and the missing ENDDATA of a deck with BEGIN BULK become notes of
/// the kind `missing`, see accept_missing(); a card that is not known becomes a doubtful one. Every filled field of a
/// card that is read is used, told by a note, or refused; what makes the model another one than the deck describes is a
/// note of the kind `changed`, counted by element.
///
/// Made of it: regions "pshell3", "pbeam1", "prod5", "psolid2" by card and number of the property ("pshell3.2" where
/// offset or thickness of its elements differ); materials "mat7"; masses "conm2_12"; springs "celas4", "cbush5.k1";
/// links "rbe2_3", "rbe3_4"; node sets and supports "spc1" by their set, "grid_ps", "autospc". More than 500 springs
/// are kept as one matrix. 8- and 6-node shells become linear ones.
///
/// Throws InvalidInput with file and line for what cannot be understood or does not fit together: fields that are no
/// numbers, missing nodes, systems, properties and materials, numbers given twice, unknown section types; the first 20
/// together.
Deck read_nastran(const std::filesystem::path& file, const DeckOptions& options = {});

/// Gives the content of an included file; throws InvalidInput where it cannot be read.
using NastranIncludes = std::function<std::string(const std::filesystem::path&)>;

/// The same from a file's content; `source` names it in messages, and the folder that its INCLUDEs are relative to.
/// Without `includes` an INCLUDE is a problem.
Deck parse_nastran(std::string content, const std::string& source, const NastranIncludes& includes = {},
                   const DeckOptions& options = {});

}  // namespace kalfem

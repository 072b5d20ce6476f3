// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/yaml/map_schema.hpp"

namespace kalfem::description {

/// The kinds of signal that excitations, imposed motions and the signals of laws have in common.
struct SignalKinds {
  kalfem::Case<RandomSignal> random;
  kalfem::Case<Sine> sine;
  kalfem::Case<SweptSine> sweep;
  kalfem::Case<Impulse> impulse;
  kalfem::Case<Constant> constant;
};
SignalKinds signal_kinds();

/// The law of a connector with its parameters and signals.
Fields<Connector> law_keys();

Schema<Component> component();

}  // namespace kalfem::description

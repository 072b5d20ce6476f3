// SPDX-License-Identifier: Apache-2.0
#include "casefile/base_cases.hpp"

#include <cmath>
#include <fstream>

#include "formats/plate_msh.hpp"
#include "kalfem/formats/universal/universal.hpp"

namespace kalfem::test {
namespace {

constexpr double sample_rate = 200.0;  // Hz, of all records

const std::string chain = R"(kalfem: 1
title: chain
substructures:
  wheel:
    masses: {w: 1.5 kg}
    springs: [{name: k_w, from: ground, to: w, stiffness: 20 kN/m, damping: 5 N s/m}]
  body:
    chain: {masses: 2, mass: 1 kg, stiffness: 30 kN/m, damping: 1 N s/m}
    points: {middle: {1: 0.5, 2: 0.5}}
    damping: {modal: 1 %, mass_factor: 0.01, stiffness_factor: 1e-5}
connectors:
  suspension:
    from: wheel.w
    to: body.1
    law: saturating
    parameters: {k: 5 kN/m, mu_k1: 20 N, mu_k2: 2 mm, c: 10 N s/m, mu_c1: 10 N, mu_c2: 0.05 m/s}
excitation:
  road: {base_displacement: wheel.ground, random: {rms: 3 mm, band: [0.5, 30 Hz], duration: 2 s, fade_in: 0.1 s, seed: 7}, scale: 1}
sensors:
  a1: {acceleration: body.1, noise: 5 %}
  a2: {acceleration: body.2, noise: 0.2 m/s^2}
  middle: {displacement: {body.1: 0.5, body.2: 0.5}, noise: 5 %}
simulate:
  duration: 0.5 s
  sample_rate: 200 Hz
  integrator: newmark
  tolerance: 1e-2
  first_substeps: 4
  max_substeps: 256
  seed: 3
  initial: {body.1: {displacement: 1 mm, velocity: 0.01 m/s}}
estimate:
  filter: partially_linear_ukf
  alpha: 1
  beta: 2
  kappa: 1
  update_iterations: 2
  unknown:
    suspension.mu_k1: {initial: 15 N, std: 30 %, transform: log, random_walk: 0 N, truth: 20 N}
    wheel.k_w.stiffness: {initial: 21 kN/m, bounds: [10 kN/m, 40 kN/m]}
  initial_state:
    all: {displacement_std: 1 mm, velocity_std: 0.1 m/s}
    body.1: {displacement: 1 mm, velocity: 0.01 m/s, displacement_std: 1 mm, velocity_std: 0.1 m/s}
  process_noise: {acceleration: 1e-3, accelerations: {body.2: 2e-3}}
  settle: 0.1 s
  estimate_initial_state: true
  passes: 2
  substeps: 2
  step_order: 4
  threads: 1
  diagnose: false
predict: {substructure: body, substeps: 2}
report: {displacements: [body.2], frequencies: 2, zoom: 0.2 s}
)";

const std::string inputs = R"(kalfem: 1
substructures:
  frame:
    masses: {1: 2 kg, 2: {x: 2 kg, y: 3 kg}}
    grounds: [left]
    springs:
      - {from: ground, to: 1, stiffness: 1e4, damping: 20}
      - {from: left, to: 2.x, stiffness: 1e4, damping: 20}
      - {from: 1, to: 2.y, stiffness: 1e4, damping: 20}
damping: {modal: [1 %, 2 %]}
excitation:
  sine: {force: frame.1, sine: {amplitude: 3 N, frequency: 4 Hz, phase: 0.1 rad, fade_in: 0.1 s}}
  sweep: {force: frame.1, sweep: {amplitude: 3 N, from: 1 Hz, to: 20 Hz, duration: 1 s, kind: logarithmic, fade_in: 0.1 s}}
  blow: {force: frame.2.x, impulse: {amplitude: 10 N, start: 0.1 s, duration: 0.02 s, shape: half_sine}}
  road: {base_displacement: frame.ground, road: {class: B, speed: 10 m/s, band: [0.05, 1], duration: 20 s, fade_in: 0.1 s, seed: 1}}
  axle: {base_displacement: frame.left, trailing_axle: {input: road, wheelbase: 1 m, speed: 10 m/s}}
  later: {force: frame.2.y, delayed: {input: sine, delay: 0.1 s}}
  measured: {force: frame.2.y, file: input.csv, channel: f, unit: N, delay: 0 s, clock_drift: 0 ppm, prepare: {remove_trend: true, low_pass: 60 Hz}}
  weight: {force: frame.1, constant: -9.81 N}
  shake: {base_acceleration: all, sine: {amplitude: 0.1 m/s^2, frequency: 3 Hz}}
sensors:
  d: {displacement: frame.1, noise: 1 mm}
  v: {velocity: frame.2.x, noise: 5 %}
  a:
    acceleration: {frame.1: 1, frame.2.y: 0.5}
    relative: true
    noise: 5 %
    chain:
      - butterworth: {order: 2, low_pass: 60 Hz}
      - bessel: {order: 2, band_pass: [1 Hz, 70 Hz]}
      - delay: 1 ms
      - resonance: {frequency: 500 Hz, damping: 0.7}
      - gain: 2
simulate: {duration: 0.5 s, sample_rate: 200 Hz, integrator: hht_alpha, hht_alpha: -0.1, tolerance: 0.1}
)";

const std::string expression = R"(kalfem: 1
substructures:
  wheel: {masses: {w: 1.5 kg}, springs: [{from: ground, to: w, stiffness: 20 kN/m, damping: 10}]}
  body: {masses: {b: 3 kg}}
connectors:
  strut: {from: wheel.w, to: body.b, law: linear, parameters: {k: 10 kN/m, c: 30 N s/m}}
  maxwell:
    from: wheel.w
    to: body.b
    law: expression
    force: "k*s + 0.01*(noise + tone + chirp + level) + 0.01*column"
    states: {s: {rate: "v - k/c*s", unit: m}}
    parameters: {k: 1e3, c: 100}
    signals:
      noise: {random: {rms: 1 V, band: [0.5, 5 Hz], duration: 1 s, fade_in: 0.1 s, seed: 2}, scale: 2}
      tone: {sine: {amplitude: 1 V, frequency: 3 Hz, phase: 0.1, fade_in: 0.1 s}}
      chirp: {sweep: {amplitude: 1 V, from: 1 Hz, to: 5 Hz, duration: 1 s, kind: linear, fade_in: 0.1 s}}
      level: {constant: 2 V}
      column: {channel: f, file: input.csv, unit: V, bridge_gaps: 20 ms, prepare: {remove_offset: {from: 0.1 s, to: 0.2 s}, remove_trend: true}}
excitation:
  road: {base_displacement: wheel.ground, random: {rms: 3 mm, band: [0.5, 30 Hz], fade_in: 0.1 s}}
sensors:
  a: {acceleration: body.b, noise: 5 %}
  f: {force: strut, noise: 5 %}
  x: {deformation: strut, noise: 5 %}
  r: {rate: strut, noise: 5 %}
simulate: {duration: 0.5 s, sample_rate: 200 Hz, integrator: generalized_alpha, spectral_radius: 0.7, tolerance: 0.1}
estimate:
  filter: ekf
  adaptive_noise: {sensors: true, process: true, memory: 1 s}
  unknown:
    stiffness: {initial: 9 kN/m, std: 1 kN/m, applies_to: [strut.k]}
    strut.c: {initial: 25, std: 20 %}
  initial_connector_states: {maxwell.s: {value: 0, std: 1e-3}}
  settle: 0.1 s
)";

const std::string local = R"(kalfem: 1
substructures:
  wheel: {masses: {w: 1.5 kg}, springs: [{from: ground, to: w, stiffness: 20 kN/m, damping: 10}]}
  body: {masses: {b: 3 kg}}
  load: {masses: {m: 1 kg, n: 1 kg}, springs: [{from: m, to: n, stiffness: 1e4, damping: 5}]}
connectors:
  strut: {from: wheel.w, to: body.b, law: linear, parameters: {k: 10 kN/m, c: 30 N s/m}}
  mount: {from: wheel.w, to: load.m, law: linear, parameters: {k: 20 kN/m, c: 30 N s/m}}
excitation:
  road: {base_displacement: wheel.ground, random: {rms: 3 mm, band: [0.5, 30 Hz], fade_in: 0.1 s}}
sensors:
  wheel: {acceleration: wheel.w, noise: 2 %}
  foot: {acceleration: body.b, noise: 2 %}
simulate: {duration: 0.5 s, sample_rate: 200 Hz, tolerance: 0.1}
estimate:
  unknown: {strut.k: {initial: 9 kN/m, std: 20 %}}
  local:
    substructures: [wheel]
    interface:
      body.b: {acceleration: {sensor: foot, displacement_std: 1 mm, velocity_std: 0.02 m/s}}
      wheel.w: {force: {std: 10 N, correlation_time: 0.05 s}}
  settle: 0.1 s
)";

const std::string recorded = R"(kalfem: 1
substructures:
  car: {masses: {u: 2 kg}, springs: [{name: k, from: ground, to: u, stiffness: 2000, damping: 8}]}
excitation:
  shaker:
    force: car.u
    file: release.csv
    channel: f
    align: {channel: x, sensor: u}
    bridge_gaps: 20 ms
    prepare: {remove_offset: {from: 1 s, to: 5 s}}
sensors:
  u: {displacement: car.u, noise: 0.1 mm, channel: x, gain: 1, offset: 0 mm, delay: 0 s, drift: 0 ppm}
record:
  file: release.csv
  start: 0.1 s
  end: 5.5 s
  unit: m
  skip_missing: true
  prepare: {remove_offset: {from: 5 s, to: 5.5 s}, remove_trend: false, high_pass: 0 Hz, low_pass: 90 Hz, sample_rate: 200 Hz}
  free_response: {delay: 0.05 s, threshold: 0.1 mm, margin: 0.2 s}
estimate:
  unknown: {car.k.stiffness: {initial: 1900, std: 10 %}}
  initial_state_from_record: true
  initial_state: {car.u: {displacement_std: 1 mm, velocity_std: 0.1 m/s}}
  settle: 0.1 s
validate:
  record:
    file: again.csv
    unit: m
    skip_missing: true
    prepare: {remove_offset: {from: 5 s, to: 5.5 s}, remove_trend: false, high_pass: 0 Hz, low_pass: 0 Hz, sample_rate: 200 Hz}
    free_response: {delay: 0.05 s, threshold: 0.1 mm, margin: 0.2 s}
  start: 0.1 s
  end: 5.4 s
  lead_in: 0.5 s
)";

const std::string latent = R"(kalfem: 1
substructures:
  s:
    masses: {1: 1 kg, 2: 1 kg}
    springs: [{name: k1, from: ground, to: 1, stiffness: 2000, damping: 3}, {name: k2, from: 1, to: 2, stiffness: 3000, damping: 3}]
excitation:
  f: {force: s.1, sine: {amplitude: 10 N, frequency: 3 Hz}, unknown: {std: 10 N, correlation_time: 0.05 s, smoothness: 3/2}}
  g: {force: s.2, constant: 2 N, unknown: {std: 5 N, random_walk: 0.1 N}}
sensors:
  x1: {displacement: s.1, noise: 1 %}
  x2: {displacement: s.2, noise: 1 %}
simulate: {duration: 0.5 s, sample_rate: 200 Hz}
estimate: {unknown: {s.k1.stiffness: {initial: 2100, std: 10 %}}}
)";

/// A component with these motions of its ends.
std::string component_between(const std::string& motion, const std::string& base_motion) {
  return "kalfem: 1\ncomponent:\n  law: linear\n  parameters: {k: 2 kN/m, c: 30 N s/m}\n  motion: {" + motion +
         "}\n  base_motion: {" + base_motion +
         "}\nsensors:\n  F: {force: component, noise: 1 N, mass: 0.1 kg, mass_at: to}\nsimulate: {duration: 0.5 s, "
         "sample_rate: 100 Hz}\n"
         "estimate:\n  unknown: {component.k: {initial: 1500, std: 500}}\n";
}

const std::string random_motion = "random: {rms: 5 mm, band: [0.5, 5 Hz]}",
                  sine_motion = "sine: {amplitude: 5 mm, frequency: 3 Hz}",
                  sweep_motion = "sweep: {amplitude: 5 mm, from: 1 Hz, to: 5 Hz}",
                  measured_column =
                      "channel: f, file: input.csv, bridge_gaps: 20 ms, prepare: {remove_offset: {from: 0.1 s, to: 0.2 "
                      "s}, remove_trend: true}",
                  measured_motion = measured_column + ", velocity: {" + measured_column + "}";

const std::string updating = R"(kalfem: 1
substructures:
  wheel: {masses: {w: 1.5 kg}, springs: [{from: ground, to: w, stiffness: 20 kN/m, damping: 10}]}
  body:
    masses: {1: 1 kg, 2: 1 kg, 3: 1 kg}
    springs:
      - {name: a, from: 1, to: 2, stiffness: 3e4}
      - {name: b, from: 2, to: 3, stiffness: 3e4}
      - {name: c, from: ground, to: 3, stiffness: 1e4}
    damping: {modal: 2 %}
connectors:
  strut: {from: wheel.w, to: body.1, law: linear, parameters: {k: 10 kN/m, c: 30 N s/m}}
excitation:
  road: {base_displacement: wheel.ground, random: {rms: 3 mm, band: [0.5, 30 Hz], fade_in: 0.1 s}}
sensors:
  a2: {acceleration: body.2, noise: 5 %}
  a3: {acceleration: body.3, noise: 5 %}
simulate: {duration: 0.5 s, sample_rate: 200 Hz, tolerance: 0.1}
estimate: {unknown: {strut.k: {initial: 9 kN/m, std: 20 %}}, settle: 0.1 s}
update:
  parameters:
    body.a.stiffness: {initial: 28 kN/m, std: 20 %, bounds: [10 kN/m, 60 kN/m], truth: 30 kN/m}
    others: {applies_to: [body.b.stiffness], bounds: [10 kN/m, 60 kN/m], std: 20 %}
    body.damping.modal: {bounds: [0.1 %, 20 %], std: 50 %}
  alternatives:
    two: {parameters: {body.a.stiffness: {initial: 28 kN/m, std: 20 %, bounds: [10 kN/m, 60 kN/m], truth: 30 kN/m}, others: {applies_to: [body.b.stiffness], std: 20 %}}}
  compare:
    tap: {modes: body, frequencies: [6.9 Hz, 30.6 Hz], deviation: 2 %, above: 1 Hz, minimum_mac: 0.3, expansion: serep, shapes: {file: shapes.csv, points: [1, 2, 3], deviation: 0.1, deviations: shape_deviations.csv}, dampings: [0.02, 0.02], damping_deviation: 20 %, weight: 1}
    table: {modes: body, frequencies: {file: frequencies.csv, column: f, first: 2}, deviation: {file: frequencies.csv, column: std, first: 2}, dampings: {file: frequencies.csv, column: d, first: 2}, damping_deviation: {file: frequencies.csv, column: d, first: 2}, model_modes: [1, 2]}
    modal: {modes: body, file: modes.unv, points: {1: 1:+X, 2: 2:+X, 3: 3:+X}, only: [1], shape_deviation: 0.1, compare_dampings: true, damping_deviation: 20 %, max_complexity: 0.3}
    hammer: {frf: body, inputs: [{force: 3, file: frf.csv}], outputs: [1, 2], quantity: acceleration, bands: [[2 Hz, 40 Hz]], compare: difference, deviation: 0.1, floor: 0.1, smoothing: 0 Hz, weight: 0.1}
    bend: {static: body, loads: {1: 10 N}, displacements: {1: 1.7 mm}, deviation: 0.05}
    history: {time_history: body, sensors: [a2, a3], derivatives: auto}
    whole: {simulation: all}
  method: least_squares
  starts: 1
  stages: 2
  tolerance: 1e-3
  check_sensitivities: false
  write_deck: decks
modifications:
  heavier: {substructure: body, set: {2.mass: 2 kg}, modes: 2, above: 1 Hz}
)";

const std::string beams = R"(kalfem: 1
substructures:
  wheel: {masses: {z: 3 kg}, springs: [{from: ground, to: z, stiffness: 1e5, damping: 30}]}
  mast:
    finite_elements:
      tables: {nodes: nodes.csv, elements: elements.csv, scale: 1}
      materials:
        steel: {youngs_modulus: 210 GPa, poissons_ratio: 0.3, density: 7850 kg/m^3}
      regions:
        leg: {material: steel, beam: {section: {rectangle: {width: 20 mm, height: 10 mm}}, up: [0, 1, 0], offset: [0 mm, 0 mm, 0 mm]}}
        arm: {material: steel, beam: {section: {circular_tube: {diameter: 20 mm, wall: 2 mm}}, up: [0, 1, 0]}}
      nodes: {tip: 4, knee: 3, middle: [0, 0, 0.5], foot: 1}
      gauges:
        low: {element: 1, direction: [0, 0, 1], fibre: [5 mm, 0 mm], region: leg}
        high: {at: [0, 0, 0.9], fibre: [5 mm, 0 mm]}
      masses: {head: {at: tip, mass: 1 kg, inertia: [1e-3, 1e-3, 1e-3], offset: [0 mm, 0 mm, 10 mm]}}
      fixed: {clamp: {nodes: foot, directions: [x, y, z, rx, ry, rz]}}
      mass_matrix: consistent
    springs: [{name: stay, from: ground, to: knee.x, stiffness: 1e3}]
    points: {top: {tip.z: 1, tip.x: 0.1}}
    damping: {modal: 1 %, modal_up_to: 500 Hz}
    reduction: {method: craig_bampton, modes: 3, truncation_vectors: false, boundary: [tip]}
connectors:
  mount: {from: wheel.z, to: mast.tip.z, law: linear, parameters: {k: 1e4, c: 10}}
excitation:
  road: {base_displacement: wheel.ground, random: {rms: 1 mm, band: [0.5, 30 Hz], fade_in: 0.1 s}}
sensors:
  a: {acceleration: mast.tip.z, noise: 5 %}
  s: {strain: mast.low, noise: 1 um/m}
simulate: {duration: 0.5 s, sample_rate: 200 Hz, tolerance: 0.1, reference: superelement, modes_up_to: 900 Hz}
estimate: {unknown: {mount.k: {initial: 9e3, std: 20 %}}, settle: 0.1 s}
predict: {substructure: mast}
report: {fields: {substructure: mast, every: 0.1 s}, modes: 3, strains: [mast.high], superelements: [matrix_market]}
)";

/// A law with signals, among the laws that a connector may follow.
const std::string fed_law = R"yaml(      fed:
        law: expression
        let: {g: 2*k}
        force: "g*x + q*s + 3*v + 1e-3*(noise + tone + chirp + level + column)"
        states: {s: {rate: "v - s", unit: m}}
        parameters: {q: 1}
        signals:
          noise: {random: {rms: 1 V, band: [0.5, 5 Hz], duration: 1 s, fade_in: 0.1 s, seed: 2}, scale: 2}
          tone: {sine: {amplitude: 1 V, frequency: 3 Hz, phase: 0.1, fade_in: 0.1 s}}
          chirp: {sweep: {amplitude: 1 V, from: 1 Hz, to: 5 Hz, duration: 1 s, kind: linear, fade_in: 0.1 s}}
          level: {constant: 2 V}
          column: {channel: f, file: input.csv, unit: V, bridge_gaps: 20 ms, prepare: {remove_offset: {from: 0.1 s, to: 0.2 s}, remove_trend: true}}
)yaml";

const std::string inferring = R"yaml(kalfem: 1
substructures:
  s: {masses: {a: 2 kg, b: 1 kg}, springs: [{name: k, from: ground, to: a, stiffness: 800 N/m, damping: 4 N s/m}]}
connectors:
  mount: {from: s.a, to: s.b, law: cubic, parameters: {k: 500 N/m, k3: 2e7, c: 3 N s/m}}
excitation:
  f: {force: s.a, random: {rms: 4 N, band: [0.5, 20 Hz], seed: 3}}
sensors:
  a: {acceleration: s.a, noise: 20 %}
  b: {acceleration: s.b, noise: 20 %}
simulate: {duration: 0.5 s, sample_rate: 200 Hz, tolerance: 0.1}
estimate:
  substeps: 1
  diagnose: false
  unknown:
    mount.k: {initial: 490 N/m, std: 5 %}
    mount.c: {initial: 3, std: 5 %}
    s.k.stiffness: {initial: 800 N/m, std: 5 %}
  settle: 0.1 s
  alternatives:
    connector: mount
    laws:
      linear: {law: linear, priors: {k: {normal: {mean: 500 N/m, std: 10 %}}, c: {lognormal: {median: 3, std: 0.2}}}}
)yaml" + fed_law + R"yaml(        priors: {k: {lognormal: {median: 250, std: 0.1}}}
infer:
  parameters: [mount.k, mount.c, s.k.stiffness]
  priors:
    mount.k: {normal: {mean: 500 N/m, std: 10 %}, bounds: [100 N/m, 900 N/m]}
    mount.c: {lognormal: {median: 3 N s/m, std: 0.2}}
    s.k.stiffness: {uniform: [600 N/m, 1000 N/m]}
  correlations: [{between: [mount.k, mount.c], value: 0.3}]
  likelihood: filter
  correlation_time: 0 s
  method: laplace
  samples: 50
  seed: 2
  predictions: 2
  profile: [mount.k]
  compare_laws:
    connector: mount
    laws:
      linear: {law: linear, priors: {k: {normal: {mean: 500 N/m, std: 10 %}}, c: {uniform: [1, 9]}}}
)yaml" + fed_law + R"yaml(        priors: {k: {lognormal: {median: 250, std: 0.1}, bounds: [1, 900]}}
)yaml";

const std::string placing = R"(kalfem: 1
substructures:
  wheel: {masses: {z: 3 kg}, springs: [{from: ground, to: z, stiffness: 1e5, damping: 30}]}
  mast:
    finite_elements:
      tables: {nodes: nodes.csv, elements: elements.csv}
      materials: {steel: {youngs_modulus: 210 GPa, density: 7850 kg/m^3}}
      regions:
        leg: {material: steel, beam: {section: {rectangle: {width: 20 mm, height: 10 mm}}, up: [0, 1, 0]}}
        arm: {material: steel, beam: {section: {rectangle: {width: 20 mm, height: 10 mm}}, up: [0, 1, 0]}}
      nodes: {tip: 4, knee: 3, foot: 1}
      fixed: {clamp: {nodes: foot}}
    damping: {modal: 1 %}
    reduction: {modes: 3}
connectors:
  mount: {from: wheel.z, to: mast.tip.z, law: linear, parameters: {k: 1e4, c: 10}}
excitation:
  road: {base_displacement: wheel.ground, random: {rms: 1 mm, band: [0.5, 30 Hz], fade_in: 0.1 s}}
sensors:
  a: {acceleration: mast.tip.z, noise: 5 %}
simulate: {duration: 0.5 s, sample_rate: 200 Hz, tolerance: 0.1, reference: superelement}
estimate: {unknown: {mount.k: {initial: 9e3, std: 20 %}, mount.c: {initial: 12, std: 20 %}}, settle: 0.1 s}
place:
  candidates:
    mast: {acceleration: [mast.leg, mast.tip], noise: 5 %, triaxial: true, spacing: 0.4 m}
    wheel: {velocity: wheel.z, noise: 1 mm/s}
    knee: {displacement: mast.knee.x, noise: 0.1 mm}
  count: 2
  parameters: [mount.k]
  keep: [a]
  criterion: trace
  draws: 2
  seed: 5
  largest_enumeration: 100
infer: {samples: 50, sensitivity: {outputs: [frequency.1, force.mount, nis], samples: 16}}
)";

const std::string plate = R"(kalfem: 1
substructures:
  plate:
    finite_elements:
      mesh: plate.msh
      scale: 1
      materials: {steel: {youngs_modulus: 210 GPa, density: 7850 kg/m^3}}
      regions: {plate: {material: steel, shell: {thickness: 5 mm, offset: 0 mm}}}
      nodes: {c: corner, f: far, m: [0.5, 0.4, 0]}
      gauges: {g: {element: 1, direction: [1, 0, 0], surface: top}}
      links: {rigid: {master: f, nodes: m, directions: [x, y, z, rx, ry, rz]}}
      fixed: {clamp: {nodes: edge}}
    preload: push
static:
  substructure: plate
  cases:
    push:
      forces: [{at: f, force: [0 N, 0 N, 10 N], moment: [0 N m, 1 N m, 0 N m]}]
      pressures: [{on: plate, pressure: 1 kPa}]
      gravity: [0 m/s^2, 0 m/s^2, -9.81 m/s^2]
    lift: {displacements: {f.z: 1 mm}}
    spin: {rotation: {axis: [0, 0, 1], about: [1 m, 0 m, 0 m], speed: 10 rad/s}}
  points: [f, m]
frequency_response:
  frequencies: {from: 1 Hz, to: 50 Hz, lines: 5, spacing: linear}
  inputs: [plate.f.z]
  outputs: [{displacement: plate.f.z}, {velocity: plate.m.z}, {acceleration: plate.m.x}, {strain: plate.g}]
  model: both
  method: modal
  substructure: plate
)";

const std::string sections = R"(kalfem: 1
substructures:
  mast:
    finite_elements:
      tables: {nodes: nodes.csv, elements: elements.csv}
      materials: {steel: {youngs_modulus: 210 GPa, density: 7850 kg/m^3}}
      regions:
        leg:
          material: steel
          beam:
            section: {general: {area: 1e-4, inertia_y: 1e-9, inertia_z: 1e-9, torsion: 2e-9, shear_factor_y: 0.8, shear_factor_z: 0.8}}
            up: [0, 1, 0]
        arm: {material: steel, beam: {section: {rectangular_tube: {width: 20 mm, height: 30 mm, wall: 2 mm}}, up: [0, 1, 0]}}
      nodes: {tip: 4, foot: 1}
      fixed: {clamp: {nodes: foot}}
      factors: {legs: {elements: [leg], of: both, value: 1.1}}
  rod:
    finite_elements:
      tables: {nodes: nodes.csv, elements: elements.csv}
      materials: {steel: {youngs_modulus: 210 GPa, density: 7850 kg/m^3}}
      regions:
        leg: {material: steel, beam: {section: {circle: {diameter: 20 mm}}, up: [0, 1, 0]}}
        arm: {material: steel, beam: {section: {circle: {diameter: 10 mm}}, up: [0, 1, 0]}}
      fixed: {clamp: {nodes: foot}}
      nodes: {foot: 1}
  block:
    finite_elements:
      mesh: block.msh
      materials: {steel: {youngs_modulus: 210 GPa, density: 7850 kg/m^3}}
      regions: {block: {material: steel, solid: {integration: full}}}
      nodes: {foot: [0, 0, 0], side: [1, 0, 0], back: [0, 1, 0]}
      fixed: {clamp: {nodes: foot}, slide: {nodes: side}, hold: {nodes: back}}
)";

const std::string foreign = R"(kalfem: 1
substructures:
  bar:
    finite_elements:
      matrices: {files: [K.mtx, M.mtx], dofs: map.txt, stiffness: K, mass: M}
      units: {length: 1 mm, mass: 1 t, time: 1 s}
      factors:
        stay:
          matrices:
            stiffness: {file: K.mtx, name: K}
            mass: {file: M.mtx, name: M}
            damping: {file: M.mtx, name: M}
            dofs: map.txt
          value: 0.5
      nodes: {foot: 11, top: 13}
  truss:
    finite_elements:
      deck: truss.bdf
      format: nastran
      units: {length: 1 mm, mass: 1 t, time: 1 s}
      temperature: 20
      subcase: 1
      nodes: {end: 2}
static: {substructure: truss, deck_cases: true}
)";

const std::string joined = R"(kalfem: 1
substructures:
  left:
    finite_elements:
      mesh: plate.msh
      materials: {steel: {youngs_modulus: 210 GPa, density: 7850 kg/m^3}}
      regions: {plate: {material: steel, shell: {thickness: 5 mm}}}
      nodes: {f: far}
      fixed: {clamp: {nodes: edge}}
  right:
    finite_elements:
      mesh: plate.msh
      rotate: {axis: [1, 0, 0], angle: 10 deg, about: [0 m, 0.4 m, 0 m]}
      translate: [1 m, 0 m, 0 m]
      materials: {steel: {youngs_modulus: 210 GPa, density: 7850 kg/m^3}}
      regions: {plate: {material: steel, shell: {thickness: 5 mm}}}
      nodes: {u: 4}
      links: {rigid: {master: u, nodes: edge}}
joints:
  hinge: {between: [left.f, right.u], tolerance: 1 um}
)";

const std::string evolution = R"(kalfem: 1
substructures:
  body:
    masses: {1: 1 kg, 2: 1 kg}
    springs:
      - {name: a, from: ground, to: 1, stiffness: 3e4}
      - {name: b, from: 1, to: 2, stiffness: 3e4}
update:
  parameters: {body.a.stiffness: {initial: 28 kN/m, bounds: [10 kN/m, 60 kN/m]}}
  compare: {tap: {modes: body, frequencies: [17.0 Hz, 44.6 Hz]}}
  method: cma_es
  evolution: {generations: 3, population: 8, seed: 1}
)";

const std::string block_mesh = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
1
3 1 "block"
$EndPhysicalNames
$Nodes
8
1 0 0 0
2 1 0 0
3 1 1 0
4 0 1 0
5 0 0 1
6 1 0 1
7 1 1 1
8 0 1 1
$EndNodes
$Elements
1
1 5 2 1 1 1 2 3 4 5 6 7 8
$EndElements
)";

/// Held at -10 mm for a second, then swinging freely until it rests at zero.
void write_release(std::ofstream file) {
  constexpr double frequency = 5.03, damping = 0.08, pi = 3.141592653589793;
  file << "t,x,f\n";
  for (int k = 0; k <= 6 * static_cast<int>(sample_rate); ++k) {
    const double time = k / sample_rate, after = std::max(0.0, time - 1.0), angle = 2.0 * pi * frequency * after;
    file << time << ',' << -0.01 * std::exp(-damping * angle) * std::cos(angle) << ",0\n";
  }
}

const std::string component = R"(kalfem: 1
component:
  law: expression
  let: {c: c0 + c1*u}
  force: k*x + c*v + 0.01*(noise + chirp + column)
  states: {u: {rate: 20*(volt - u), unit: V}}
  signals:
    volt: {sine: {amplitude: 2 V, frequency: 0.7 Hz}}
    noise: {random: {rms: 1 V, band: [0.5, 5 Hz]}}
    chirp: {sweep: {amplitude: 1 V, from: 1 Hz, to: 5 Hz}}
    column: {channel: f, file: input.csv, unit: V, prepare: {remove_offset: {from: 0.1 s, to: 0.2 s}, remove_trend: true}}
  parameters: {k: 2 kN/m, c0: 30 N s/m, c1: 15}
  motion: {random: {rms: 5 mm, band: [0.5, 5 Hz], seed: 3}}
  base_motion: {constant: 1 mm}
sensors:
  F: {force: component, noise: 1 N}
simulate: {duration: 0.5 s, sample_rate: 100 Hz}
estimate:
  unknown: {component.k: {initial: 1500, std: 500}}
)";

const std::string streaming = R"(kalfem: 1
substructures:
  frame:
    masses: {1: 2 kg, 2: 3 kg}
    grounds: [left]
    springs:
      - {from: left, to: 1, stiffness: 1e4, damping: 20}
connectors:
  joint: {from: frame.1, to: frame.2, law: linear, parameters: {k: 5 kN/m, c: 10 N s/m}}
excitation:
  floor: {base_displacement: frame.left, file: live, channel: x}
sensors:
  a: {acceleration: frame.2, noise: 0.1 m/s^2, channel: a1, gain: 2, offset: 0.1, delay: 0.01 s, drift: 0}
live:
  sample_rate: 200 Hz
  unit: m/s^2
  start: 0 s
  horizon: 1 s
  input_delay: 8
  window: 1000
  lag: 20
  gated: true
  gates: {limit: 6, warm_up: 500, memory: 100, suspend_after: 5, stuck: 8, patience: 1000, inflation: 10, silence: 100, most_events: 50}
  every: 1 s
  state: kept
  port: 5001
  metrics: 9101
  page: 9102
  mqtt: {broker: localhost, port: 1883, client: tower, publish: kalfem/tower, login: input.csv, authority: input.csv, certificate: input.csv, key: input.csv}
  alarms: {window: 30 s, reference: 50, memory: 40, level: 3 %, hysteresis: 0.2, persistence: 3, false_alarms_every: 100 h, covariates: {temperature: {channel: T, effect: 0.1 %}}}
estimate:
  unknown: {joint.k: {initial: 4 kN/m, std: 1 kN/m}}
)";

/// The same from a broker in place of a port.
const std::string brokered = [] {
  std::string text = streaming;
  const std::string port = "  port: 5001\n", client = "client: tower, ";
  text.erase(text.find(port), port.size());
  return text.insert(text.find(client) + client.size(), "topics: [tower/+], ");
}();

}  // namespace

std::vector<BaseCase> base_cases() {
  return {{"chain", chain},
          {"inputs", inputs},
          {"expression", expression},
          {"local", local},
          {"recorded", recorded},
          {"streaming", streaming},
          {"brokered", brokered},
          {"latent", latent},
          {"updating", updating},
          {"beams", beams},
          {"inferring", inferring},
          {"placing", placing},
          {"plate", plate},
          {"sections", sections},
          {"foreign", foreign},
          {"joined", joined},
          {"evolution", evolution},
          {"component", component},
          {"sine_component", component_between(sine_motion, random_motion)},
          {"sweep_component", component_between(sweep_motion, sine_motion)},
          {"random_component", component_between(random_motion, sweep_motion)},
          {"measured_component", component_between(measured_motion, measured_motion)}};
}

void write_case_files(const std::filesystem::path& folder) {
  for (const char* name : {"release.csv", "again.csv"}) write_release(std::ofstream(folder / name));
  std::ofstream input(folder / "input.csv");
  input << "t,f\n";
  for (int k = 0; k <= 200; ++k) input << k / sample_rate << ',' << std::sin(0.1 * k) << '\n';
  std::ofstream(folder / "shapes.csv") << "m1,m2\n0.5,-0.8\n0.7,0.2\n0.8,0.7\n";
  std::ofstream(folder / "shape_deviations.csv") << "m1,m2\n0.1,0.1\n0.1,0.1\n0.1,0.1\n";
  std::ofstream(folder / "frequencies.csv") << "f,std,d\n6.9,0.1,0.02\n30.6,0.5,0.02\n";
  MeasuredShape shape{.name = "mode 1", .frequency = 6.9, .damping = 0.02, .nodes = {1, 2, 3}};
  shape.values = Eigen::MatrixXcd::Zero(3, 3);
  shape.values.col(0) << 0.5, 0.7, 0.8;
  MeasuredFile modes;
  modes.shapes = {shape};
  write_universal(folder / "modes.unv", modes);
  std::ofstream frf(folder / "frf.csv");
  frf << "f,H1,H2\n";
  for (int k = 1; k <= 50; ++k) frf << k << ',' << 0.1 + 0.01 * k << "+0.01j," << 0.2 + 0.01 * k << "-0.02j\n";
  std::ofstream(folder / "nodes.csv") << "node,x,y,z\n1,0,0,0\n2,0,0,0.5\n3,0,0,1\n4,0.5,0,1\n";
  std::ofstream(folder / "elements.csv") << "element,node1,node2,region\n1,1,2,leg\n2,2,3,leg\n3,3,4,arm\n";
  std::ofstream(folder / "plate.msh") << plate_msh;
  std::ofstream(folder / "block.msh") << block_mesh;
  const std::string symmetric = "%%MatrixMarket matrix coordinate real symmetric\n3 3 ";
  std::ofstream(folder / "K.mtx") << symmetric << "5\n1 1 2e3\n2 1 -1e3\n2 2 2e3\n3 2 -1e3\n3 3 1e3\n";
  std::ofstream(folder / "M.mtx") << symmetric << "3\n1 1 1e-3\n2 2 1e-3\n3 3 1e-3\n";
  std::ofstream(folder / "map.txt") << "11.3\n12.3\n13.3\n";
  std::ofstream(folder / "truss.bdf")
      << "SOL 101\nCEND\nSUBCASE 1\nLOAD = 1\nBEGIN "
         "BULK\nGRID,1,,0.,0.,0.,,123456\nGRID,2,,100.,0.,0.,,23456\nMAT1,1,2.1+5,,.3,7.85-9\n"
         "MATT1,1,5\nTABLEM1,5\n,0.,2.1+5,100.,2.0+5,ENDT\nPROD,1,1,10.\nCROD,1,1,1,2\nFORCE,1,2,,10.,1.\nENDDATA\n";
}

}  // namespace kalfem::test

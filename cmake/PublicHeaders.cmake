# SPDX-License-Identifier: Apache-2.0
# The public interface: these headers are installed and documented, and no others. Each compiles by itself against the
# installed package (the test "package"), so that what a public header includes is in the list.
set(KALFEM_CORE_HEADERS
    kalfem.hpp
    # a structure and what is done with it
    api/compare.hpp api/correlate.hpp api/estimate.hpp api/finite_elements.hpp api/infer.hpp api/laws.hpp api/live_filter.hpp api/online_filter.hpp api/place.hpp api/predict.hpp api/sensors.hpp api/simulate.hpp api/statics.hpp
    api/structure.hpp api/update.hpp api/validate.hpp api/vibration.hpp
    # what these are described by
    base/interruption.hpp base/invalid_input.hpp base/progress.hpp
    diagnosis/diagnosis.hpp verdict/verdict.hpp
    estimation/consistency.hpp estimation/filter_kind.hpp estimation/parameter_transform.hpp identification/held_out_sensor.hpp identification/inference_choices.hpp identification/known_to.hpp identification/point_prior.hpp identification/unknown_scores.hpp
    live/gate_options.hpp live/live_state.hpp live/online_options.hpp
    information/sensor_placement.hpp linalg/sparse_factor.hpp sampling/marginal_prior.hpp sampling/posterior_mode.hpp
    model/finite_element_model.hpp model/linear_model.hpp model/lumped.hpp model/unit_system.hpp
    model/elements/element.hpp model/mesh/mesh.hpp model/mesh/properties.hpp
    model/gauges/gauge_description.hpp
    model/statics/load_case.hpp # of decks
    modal/identify_modes.hpp modal/merge_setups.hpp modal/modal_options.hpp modal/modal_result.hpp records/spectrum.hpp # modes of a record alone
    correlation/correlate.hpp correlation/expansion_method.hpp correlation/point_match.hpp correlation/response_agreement.hpp correlation/setup_mistakes.hpp
    correlation/shape_expansion.hpp updating/measured_mode.hpp updating/mode_pairing.hpp # and beside a model
    records/measured_file.hpp records/mode_set.hpp
    records/clock_lag.hpp records/record.hpp records/test_point.hpp reduction/superelement.hpp
    vibration/computed_response.hpp
    system/connector_law.hpp system/signal.hpp
    system/sensors/measurement_chain.hpp system/sensors/output_description.hpp
    system/signals/sampled.hpp)
set(KALFEM_FORMATS_HEADERS
    formats/deck.hpp formats/ledger.hpp formats/mode_file.hpp formats/matrices.hpp formats/matrices/write.hpp formats/tables/csv.hpp
    formats/test_points.hpp formats/updated_deck.hpp)
set(KALFEM_STUDY_HEADERS analysis/analysis.hpp report/run_case.hpp)

# The folders' libraries of each component; a component uses those before it.
set(KALFEM_CORE_LIBRARIES base linalg statistics sampling information verdict records modal model reduction system dynamics estimation prediction updating correlation
                          identification inference placement validation vibration diagnosis live api)
if(KALFEM_MPI)
  list(APPEND KALFEM_CORE_LIBRARIES distributed)
endif()
set(KALFEM_FORMATS_LIBRARIES formats)
set(KALFEM_STUDY_LIBRARIES evolution yaml casefile study watch pictures page steps analysis report)

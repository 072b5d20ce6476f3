// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/case_checks.hpp"

#include <algorithm>
#include <set>

#include "kalfem/study/updating_setup.hpp"

namespace kalfem {
namespace {

namespace d = description;
using Path = std::vector<std::string>;

/// Walks through the sections and warns of each key that the file gives but nothing reads, with its line.
class Collector {
public:
  explicit Collector(const d::Case& given) : given_(given) {}

  std::vector<std::string> collect() {
    of_simulation();
    for (const auto& [name, part] : given_.substructures) of_substructure(name, part);
    for (const auto& [name, sensor] : given_.sensors) of_sensor(name, sensor);
    of_estimation();
    of_updating();
    of_inference();
    of_placement();
    of_report();
    return std::move(warnings_);
  }

private:
  /// Warns of the key if the file itself gives it; defaults are no reason to warn.
  void warn(const Path& path, const std::string& why) {
    if (!given_.source.gives(path)) return;
    std::string text = "line " + std::to_string(given_.source.at(path).line) + ": ";
    for (std::size_t i = 0; i < path.size(); ++i) text += (i == 0 ? "" : ".") + path[i];
    warnings_.push_back(text + " has no effect: " + why);
  }

  void of_simulation() {
    if (!given_.simulate) return;
    const auto& simulate = *given_.simulate;
    if (simulate.integrator != Integrator::hht_alpha)
      warn({"simulate", "hht_alpha"}, "it applies to integrator: hht_alpha only");
    if (simulate.integrator != Integrator::generalized_alpha)
      warn({"simulate", "spectral_radius"}, "it applies to integrator: generalized_alpha only");
    if (!simulate.superelements) warn({"simulate", "modes_up_to"}, "it applies to reference: superelement only");
    if (simulate.superelements && !has_finite_elements())
      warn({"simulate", "reference"}, "the case has no finite elements");
  }

  void of_substructure(const std::string& name, const d::Substructure& part) {
    const Path path = {"substructures", name};
    const auto below = [&](std::initializer_list<std::string> keys) {
      Path longer = path;
      longer.insert(longer.end(), keys);
      return longer;
    };
    if (!part.finite_elements) {
      warn(below({"reduction"}), "the substructure has no finite elements");
      warn(below({"preload"}), "the substructure has no finite elements");
      warn(below({"damping", "modal_up_to"}), "the substructure has no finite elements");
      return;
    }
    if (part.damping.modal.empty()) warn(below({"damping", "modal_up_to"}), "there is no modal damping");
    if (part.reduction) of_reduction(path, part.reduction->value);
    const auto& source = part.finite_elements->source;
    if (std::holds_alternative<d::MatrixFiles>(source))
      for (const char* key : {"materials", "mass_matrix"})
        warn(below({"finite_elements", key}), "matrices have no elements");
    if (!std::holds_alternative<d::MeshFile>(source) && !std::holds_alternative<d::TableFiles>(source)) return;
    for (const auto& [material, given] : part.finite_elements->materials) {
      const auto made_of_it = [&](const auto& region) { return region.second.material.value == material; };
      if (std::ranges::none_of(part.finite_elements->regions, made_of_it))
        warn(below({"finite_elements", "materials", material}), "no region uses it");
    }
  }

  void of_reduction(const Path& substructure, const d::Reduction& reduction) {
    const bool guyan = reduction.method == ReductionMethod::guyan;
    const bool craig_bampton = reduction.method == ReductionMethod::craig_bampton;
    const auto of_other_method = [&](const std::string& key, const std::string& why) {
      warn({substructure[0], substructure[1], "reduction", key}, why);
    };
    if (guyan)
      for (const char* key : {"modes", "up_to", "effective_mass"}) of_other_method(key, "method: guyan keeps no modes");
    if (!craig_bampton) of_other_method("truncation_vectors", "they apply to method: craig_bampton only");
  }

  void of_sensor(const std::string& name, const d::Sensor& sensor) {
    const bool motion = std::visit([](const auto& observed) { return is_motion(observed.quantity); }, sensor.observed);
    if (!motion)
      warn({"sensors", name, "relative"}, "forces, deformations and strains do not depend on the base's motion");
    if (!given_.record && !given_.live)
      for (const char* key : {"channel", "gain", "offset", "delay", "drift"})
        warn({"sensors", name, key}, "the case reads no record");
  }

  void of_estimation() {
    if (!given_.estimate) return;
    const auto& estimate = *given_.estimate;
    if (estimate.filter == FilterKind::extended)
      for (const char* key : {"alpha", "beta", "kappa"}) warn({"estimate", key}, "filter: ekf has no sigma points");
    if (estimate.filter && *estimate.filter != FilterKind::partially_linear && !given_.update)
      warn({"estimate", "threads"}, "only filter: partially_linear_ukf uses threads");
    if (!estimate.adaptive_noise.any()) warn({"estimate", "adaptive_noise", "memory"}, "no noise adapts");
    for (const auto& [name, unknown] : estimate.unknown)
      if (unknown.transform && *unknown.transform != TransformKind::logit)
        warn({"estimate", "unknown", name, "bounds"}, "only transform: logit keeps a parameter between bounds");
    if (estimate.local) of_local(*estimate.local);
  }

  /// A connector outside the local augmented model can still act on a point inside it.
  void of_local(const LocalModelOptions& local) {
    std::set<std::string> held, ends;
    for (const auto& name : local.substructures) held.insert(name.value);
    for (const auto& [point, interface] : local.interface) ends.insert(point);
    const auto is_held = [&](const Name& point) { return held.contains(point.value.substr(0, point.value.find('.'))); };
    for (const auto& [name, connector] : given_.connectors) {
      if (is_held(connector.from) == is_held(connector.to)) continue;
      const auto& [inside, outside] =
          is_held(connector.from) ? std::tie(connector.from, connector.to) : std::tie(connector.to, connector.from);
      if (!ends.contains(outside.value) && !ends.contains(inside.value))
        warn({"connectors", name}, "estimate.local leaves out its end '" + outside.value +
                                       "'; make that point an interface with its acceleration, or '" + inside.value +
                                       "' one with a force");
    }
    for (const auto& [point, interface] : local.interface) {
      const auto* driven = std::get_if<InterfaceAcceleration>(&interface.value.motion);
      if (!driven) continue;
      const auto touches = [&](const auto& each) {
        const auto& [from, to] = std::tie(each.second.from, each.second.to);
        return (from.value == point && is_held(to)) || (to.value == point && is_held(from));
      };
      if (std::ranges::none_of(given_.connectors, touches))
        warn({"estimate", "local", "interface", point}, "no connector attaches it to the filter's model");
      warn({"sensors", driven->sensor.value, "chain"},
           "the interface '" + point + "' follows the sensor's record, without correction for its measurement chain");
    }
  }

  void of_updating() {
    if (!given_.update) return;
    const auto& update = *given_.update;
    const bool evolves = update.method == UpdatingMethod::evolution;
    const auto is_deck = [](const auto& each) {
      return each.second.finite_elements && std::holds_alternative<d::DeckFile>(each.second.finite_elements->source);
    };
    if (std::ranges::none_of(given_.substructures, is_deck))
      warn({"update", "write_deck"}, "no substructure is made of a deck");
    if (!evolves) warn({"update", "evolution"}, "it applies to method: cma_es only");
    if (evolves) warn({"update", "starts"}, "method: cma_es chooses its own points");
    if (evolves || update.starts == 1) warn({"update", "seed"}, "there is one starting point");
    for (const auto& [name, given] : update.comparisons) {
      const auto* modal = std::get_if<d::ModalData>(&given.value.data);
      if (modal && !has_shapes(*modal))
        for (const auto* key : {"minimum_mac", "expansion"})
          warn({"update", "compare", name, key}, "no mode shapes are compared");
      if (modal && !has_dampings(*modal))
        warn({"update", "compare", name, "damping_deviation"}, "no dampings are compared");
      const auto* frf = std::get_if<d::FrfData>(&given.value.data);
      const auto is_record = [](const d::FrfInput& input) {
        return std::holds_alternative<d::FrfRecordSource>(input.source);
      };
      if (frf && std::ranges::all_of(frf->inputs, is_record))
        warn({"update", "compare", name, "floor"}, "records have the deviations that their noise gives them");
      if (std::holds_alternative<d::FrfData>(given.value.data) && (evolves || update.starts > 1))
        warn({"update", "compare", name, "smoothing"}, "it applies to a search from one starting point only");
    }
  }

  void of_inference() {
    if (!given_.infer) return;
    const auto& infer = given_.infer->value;
    if (infer.likelihood != LikelihoodKind::simulation)
      warn({"infer", "correlation_time"}, "it applies to likelihood: simulation only");
  }

  void of_placement() {
    if (given_.place && given_.place->value.draws == 1)
      warn({"place", "seed"}, "without `draws` the initial values are used");
  }

  void of_report() {
    if (!given_.estimate)
      for (const char* key : {"displacements", "strains", "frequencies", "zoom"})
        warn({"report", key}, "the case does not estimate");
    if (!given_.estimate && !given_.simulate) warn({"report", "fields"}, "the case neither simulates nor estimates");
    if (has_finite_elements()) return;
    warn({"report", "modes"}, "the case has no finite elements");
    warn({"report", "superelements"}, "the case has no finite elements");
    warn({"damping", "up_to"}, "the case has no finite elements");
  }

  [[nodiscard]] bool has_finite_elements() const {
    return std::ranges::any_of(given_.substructures,
                               [](const auto& part) { return part.second.finite_elements.has_value(); });
  }

  const d::Case& given_;
  std::vector<std::string> warnings_;
};

}  // namespace

std::vector<std::string> keys_without_effect(const d::Case& given) { return Collector(given).collect(); }

}  // namespace kalfem

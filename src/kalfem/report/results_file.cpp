#include "kalfem/report/results_file.hpp"

#include "kalfem/base/version.hpp"
#include "kalfem/formats/hdf5_file.hpp"

namespace kalfem {
namespace {

struct QuantityName {
  const char* name;
  const char* unit;
};

QuantityName name_of(ObservedQuantity quantity) {
  switch (quantity) {
    case ObservedQuantity::displacement:
      return {"displacement", "m"};
    case ObservedQuantity::velocity:
      return {"velocity", "m/s"};
    case ObservedQuantity::acceleration:
      return {"acceleration", "m/s^2"};
    case ObservedQuantity::connector_deformation:
      return {"deformation", "m"};
    case ObservedQuantity::connector_rate:
      return {"rate", "m/s"};
    case ObservedQuantity::connector_force:
      return {"force", "N"};
  }
  return {"", ""};
}

/// A file whose series all have the same sampling rate.
class SeriesFile {
public:
  SeriesFile(const std::string& path, double sample_rate) : file_(Hdf5File::create(path)), sample_rate_(sample_rate) {
    file_.set_attribute("/", "kalfem", version);
    file_.set_attribute("/", "sample_rate", sample_rate);
  }

  void write(const std::string& name, const Eigen::VectorXd& values, const std::string& unit) {
    if (values.size() == 0) return;
    file_.write(name, values);
    file_.set_attribute(name, "unit", unit);
    file_.set_attribute(name, "sample_rate", sample_rate_);
  }

  void write_points(const std::string& group, const std::vector<PointQuantity>& points) {
    for (const auto& point : points) {
      const auto [quantity, unit] = name_of(point.quantity);
      const std::string name = group + "/" + point.point + "/" + quantity;
      write(name, point.mean, unit);
      write(name + "_std", point.deviation, unit);
    }
  }

  void close() { file_.close(); }

private:
  Hdf5File file_;
  double sample_rate_;
};

void write_truth(SeriesFile& file, const Study& study, const SimulationStage& stage) {
  file.write_points("/truth", stage.points);
  const auto& inputs = stage.reference.simulation.trajectory.inputs;
  for (Eigen::Index i = 0; i < study.model->system().input_count(); ++i) {
    const auto& input = study.model->system().inputs[static_cast<std::size_t>(i)];
    file.write("/inputs/" + input.name, inputs.row(i).transpose(), input.unit);
  }
}

void write_estimate(SeriesFile& file, const EstimationStage& stage) {
  file.write_points("/estimate", stage.points);
  const auto& unknowns = stage.observer->options().unknowns;
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const std::string name = "/estimate/parameters/" + unknowns[i].name;
    file.write(name, stage.result.unknowns.mean.row(row).transpose(), unknowns[i].unit);
    file.write(name + "_std", stage.result.unknowns.deviation.row(row).transpose(), unknowns[i].unit);
  }
  for (std::size_t i = 0; i < stage.measurements.channels.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const auto& channel = stage.measurements.channels[i];
    file.write("/innovation/value/" + channel.name, stage.result.innovation.row(row).transpose(), channel.unit);
    file.write("/innovation/deviation/" + channel.name, stage.result.innovation_deviation.row(row).transpose(),
               channel.unit);
    if (stage.open_loop) file.write("/open_loop/" + channel.name, stage.open_loop_sensors.col(row), channel.unit);
  }
  file.write("/innovation/nis", stage.result.nis, "-");
}

}  // namespace

void write_results(const std::string& path, const Study& study, const StudyResults& results) {
  const TimeSeries* record = results.estimation   ? &results.estimation->measurements
                             : results.simulation ? &results.simulation->measurements
                                                  : nullptr;
  if (!record) return;
  SeriesFile file(path, study.sample_rate());
  const Eigen::Index samples =
      results.simulation ? results.simulation->reference.simulation.trajectory.samples() : record->samples();
  file.write("/time",
             Eigen::VectorXd::LinSpaced(samples, record->start,
                                        record->start + static_cast<double>(samples - 1) / study.sample_rate()),
             "s");
  const TimeSeries& measurements = results.simulation ? results.simulation->measurements : *record;
  for (std::size_t i = 0; i < measurements.channels.size(); ++i)
    file.write("/measurements/" + measurements.channels[i].name, measurements.values.col(static_cast<Eigen::Index>(i)),
               measurements.channels[i].unit);
  if (results.simulation) write_truth(file, study, *results.simulation);
  if (results.estimation) write_estimate(file, *results.estimation);
  if (results.prediction) file.write_points("/prediction", results.prediction->points);
  file.close();
}

}  // namespace kalfem

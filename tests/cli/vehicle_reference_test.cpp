// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/records/record.hpp"
#include "vehicle_case.hpp"

namespace kalfem::test {
namespace {

/// What the sensors see of the full model and of the superelement that stands for it.
TEST(VehicleReference, SuperelementEqualsTheFullModelInTheSensorsBand) {
  const ScratchFolder full_folder("reference-full"), reduced_folder("reference-superelement");
  const auto record = [](const std::string& reference, const ScratchFolder& folder) {
    const auto outcome =
        run_vehicle("simulate", "vehicle/vehicle.yaml", "DURATION=0.6 TOLERANCE=0.001 REFERENCE=" + reference, folder);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    return Hdf5File::open((folder / "out" / "results.h5").string());
  };
  const auto full = record("full", full_folder), reduced = record("superelement", reduced_folder);
  for (const char* sensor : {"a1", "a2", "a3", "a4", "a5", "a6", "a7"}) {
    const std::string name = std::string("/measurements/") + sensor;
    // The same time steps and noise; what differs is the modes above 1,200 Hz behind a low-pass of 100 Hz.
    EXPECT_LT(nrmse(reduced.read(name), full.read(name)), 1e-3) << sensor;
  }
}

}  // namespace
}  // namespace kalfem::test

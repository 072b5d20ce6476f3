// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdlib>
#include <sstream>

#include "base/data_folder.hpp"
#include "base/places.hpp"
#include "command.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"

// Rest positions of the half-car rig: runs that end before the body has come to rest, and runs that are disturbed after
// it. The example's case with little changed.
namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

const char* const sensors[] = {"sprung_LH", "sprung_RH", "unsprung_LH", "unsprung_RH"};

class HalfCarRest : public testing::Test {
protected:
  void SetUp() override {
    if (!std::filesystem::exists(file_))
      GTEST_SKIP()
          << "the measured half-car records are not here: set KALFEM_DATA to the folder that holds halfcar-rig";
  }

  [[nodiscard]] MatrixXd measured(const std::string& run) const {
    return Hdf5File::open(file_.string()).read_matrix("/" + run);
  }

  /// The example on another record, with `passes` runs of the filter.
  [[nodiscard]] nlohmann::json estimate(const MatrixXd& record, bool loaded = false) {
    std::filesystem::create_directories(folder_ / "halfcar-rig");
    auto file = Hdf5File::create((folder_ / "halfcar-rig" / "halfcar_500Hz.h5").string());
    file.write_matrix("/run", record);
    file.set_attribute("/run", "fs_Hz", 500.0);
    file.close();
    const std::string setting = "KALFEM_DATA=" + folder_.path().string() +
                                " HALFCAR_RUN=run BODY_MASS=" + (loaded ? "473.77" : "433") +
                                " BODY_INERTIA=" + (loaded ? "105.63" : "82.7") + " ";
    const auto out = folder_ / "out";
    const std::string line = setting + command_file() + " run " + example("halfcar/halfcar.yaml") + " --out " +
                             out.string() + " > " + (folder_ / "stdout.txt").string() + " 2>&1";
    EXPECT_EQ(std::system(line.c_str()), 0) << read(folder_ / "stdout.txt");
    printed_ = read(folder_ / "stdout.txt");
    return read_summary(out);
  }

  std::filesystem::path file_ = data_folder("halfcar-rig") / "halfcar_500Hz.h5";
  ScratchFolder folder_{"halfcar-rest"};
  std::string printed_;
};

TEST_F(HalfCarRest, IsEstimatedWhereTheRecordEndsBeforeIt) {
  const struct {
    const char* run;
    double release;  ///< by the owners [s]
    bool loaded;
  } runs[] = {{"Centre_p0500_m000_t2_r2", 0.3248, false}, {"Centre_p1500_m200_t9_r2", 0.3418, true}};
  for (const auto& [run, release, loaded] : runs) {
    const auto summary = estimate(measured(run), loaded);
    // as in the runs that come to rest: the hand lets go over some 30 ms
    EXPECT_NEAR(summary["record"]["release_s"].get<double>(), release, 0.02) << run;
    EXPECT_TRUE(summary["record"]["rest_s"].is_null()) << run;
    EXPECT_NE(printed_.find("still moving at the end"), std::string::npos) << printed_;
    for (const char* sensor : sensors) {
      const double nrmse = summary["estimation"]["open_loop"][sensor]["nrmse"];
      EXPECT_LT(nrmse, 0.06) << run << sensor;  // 0.015 to 0.051
      EXPECT_TRUE(summary["parameters"].contains(std::string("rest.") + sensor)) << run << sensor;
    }
    // Wheels rest at 1.1 mm, or 0.5 to 0.6 mm under the load, in all other runs of the kind.
    for (const char* sensor : {"unsprung_LH", "unsprung_RH"})
      EXPECT_NEAR(summary["record"]["rest_positions"][sensor]["position"].get<double>(), loaded ? 0.55e-3 : 1.11e-3,
                  1e-4)
          << run << sensor;
  }
}

/// The record with a push behind it and a longer rest 2 mm away.
MatrixXd nudged(const MatrixXd& record) {
  const Index n = record.rows(), more = 4 * n;
  MatrixXd longer(n + more, record.cols());
  longer.topRows(n) = record;
  for (Index k = 0; k < more; ++k) {
    const double since = double(k + 1) / 500.0;
    longer.row(n + k) =
        record.row(n - 1 - k % 100).array() + 0.01 * (0.2 + std::exp(-3.0 * since) * std::sin(10.0 * since));
  }
  return longer;
}

/// A run that comes to rest, cut off 1.5 s before, and with a nudge behind it.
TEST_F(HalfCarRest, OfHalfTheRecordAndOfANudgedOneIsThatOfTheWhole) {
  const MatrixXd record = measured("Centre_p1000_m000_t3_r1");
  const auto whole = estimate(record);
  EXPECT_NEAR(whole["record"]["rest_s"].get<double>(), 3.66, 0.03);  // found 3.65
  const auto half = estimate(record.topRows(1050));                  // 2.1 s
  ASSERT_TRUE(half["record"]["rest_s"].is_null());
  for (const char* sensor : sensors) {
    const auto &estimated = half["record"]["rest_positions"][sensor], &seen = whole["record"]["rest_positions"][sensor];
    EXPECT_LT(std::abs(estimated["position"].get<double>() - seen["position"].get<double>()),
              3.0 * estimated["std"].get<double>())
        << sensor << estimated << seen;
  }
  for (const char* name : {"car.strut_L.stiffness", "car.strut_R.stiffness"}) {
    const auto &a = half["parameters"][name], &b = whole["parameters"][name];
    EXPECT_LT(std::abs(a["estimate"].get<double>() - b["estimate"].get<double>()), 3.0 * a["std"].get<double>())
        << name;
  }
  const auto disturbed = estimate(nudged(record));
  // the same samples decide, so nothing moves
  EXPECT_NEAR(disturbed["record"]["release_s"].get<double>(), whole["record"]["release_s"].get<double>(), 1e-9);
  EXPECT_NEAR(disturbed["record"]["rest_s"].get<double>(), whole["record"]["rest_s"].get<double>(), 1e-9);
  for (const auto& [name, parameter] : whole["parameters"].items()) {
    const auto& other = disturbed["parameters"][name];
    EXPECT_LT(std::abs(other["estimate"].get<double>() - parameter["estimate"].get<double>()),
              1e-6 * parameter["std"].get<double>())
        << name;
  }
}

}  // namespace
}  // namespace kalfem::test

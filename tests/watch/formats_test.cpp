// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "kalfem/watch/influx_lines.hpp"
#include "kalfem/watch/metrics_text.hpp"

namespace kalfem {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::string estimates =
    R"({"t":1.5,"condition":"consistent","verdict":"consistent","reasons":[],"parameters":{"strut.k 3":{"estimate":3e6,"std":null,"unit":"N/m^3"}},"outputs":{"body.b.displacement":{"mean":0.25,"std":0.5}},"events":[],"changes":[{}],"samples":750,"late":2,"bad_lines":1})";

TEST(InfluxLines, TellsEstimatesAndLeavesOutWhatIsNoNumber) {
  EXPECT_EQ(influx_lines(MessageKind::estimates, estimates, "my car"),
            "kalfem,case=my\\ car samples=750i,late=2i,bad_lines=1i,condition=\"consistent\",verdict=\"consistent\" "
            "1500000000\n"
            "kalfem_parameter,case=my\\ car,parameter=strut.k\\ 3,unit=N/m^3 estimate=3000000.0 1500000000\n"
            "kalfem_output,case=my\\ car,output=body.b.displacement mean=0.25,std=0.5 1500000000\n");
}

TEST(InfluxLines, TellsSmoothedEstimatesAtTheirTime) {
  std::string smoothed = estimates;
  smoothed.insert(
      smoothed.size() - 1,
      R"(,"smoothed":{"t":1.25,"parameters":{"k":{"estimate":2,"std":0.5,"unit":"N/m"}},"outputs":{"wind":{"mean":3,"std":1}}})");
  EXPECT_EQ(influx_lines(MessageKind::estimates, smoothed, "car"),
            influx_lines(MessageKind::estimates, estimates, "car") +
                "kalfem_parameter_smoothed,case=car,parameter=k,unit=N/m estimate=2,std=0.5 1250000000\n"
                "kalfem_output_smoothed,case=car,output=wind mean=3,std=1 1250000000\n");
}

TEST(InfluxLines, TellsAlarms) {
  EXPECT_EQ(
      influx_lines(MessageKind::alarm,
                   R"({"alarm":{"t":60,"kind":"raised","parameter":"k","change":-0.03,"text":"it \"fell\""}})", "car"),
      "kalfem_alarm,case=car,parameter=k,kind=raised change=-0.03,text=\"it \\\"fell\\\"\" 60000000000\n");
}

TEST(MetricsText, TellsEachCase) {
  const std::vector<WatchedHealth> cases{{.name = "a\"b", .silent_for = 0.5, .alarms = 3, .estimates = estimates},
                                         {.name = "dead", .running = false, .why_not = "no file"}};
  const std::string text = metrics_text(cases);
  EXPECT_THAT(text, HasSubstr("# TYPE kalfem_samples_total counter\nkalfem_samples_total{case=\"a\\\"b\"} 750\n"));
  EXPECT_THAT(text, HasSubstr("kalfem_up{case=\"dead\"} 0\n"));
  EXPECT_THAT(text, HasSubstr("kalfem_condition{case=\"a\\\"b\",condition=\"consistent\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("kalfem_condition{case=\"dead\",condition=\"stopped\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("kalfem_parameter{case=\"a\\\"b\",parameter=\"strut.k 3\",unit=\"N/m^3\"} 3e+06\n"));
  EXPECT_THAT(text, Not(HasSubstr("kalfem_parameter_std{")));
  EXPECT_THAT(text, HasSubstr("kalfem_changes{case=\"a\\\"b\"} 1\n"));
  EXPECT_FALSE(is_healthy(cases));
  EXPECT_TRUE(is_healthy({cases[0]}));
  EXPECT_THAT(health_text(cases), HasSubstr("\"why\":\"no file\""));
}

}  // namespace
}  // namespace kalfem

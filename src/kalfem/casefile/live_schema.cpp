// SPDX-License-Identifier: Apache-2.0
#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/casefile/live_description.hpp"
#include "kalfem/casefile/plausible.hpp"
#include "kalfem/yaml/map_schema.hpp"

namespace kalfem::description {

using namespace schema;

namespace {

Schema<GateOptions> gates() {
  constexpr int many = 10'000'000;
  return mapping(
      Fields<GateOptions>()
          .optional("limit", &GateOptions::limit, number("-", Bounds::between(3, 1e6)),
                    "a value is left out where its innovation, given the other channels, is larger than this in "
                    "expected deviations")
          .optional("warm_up", &GateOptions::warm_up, integer(0, many),
                    "samples at the start, and after the filter has doubted itself, that are not gated")
          .optional("memory", &GateOptions::memory, integer(20, 100'000),
                    "latest samples by which a channel is judged; so many good ones bring it back")
          .optional("suspend_after", &GateOptions::suspend_after, integer(1, 100'000),
                    "values left out among these after which the channel is out until it is good again")
          .optional("stuck", &GateOptions::stuck, integer(3, 100'000),
                    "equal values in succession, while the prediction moves, after which a channel is stuck")
          .optional("patience", &GateOptions::patience, integer(1, many),
                    "samples for which most working channels may contradict the filter before it doubts itself")
          .optional("inflation", &GateOptions::inflation, number("-", Bounds::between(1, 1e6)),
                    "it then widens its deviations by this factor")
          .optional("silence", &GateOptions::silence, integer(1, many),
                    "samples without a value after which a channel counts as missing")
          .optional("most_events", &GateOptions::most_events, integer(1, 1'000'000), "latest events that are kept"));
}

Schema<Alarms> alarms() {
  const auto covariate =
      Fields<Covariate>()
          .required("channel", &Covariate::channel, name(), "column of the stream; its values are taken as they come")
          .optional("effect", &Covariate::effect, number("-", {.low = 0.0, .high = 1e3, .low_open = true}),
                    "prior standard deviation of its effect: relative change of a parameter per unit of the channel");
  const auto options =
      Fields<ChangeOptions>()
          .optional("window", &ChangeOptions::window, number("s", plausible::duration()),
                    "time of the stream of which one estimate is formed")
          .optional("reference", &ChangeOptions::reference, integer(2, 10'000'000),
                    "windows before the first alarm; changes are counted from their level")
          .optional("memory", &ChangeOptions::memory, integer(2, 1000),
                    "a change that is not yet known may have begun in one of so many latest windows")
          .optional("level", &ChangeOptions::level, number("-", {.low = 0.0, .high = 1e3, .low_open = true}),
                    "smallest change that gives an alarm, relative to the initial value of the unknown, or to its std "
                    "where that value is 0")
          .optional("hysteresis", &ChangeOptions::hysteresis, number("-", Bounds::between(0, 1)),
                    "an alarm ends where the change has fallen below (1 - hysteresis) level")
          .optional("persistence", &ChangeOptions::persistence, integer(1, 1000),
                    "windows in succession that must show the change")
          .optional("false_alarms_every", &ChangeOptions::false_alarms_every,
                    number("s", {.low = 0.0, .high = 1e12, .low_open = true}),
                    "mean time between false alarms of a clean stream, all unknowns together: the threshold follows");
  return mapping(Fields<Alarms>()
                     .inlined(&Alarms::options, options)
                     .optional("covariates", &Alarms::covariates, named(located(mapping(covariate))),
                               "channels of the stream, such as a temperature, whose effect on the unknowns is learned "
                               "and taken out"));
}

std::vector<Issue> check_mqtt(const Mqtt& given) {
  std::vector<Issue> issues;
  if (given.topics.empty() && given.publish.empty())
    issues.push_back({{}, "mqtt has neither topics nor publish", "nothing would be read or sent", "give one of them"});
  if (given.certificate.empty() != given.key.empty())
    issues.push_back(
        {{}, "mqtt has a certificate without a key, or a key without one", "they belong together", "give both"});
  if (given.authority.empty() && !given.certificate.empty())
    issues.push_back({{}, "mqtt has a certificate but no authority", "without it there is no TLS", "give authority"});
  for (const char* wild : {"+", "#"})
    if (given.publish.find(wild) != std::string::npos)
      issues.push_back({{}, "mqtt.publish '" + given.publish + "' holds a " + wild, "it is one topic, not many", ""});
  return issues;
}

Schema<Mqtt> mqtt() {
  return mapping(
      Fields<Mqtt>()
          .optional("broker", &Mqtt::broker, text(), "computer of the broker")
          .optional("port", &Mqtt::port, integer(1, 65535), "its TCP port; default: 1883, with TLS 8883")
          .optional("client", &Mqtt::client, text(),
                    "name by which the broker keeps what comes while nobody listens; default: after the case file")
          .optional("topics", &Mqtt::topics, list(text()),
                    "topics that samples are read from, with + and # as in MQTT; in place of standard input")
          .optional("publish", &Mqtt::publish, text(),
                    "topic under which status, estimates, verdict and alarms are published and retained")
          .optional("login", &Mqtt::login, path(),
                    "file with the user in its first line and the password in its second")
          .optional("authority", &Mqtt::authority, path(),
                    "file (PEM) of certificates, one of which has signed the broker's: TLS is used")
          .optional("certificate", &Mqtt::certificate, path(), "own certificate (PEM), if the broker asks for one")
          .optional("key", &Mqtt::key, path(), "its private key (PEM)")
          .check(check_mqtt));
}

}  // namespace

Schema<Live> live() {
  return mapping(
      Fields<Live>()
          .required("sample_rate", &Live::sample_rate, number("Hz", plausible::frequency()),
                    "sampling rate of every channel")
          .optional("unit", &Live::unit, located(text()),
                    "unit of the channels; for accelerations, g is standard gravity; default: the units in the titles "
                    "of CSV (\"a [g]\"), otherwise SI")
          .optional("start", &Live::start, number("s", plausible::clock()),
                    "time of the first sample; default: that of the first one that comes")
          .optional("horizon", &Live::horizon, number("s", plausible::duration()),
                    "by so much later than another channel may a channel come; what comes later is left out")
          .optional("input_delay", &Live::input_delay, integer(0, 1000),
                    "samples by which the filter stays behind its inputs, whose spline needs later ones")
          .optional("window", &Live::window, integer(100, 10'000'000), "latest samples by which the verdict is formed")
          .optional("lag", &Live::lag, integer(0, 100'000),
                    "samples by which smoothed estimates stay behind the filter: of each sample from so many later "
                    "ones; 0: none")
          .optional("gated", &Live::gated, boolean(), "leave sensors out that lie, and take them again")
          .optional("gates", &Live::gates, gates(), "when that is done")
          .optional("alarms", &Live::alarms, located(alarms()),
                    "watch the unknowns for changes, and keep a trend by day")
          .optional("every", &Live::every, number("s", plausible::duration()),
                    "time of the stream between two lines of estimates")
          .optional("state", &Live::state, path(false),
                    "folder of the filter's state, from which a later start goes on; default: beside the case")
          .optional("mqtt", &Live::mqtt, located(mqtt()), "read samples from a broker of MQTT, and publish estimates")
          .optional("metrics", &Live::metrics, integer(1, 65535),
                    "TCP port on this computer that tells metrics (/metrics, for Prometheus) and health (/health)")
          .optional("page", &Live::page, integer(1, 65535),
                    "TCP port on this computer of a page that shows estimates, verdict, alarms and trend as they come")
          .optional("port", &Live::port, integer(1, 65535),
                    "TCP port on this computer that lines are read from, in place of standard input"));
}

}  // namespace kalfem::description

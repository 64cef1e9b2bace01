// SPDX-License-Identifier: BSD-3-Clause
// cliquevo cameras: what can be seen, and a compliance run for a rig.
#include "tools/cameras.h"

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/base/caught.h"
#include "core/base/printable.h"
#include "daemon/pipeline/camera_families.h"
#include "daemon/pipeline/command_line.h"
#include "daemon/pipeline/source.h"
#include "drivers/live/camera_options.h"
#include "tools/camera_run.h"
#include "tools/exit_code.h"

namespace cliquevo::tools {

namespace {

using drivers::SeenCamera;

std::vector<SeenCamera> list_all() {
  std::vector<SeenCamera> out;
  for (const daemon::CameraFamily& family : daemon::camera_families()) {
    if (!family.is_built_in()) continue;
    for (SeenCamera& camera : family.list()) out.push_back(std::move(camera));
  }
  return out;
}

std::string text_of(const nlohmann::ordered_json& value) {
  return value.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

// All that the list has, for programs: an empty array where there is none.
int list_as_json() {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const SeenCamera& camera : list_all()) {
    out.push_back({{"family", camera.family},
                   {"id", camera.id},
                   {"description", camera.description},
                   {"formats", camera.formats}});
  }
  fmt::print("{}", text_of(out));
  return kDone;
}

int list() {
  const std::vector<SeenCamera> seen = list_all();
  for (const SeenCamera& camera : seen) {
    fmt::print("{:<10}{}\n          {}\n", camera.family, printable(camera.id), printable(camera.description));
    if (!camera.formats.empty())
      fmt::print("          formats {}\n", printable(fmt::format("{}", fmt::join(camera.formats, ", "))));
  }
  for (std::size_t i = 0; i + 1 < seen.size(); ++i) {
    if (seen[i].family != seen[i + 1].family || (i > 0 && seen[i].family == seen[i - 1].family)) continue;
    fmt::print(
        "\n# The first two of {} as a pair; exchange them if left and right are crossed, and name the calibration:\n"
        "source:\n  type: {}\n  cameras:\n    left: \"{}\"\n    right: \"{}\"\n    calibration: \"\"\n",
        seen[i].family, seen[i].family, printable(seen[i].id), printable(seen[i + 1].id));
  }
  if (seen.empty()) {
    const std::string families = daemon::built_in_families();
    if (families.empty())
      return report({"no camera found", "no camera family is in this build", "see docs/building.md"});
    return report({"no camera found", "looked for by " + families,
                   "check cable, power, permissions (group video) and the network's addresses"});
  }
  return kDone;
}

struct TestArguments {
  daemon::ConfigArgument config;
  bool json = false;
  double seconds = 5.0;
  bool unplug = false;
  double wait_s = 0.0;
};

// Interrupts a source that delivers nothing for long.
class Guard {
 public:
  Guard(drivers::FrameSource& source, double patience_s)
      : thread_([this, &source, patience_s] {
          while (!done_) {
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
            if (static_cast<double>(monotonic_ns() - last_ns_) * 1e-9 > patience_s) source.interrupt();
          }
        }) {}
  ~Guard() {
    done_ = true;
    thread_.join();
  }
  Guard(const Guard&) = delete;
  Guard& operator=(const Guard&) = delete;
  void alive() { last_ns_ = monotonic_ns(); }

 private:
  std::atomic<std::int64_t> last_ns_{monotonic_ns()};
  std::atomic<bool> done_{false};
  std::thread thread_;
};

struct TestRun {
  int number = 0;
  CameraRun::Verdict verdict;
  std::int64_t pairs = 0;
  std::string status;
  std::string queues;
  std::string histograms;
};

// One start, so many seconds of pairs, one stop.
TestRun stream_once(drivers::FrameSource& source, const daemon::SourceConfig& config, double seconds, int number) {
  CameraRun run(config.cameras.rate_hz);
  const double start_patience_s = 20.0 + 30.0 / config.cameras.rate_hz;
  drivers::StereoPair pair;
  std::int64_t begin_ns = 0;
  {
    Guard guard(source, start_patience_s);
    for (;;) {
      const auto more = source.next(pair);
      if (!more.ok() || !*more) break;
      guard.alive();
      if (begin_ns == 0) begin_ns = monotonic_ns();
      run.add(pair.stamp_ns, pair.right_offset_ns, pair.host_ns - pair.stamp_ns);
      if (static_cast<double>(monotonic_ns() - begin_ns) * 1e-9 >= seconds) break;
    }
  }
  return {number, run.judge(), run.pairs(), source.status(), source.queues(), run.histograms()};
}

void print_run(const TestRun& run) {
  const CameraRun::Verdict& verdict = run.verdict;
  fmt::print(
      "start {}: {} pairs, {:.3f} Hz, {} skipped, jitter up to {:.3f} periods, cameras up to {:.3f} periods apart, "
      "arrival up to {:.1f} ms after the exposure\n  {}\n  {}\n{}",
      run.number, run.pairs, verdict.rate_hz, verdict.skipped, verdict.most_jitter, verdict.most_skew,
      verdict.most_delay_ms, run.status, run.queues, run.histograms);
  for (const std::string& complaint : verdict.complaints) fmt::print("  FAIL {}\n", complaint);
  std::fflush(stdout);
}

nlohmann::ordered_json run_json(const TestRun& run) {
  const CameraRun::Verdict& verdict = run.verdict;
  return {{"pairs", run.pairs},
          {"rate_hz", verdict.rate_hz},
          {"skipped", verdict.skipped},
          {"jitter_periods", verdict.most_jitter},
          {"skew_periods", verdict.most_skew},
          {"delay_ms", verdict.most_delay_ms},
          {"status", run.status},
          {"complaints", verdict.complaints}};
}

bool unplug_once(const daemon::SourceConfig& config) {
  auto source = daemon::open_source(config);
  if (!source) {
    report(source.error());
    return false;
  }
  fmt::print("unplug a camera, wait until that is reported, and plug it in again (60 s)\n");
  std::fflush(stdout);
  const std::int64_t give_up_ns = monotonic_ns() + 60'000'000'000;
  std::atomic<std::int64_t> pairs{0};
  std::thread reader([&] {
    drivers::StereoPair pair;
    const auto next = [&] { return guarded("cameras", [&] { return (*source)->next(pair); }); };
    for (auto more = next(); more.ok() && *more; more = next()) ++pairs;
  });
  bool lost = false;
  bool back = false;
  while (monotonic_ns() < give_up_ns && !back) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    const std::string status = (*source)->status();
    const bool camera_lost =
        status.find("lost") != std::string::npos || status.find("reconnecting") != std::string::npos;
    if (camera_lost && !lost) fmt::print("  {}\n", printable(status)), std::fflush(stdout);
    lost = lost || camera_lost;
    const std::int64_t before = pairs;
    if (lost && !camera_lost) {
      std::this_thread::sleep_for(std::chrono::seconds(1));
      back = pairs > before;
    }
  }
  (*source)->interrupt();
  reader.join();
  const char* verdict = back   ? "it came back: pairs flow"
                        : lost ? "FAIL it did not come back"
                               : "FAIL nothing was unplugged";
  fmt::print("  {}\n", verdict);
  return back;
}

int test(const TestArguments& arguments) {
  const auto config = daemon::read_config(arguments.config);
  if (!config) return report(config.error());
  const std::string& file = arguments.config.file;
  if (!config->source.is_live()) {
    return report({"no cameras in the configuration", file, "set source.type and source.cameras"});
  }
  int failed = 0;
  nlohmann::ordered_json results = nlohmann::ordered_json::array();
  for (int i = 1; i <= 3; ++i) {
    auto source = daemon::open_source_within(config->source, arguments.wait_s, [] { return false; });
    if (!source) return report(source.error());
    const TestRun run = stream_once(**source, config->source, arguments.seconds, i);
    failed += run.verdict.complaints.empty() ? 0 : 1;
    if (!arguments.json) print_run(run);
    results.push_back(run_json(run));
  }
  if (arguments.unplug) failed += unplug_once(config->source) ? 0 : 1;
  const int runs = arguments.unplug ? 4 : 3;
  if (arguments.json) {
    fmt::print("{}", text_of({{"passed", failed == 0}, {"runs", results}}));
  } else {
    fmt::print("{}: {} of {} runs passed\n", failed == 0 ? "PASS" : "FAIL", runs - failed, runs);
  }
  if (failed == 0) return kDone;
  return report({"rig does not comply", file, "the lines with FAIL (complaints) say where"}, kNotStrictEnough);
}

}  // namespace

void add_cameras_command(CliCommand app, int& exit_code) {
  auto arguments = std::make_shared<TestArguments>();
  const CliCommand cameras = app.add_subcommand("cameras", "List the cameras that can be seen, or test a rig of them");
  cameras.require_subcommand(0, 1);
  auto as_json = std::make_shared<bool>(false);
  cameras.add_flag("--json", *as_json, "Print JSON; no camera is an empty list then, not an error");
  const CliCommand tests =
      cameras.add_subcommand("test", "Start and stop a rig three times: rate, skew, what is missing");
  daemon::add_config_options(tests, arguments->config, "Configuration with the cameras");
  tests.get_option("--config").required();
  tests.add_option("--seconds", arguments->seconds, "Of each run (default 5)").between(0.5, 3600.0).type_name("S");
  const CliOption json = tests.add_flag("--json", arguments->json, "Print JSON: each run's figures and complaints");
  tests.add_flag("--unplug", arguments->unplug, "Also test the loss of a camera: it has to be unplugged")
      .excludes(json);
  tests.add_option("--wait", arguments->wait_s, "Wait so long for cameras that are not there yet (default: not at all)")
      .not_negative()
      .type_name("S");
  tests.footer(
      "Passes when each run's rate is within 5 %, at most 1 % of the exposures gave no pair and the cameras expose "
      "within\n"
      "a quarter period. Exit codes: 0 passed; 1 bad input or environment; 2 wrong usage; 3 failed.");
  cameras.footer("Printed with each: what source.cameras.left and right take (config/cliquevo.yaml).");
  tests.callback([arguments, &exit_code] { exit_code = test(*arguments); });
  cameras.callback([cameras, as_json, &exit_code] {
    if (!cameras.has_chosen_subcommand()) exit_code = *as_json ? list_as_json() : list();
  });
}

}  // namespace cliquevo::tools

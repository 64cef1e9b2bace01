// SPDX-License-Identifier: BSD-3-Clause
// From a frame being available to its pose being published, by the real daemon at camera rate over real messages:
// quiet and beside a CPU and a disk hog, at ordinary and at real-time priority. In a network namespace of its own.
#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <cliquevo/health_t.hpp>
#include <cliquevo/status_t.hpp>
#include <fmt/format.h>
#include <lcm/lcm-cpp.hpp>
#include <nlohmann/json.hpp>

#include "core/base/time.h"
#include "core/rt/histogram.h"
#include "core/rt/thread.h"
#include "tests/hil/private_network.h"
#include "tests/support/stall_watch.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"
#include "tools/exit_code.h"

namespace {

using namespace cliquevo;
using nlohmann::json;

constexpr const char* kUrl = "udpm://239.255.76.67:7667?ttl=0";
constexpr int kWarmUpFrames = 60;
// A machine that is shared stands still now and then. A core on which even the highest priority that there is did not
// run for so long is reported, and frames dropped until soon after that are counted apart from the others.
constexpr std::int64_t kStallUs = 8'000;
constexpr std::int64_t kAfterStallUs = 150'000;
constexpr int kHighestPriority = 99;

struct Options {
  double seconds = 60.0;
  double rate_hz = 30.0;
  int frames = 120;
  int stereo_workers = 2;
  std::string source;
  std::string file;
  std::string only;
  std::string beside;  // a command that runs beside, every other time
  int rounds = 3;
  double images_rate_hz = 5.0;
  bool strict = false;
};

constexpr double kMostBeside = 1.05;  // of the median latency with the command beside over that without

// The spans of a frame's way, each from two stamps of its VO_STATUS.
enum class Span : int { wait_stereo, stereo, wait_odometry, odometry, publish, total };
constexpr std::array<const char*, 6> kSpanNames{"until stereo", "stereo",  "until odometry",
                                                "odometry",     "publish", "frame to pose"};

class Listener {
 public:
  Listener() : lcm_(kUrl) {
    lcm_.subscribe("VO_STATUS", &Listener::on_status, this)->setQueueCapacity(10'000);
    lcm_.subscribe("VO_HEALTH", &Listener::on_health, this);
    thread_ = std::thread([this] {
      while (!stop_) lcm_.handleTimeout(20);
    });
  }
  ~Listener() {
    stop_ = true;
    thread_.join();
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  std::atomic<std::int64_t> seen{0};
  struct Drop {
    std::int64_t utime = 0;  // when it was published
    std::int64_t frames = 0;
  };
  std::vector<Drop> drops;        // after warm-up
  std::int64_t out_of_order = 0;  // this and what follows: once seen no longer rises
  std::int64_t dropped = 0;
  std::int64_t dropped_in_warm_up = 0;
  std::int64_t valid = 0;
  std::int64_t resident_first = 0;
  std::int64_t resident_last = 0;
  std::array<rt::Histogram, kSpanNames.size()> spans;

 private:
  void on_status(const lcm::ReceiveBuffer*, const std::string&, const status_t* m) {
    if (m->frame <= last_frame_) ++out_of_order;
    last_frame_ = m->frame;
    if (seen >= kWarmUpFrames && m->dropped > dropped) drops.push_back({m->publish_utime, m->dropped - dropped});
    dropped = m->dropped;
    if (++seen <= kWarmUpFrames) {
      dropped_in_warm_up = m->dropped;
      return;
    }
    if (m->status == status_t::VALID) ++valid;
    const auto record = [this](Span span, std::int64_t from_us, std::int64_t to_us) {
      spans[static_cast<std::size_t>(span)].record(1000 * (to_us - from_us));
    };
    record(Span::wait_stereo, m->grabbed_utime, m->stereo_begin_utime);
    record(Span::stereo, m->stereo_begin_utime, m->stereo_end_utime);
    record(Span::wait_odometry, m->stereo_end_utime, m->odometry_begin_utime);
    record(Span::odometry, m->odometry_begin_utime, m->odometry_end_utime);
    record(Span::publish, m->odometry_end_utime, m->publish_utime);
    record(Span::total, m->grabbed_utime, m->publish_utime);
  }
  void on_health(const lcm::ReceiveBuffer*, const std::string&, const health_t* m) {
    if (seen <= kWarmUpFrames) return;
    if (resident_first == 0) resident_first = m->resident_bytes;
    resident_last = m->resident_bytes;
  }

  lcm::LCM lcm_;
  std::int64_t last_frame_ = -1;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

// How late a thread that does nothing else wakes, at the same priority in the same run: what the machine itself adds.
class WakeProbe {
 public:
  WakeProbe(int priority, double rate_hz) {
    const auto period_ns = static_cast<std::int64_t>(1e9 / rate_hz);
    auto started = rt::Thread::start({.name = "wake-probe", .fifo_priority = priority}, [this, period_ns] {
      std::int64_t due_ns = monotonic_ns();
      while (!stop_) {
        due_ns += period_ns;
        timespec due{due_ns / 1'000'000'000, due_ns % 1'000'000'000};
        ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr);
        late.record(monotonic_ns() - due_ns);
      }
    });
    if (started) thread_ = std::move(*started);
  }
  ~WakeProbe() { stop_ = true; }
  WakeProbe(const WakeProbe&) = delete;
  WakeProbe& operator=(const WakeProbe&) = delete;
  rt::Histogram late;

 private:
  std::atomic<bool> stop_{false};
  rt::Thread thread_;  // last: joined first
};

std::int64_t dropped_beside_stalls(const std::vector<Listener::Drop>& drops,
                                   const std::vector<test::StallWatch::Stall>& stalls) {
  std::int64_t out = 0;
  for (const Listener::Drop& drop : drops) {
    const auto near = [&](const test::StallWatch::Stall& s) {
      return drop.utime >= s.begin_us && drop.utime <= s.end_us + kAfterStallUs;
    };
    if (std::any_of(stalls.begin(), stalls.end(), near)) out += drop.frames;
  }
  return out;
}

// One busy process a core, and one that writes and syncs without end.
std::vector<std::unique_ptr<test::Subprocess>> start_hogs(const std::string& folder) {
  std::vector<std::unique_ptr<test::Subprocess>> hogs;
  for (unsigned i = 0; i < std::max(1U, std::thread::hardware_concurrency()); ++i) {
    hogs.push_back(std::make_unique<test::Subprocess>(std::vector<std::string>{"sh", "-c", "while :; do :; done"}));
  }
  hogs.push_back(std::make_unique<test::Subprocess>(std::vector<std::string>{
      "sh", "-c",
      "while :; do dd if=/dev/zero of=" + folder + "/hog bs=1M count=64 conv=fsync 2>/dev/null || sleep 1; done"}));
  return hogs;
}

json percentiles(const rt::Histogram& histogram) {
  const rt::Percentiles p = histogram.percentiles();
  const auto ms = [](std::int64_t ns) { return 1e-6 * static_cast<double>(ns); };
  return {{"count", p.count},       {"p50_ms", ms(p.p50_ns)},   {"p90_ms", ms(p.p90_ns)},
          {"p99_ms", ms(p.p99_ns)}, {"p999_ms", ms(p.p999_ns)}, {"max_ms", ms(p.max_ns)}};
}

void print_row(const std::string& name, const json& p) {
  fmt::print("  {:18} {:8.2f} {:8.2f} {:8.2f} {:8.2f} {:8.2f}\n", name, p["p50_ms"].get<double>(),
             p["p90_ms"].get<double>(), p["p99_ms"].get<double>(), p["p999_ms"].get<double>(),
             p["max_ms"].get<double>());
}

void write_config(const std::string& path, const Options& options, bool real_time, bool watched) {
  const int priority = real_time ? 50 : 0;
  const std::string source =
      options.source.empty()
          ? fmt::format("type: simulator\n  simulator: {{frames: {}, rate_hz: {}}}", options.frames, options.rate_hz)
          : fmt::format("type: recording\n  recording: {{path: {}, rate_hz: {}}}", options.source, options.rate_hz);
  std::ofstream(path) << fmt::format(
      "source:\n  loop: pingpong\n  {}\nstereo: {{workers: {}}}\nrealtime: {{stereo_priority: {}, "
      "odometry_priority: {}, output_priority: {}}}\nlog: {{level: warn}}\n",
      source, options.stereo_workers, priority, priority, real_time ? 30 : 0);
  if (!watched) return;
  std::ofstream(path, std::ios::app) << fmt::format(
      "lcm: {{images_channel: VO_IMAGES, images_rate_hz: {}, images_right: true, features_channel: VO_FEATURES, "
      "movers_channel: VO_MOVERS, points_channel: VO_POINTS}}\n",
      options.images_rate_hz);
}

void print_result(const json& result) {
  fmt::print("load: {}, priority: {}: {} frames, {} valid, {} dropped, {} out of order, resident {:.1f} to {:.1f} MB\n",
             result["load"].get<std::string>(), result["priority"].get<std::string>(), result["frames"].get<int>(),
             result["valid"].get<int>(), result["dropped"].get<int>(), result["out_of_order"].get<int>(),
             1e-6 * result["resident_bytes_after_warm_up"].get<double>(),
             1e-6 * result["resident_bytes_at_end"].get<double>());
  const auto rights = result["without_rights"].get<std::string>();
  if (!rights.empty()) fmt::print("  {}", rights);
  fmt::print("  the machine stood still {} times for more than {} ms, {:.1f} ms at the longest: {} of the dropped\n",
             result["stalls"].get<int>(), kStallUs / 1000, result["longest_stall_ms"].get<double>(),
             result["dropped_beside_stalls"].get<int>());
  fmt::print("  {:18} {:>8} {:>8} {:>8} {:>8} {:>8}   ms\n", "", "50 %", "90 %", "99 %", "99.9 %", "max");
  for (const char* name : kSpanNames) print_row(name, result["spans"][name]);
  print_row("(bare wake-up)", result["bare_wake_up"]);
  std::fflush(stdout);
}

Result<json> run_once(const Options& options, bool loaded, bool real_time, bool watched = false) {
  const std::string folder = test::scratch_dir();
  const std::string config = folder + "/bench.yaml";
  const int priority = real_time ? 50 : 0;
  write_config(config, options, real_time, watched);
  std::unique_ptr<test::Subprocess> beside;
  if (watched) {
    beside = std::make_unique<test::Subprocess>(std::vector<std::string>{"sh", "-c", "exec " + options.beside});
    std::this_thread::sleep_for(std::chrono::seconds(8));  // a browser takes its time
  }
  Listener listener;
  test::Subprocess daemon({test::binary("cliquevod"), "--config", config});
  const std::int64_t patience_ns = monotonic_ns() + 600'000'000'000;  // the first run renders
  while (listener.seen < kWarmUpFrames && monotonic_ns() < patience_ns) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  if (listener.seen < kWarmUpFrames) return Error{"the daemon sends nothing", config, daemon.wait(0.0).err};
  const auto hogs = loaded ? start_hogs(folder) : std::vector<std::unique_ptr<test::Subprocess>>{};
  json result{{"load", loaded ? "cpu and disk" : "none"}, {"priority", real_time ? "fifo 50" : "ordinary"}};
  std::vector<test::StallWatch::Stall> stalls;
  {
    test::StallWatch watch(kStallUs, kHighestPriority);
    WakeProbe probe(priority, options.rate_hz);
    std::this_thread::sleep_for(std::chrono::duration<double>(options.seconds));
    result["bare_wake_up"] = percentiles(probe.late);
    stalls = watch.stop();
  }
  daemon.send(SIGTERM);
  const test::Finished ended = daemon.wait(20.0);
  if (ended.exit_code != 0) return Error{"the daemon ended badly", config, ended.err};
  if (beside) {
    beside->send(SIGTERM);
    const test::Finished watcher = beside->wait(20.0);
    if (watcher.exit_code != 0) {
      return Error{"the command beside ended badly", options.beside, watcher.out + watcher.err};
    }
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  json spans;
  for (std::size_t i = 0; i < kSpanNames.size(); ++i) spans[kSpanNames[i]] = percentiles(listener.spans[i]);
  result["spans"] = spans;
  result["frames"] = listener.seen - kWarmUpFrames;
  result["valid"] = listener.valid;
  result["dropped"] = listener.dropped - listener.dropped_in_warm_up;
  result["dropped_beside_stalls"] = dropped_beside_stalls(listener.drops, stalls);
  std::int64_t longest_us = 0;
  for (const auto& stall : stalls) longest_us = std::max(longest_us, stall.end_us - stall.begin_us);
  result["stalls"] = stalls.size();
  result["longest_stall_ms"] = 1e-3 * static_cast<double>(longest_us);
  result["out_of_order"] = listener.out_of_order;
  result["resident_bytes_after_warm_up"] = listener.resident_first;
  result["resident_bytes_at_end"] = listener.resident_last;
  result["without_rights"] = ended.err;

  print_result(result);
  return result;
}

// Without and with the command beside, in turns; true: it costs no more than it may.
Result<bool> run_beside(const Options& options, json& results) {
  std::array<std::vector<double>, 2> p50_ms;
  std::array<std::vector<double>, 2> p99_ms;
  bool clean = true;
  for (int round = 0; round < options.rounds; ++round) {
    for (const bool watched : {false, true}) {
      fmt::print("{} the command beside: ", watched ? "with" : "without");
      const auto result = run_once(options, false, true, watched);
      if (!result) return result.error();
      const json& total = result->at("spans").at("frame to pose");
      p50_ms[watched ? 1 : 0].push_back(total["p50_ms"]);
      p99_ms[watched ? 1 : 0].push_back(total["p99_ms"]);
      clean = clean && result->at("dropped") == result->at("dropped_beside_stalls");
      results.push_back(*result);
      results.back()["beside"] = watched ? options.beside : "";
    }
  }
  const auto median = [](std::vector<double> of) {
    std::nth_element(of.begin(), of.begin() + static_cast<std::ptrdiff_t>(of.size() / 2), of.end());
    return of[of.size() / 2];
  };
  const double ratio = median(p50_ms[1]) / median(p50_ms[0]);
  fmt::print(
      "frame to pose, medians of {} runs: 50 % {:.2f} ms without, {:.2f} ms with ({:+.1f} %); 99 % {:.2f} and {:.2f} "
      "ms\n",
      options.rounds, median(p50_ms[0]), median(p50_ms[1]), 100.0 * (ratio - 1.0), median(p99_ms[0]),
      median(p99_ms[1]));
  return clean && ratio <= kMostBeside;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Latency of the daemon from frame to pose, over LCM, quiet and beside hogs"};
  app.add_option("--seconds", options.seconds, "Length of each run after warm-up")->check(CLI::Range(1.0, 1e6));
  app.add_option("--rate", options.rate_hz, "Pairs a second")->check(CLI::Range(1.0, 1000.0))->capture_default_str();
  app.add_option("--frames", options.frames, "Simulated pairs, played forward and backward")
      ->check(CLI::Range(2, 4000))
      ->capture_default_str();
  app.add_option("--source", options.source, "A recording instead of the simulator")->check(CLI::ExistingDirectory);
  app.add_option("--workers", options.stereo_workers, "Stereo threads")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--only", options.only, "quiet or loaded: only at real-time priority, and only that")
      ->check(CLI::IsMember({"quiet", "loaded"}));
  app.add_option("--beside", options.beside,
                 "A command that runs beside every other run, and the daemon sends what the view shows then; quiet, at "
                 "real-time priority; strictly: within 5 %")
      ->type_name("COMMAND");
  app.add_option("--rounds", options.rounds, "Runs with and without --beside")->check(CLI::Range(1, 1000));
  app.add_option("--images-rate", options.images_rate_hz, "Pictures a second that the daemon sends with --beside")
      ->check(CLI::Range(0.01, 1000.0));
  app.add_flag("--strict", options.strict,
               "Exit with 3 when a frame was dropped that the machine's stalls do not explain, or sent out of order");
  app.add_option("--json", options.file, "Write the results here as well");
  CLI11_PARSE(app, argc, argv);
  if (!test::enter_private_network()) {
    return tools::report({"no network namespace", "unshare", "run as root, with iproute2 installed"}), tools::kBadInput;
  }
  json results = json::array();
  bool clean = true;
  if (!options.beside.empty()) {
    const auto result = run_beside(options, results);
    if (!result) return tools::report(result.error()), tools::kBadInput;
    clean = *result;
  }
  for (const bool loaded : {false, true}) {
    for (const bool real_time : {false, true}) {
      if (!options.beside.empty()) continue;
      if (!options.only.empty() && (!real_time || loaded != (options.only == "loaded"))) continue;
      const auto result = run_once(options, loaded, real_time);
      if (!result) return tools::report(result.error()), tools::kBadInput;
      const bool explained = result->at("dropped") == result->at("dropped_beside_stalls");
      if (real_time) clean = clean && explained && result->at("out_of_order") == 0;
      results.push_back(*result);
    }
  }
  if (!options.file.empty()) {
    std::ofstream out(options.file);
    out << json{{"rate_hz", options.rate_hz}, {"seconds", options.seconds}, {"runs", results}}.dump(2) << "\n";
    if (!out) return tools::report({"cannot write the results", options.file, "check the folder and its rights"});
  }
  return options.strict && !clean ? tools::kNotStrictEnough : tools::kDone;
}

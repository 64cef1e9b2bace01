// SPDX-License-Identifier: BSD-3-Clause
#include "tools/examination.h"

#include <filesystem>
#include <fstream>
#include <sched.h>
#include <set>
#include <sys/resource.h>
#include <sys/timex.h>
#include <unistd.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "daemon/lcm/lcm_url.h"
#include "daemon/pipeline/config.h"
#include "daemon/pipeline/rectified_size.h"
#include "daemon/pipeline/source.h"
#include "daemon/pipeline/stages.h"

namespace cliquevo::tools {

namespace {

namespace fs = std::filesystem;

constexpr const char* kSysctlRemedy = "install the package's /usr/lib/sysctl.d/60-cliquevo.conf, then sysctl --system";
constexpr long kWantedReceiveBuffer = 2 * 1024 * 1024;  // what LCM's manual recommends

std::string first_line(const fs::path& path) {
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  return line;
}

Finding kernel(const fs::path& root) {
  const std::string version = first_line(root / "proc/version");
  Finding f{"kernel preemption", Verdict::good, "", "apt-get install linux-image-rt-amd64 and boot it"};
  if (first_line(root / "sys/kernel/realtime") == "1" || version.find("PREEMPT_RT") != std::string::npos) {
    f.found = "PREEMPT_RT";
  } else if (version.find("PREEMPT") != std::string::npos) {
    f.verdict = Verdict::advice;
    f.found = "preemptible, but not PREEMPT_RT: wake-ups can be late by milliseconds under load";
  } else {
    f.verdict = Verdict::advice;
    f.found = version.empty() ? "not reported" : "not preemptible";
  }
  return f;
}

// Tried, not looked up: limits, capabilities and containers all have a say.
Finding fifo_right() {
  Finding f{"real-time priority", Verdict::good, "SCHED_FIFO 50 granted",
            "run it as the service (LimitRTPRIO=), or as root, or add 'rtprio 80' in /etc/security/limits.d"};
  sched_param before{};
  const int policy = ::sched_getscheduler(0);
  ::sched_getparam(0, &before);
  sched_param wanted{};
  wanted.sched_priority = 50;
  if (::sched_setscheduler(0, SCHED_FIFO, &wanted) == 0) {
    ::sched_setscheduler(0, policy, &before);
  } else {
    f.verdict = Verdict::missing;
    f.found = "SCHED_FIFO 50 refused";
  }
  return f;
}

Finding memory_right() {
  Finding f{"locked memory", Verdict::good, "unlimited",
            "run it as the service (LimitMEMLOCK=infinity), or add 'memlock unlimited' in /etc/security/limits.d"};
  rlimit limit{};
  ::getrlimit(RLIMIT_MEMLOCK, &limit);
  if (::geteuid() == 0 || limit.rlim_cur == RLIM_INFINITY) return f;
  f.verdict = Verdict::missing;
  f.found = fmt::format("limited to {} kB", limit.rlim_cur / 1024);
  return f;
}

Finding governor(const fs::path& root) {
  Finding f{"CPU frequency", Verdict::good, "", "cpupower frequency-set -g performance"};
  std::set<std::string> governors;
  std::error_code none;
  for (const auto& cpu : fs::directory_iterator(root / "sys/devices/system/cpu", none)) {
    const std::string governor = first_line(cpu.path() / "cpufreq/scaling_governor");
    if (!governor.empty()) governors.insert(governor);
  }
  if (governors.empty()) {
    f.found = "not scaled by this kernel";
  } else {
    f.found = fmt::format("governor {}", fmt::join(governors, ", "));
    if (governors != std::set<std::string>{"performance"}) f.verdict = Verdict::advice;
  }
  return f;
}

Finding isolated_cores(const fs::path& root) {
  const std::string isolated = first_line(root / "sys/devices/system/cpu/isolated");
  const std::string online = first_line(root / "sys/devices/system/cpu/online");
  if (!isolated.empty()) return {"isolated cores", Verdict::good, isolated + " of " + online, ""};
  return {"isolated cores", Verdict::advice, "none of " + online,
          "boot with isolcpus=2,3 and name these cores in realtime.stereo_cpu and odometry_cpu (4 cores or more)"};
}

Finding throttling(const fs::path& root) {
  const std::string runtime = first_line(root / "proc/sys/kernel/sched_rt_runtime_us");
  if (runtime.empty()) return {"real-time share", Verdict::good, "not reported", ""};
  if (runtime == "0") {
    return {"real-time share", Verdict::missing, "real-time threads get no time",
            "sysctl kernel.sched_rt_runtime_us=950000"};
  }
  return {"real-time share", Verdict::good, runtime == "-1" ? "unlimited" : runtime + " us of each second's 1000000",
          ""};
}

Finding compaction(const fs::path& root) {
  const std::string value = first_line(root / "proc/sys/vm/compact_unevictable_allowed");
  if (value.empty() || value == "0") return {"page faults", Verdict::good, "locked memory is not moved", ""};
  return {"page faults", Verdict::advice, "the kernel may move locked memory (vm.compact_unevictable_allowed)",
          kSysctlRemedy};
}

Finding receive_buffer(const fs::path& root) {
  const std::string text = first_line(root / "proc/sys/net/core/rmem_max");
  const long bytes = std::atol(text.c_str());
  if (text.empty()) return {"receive buffers", Verdict::good, "not reported", ""};
  if (bytes >= kWantedReceiveBuffer) return {"receive buffers", Verdict::good, fmt::format("{} kB", bytes / 1024), ""};
  return {"receive buffers", Verdict::advice, fmt::format("{} kB: large messages may be lost", bytes / 1024),
          kSysctlRemedy};
}

Finding lcm_route(const std::string& url) {
  const auto ok = daemon::check_lcm_url(url);
  if (ok) return {"LCM route", Verdict::good, url, ""};
  return {"LCM route", Verdict::missing, ok.error().what + ": " + url, ok.error().remedy};
}

// An estimate of the clock's error is only reported while something keeps it in step.
Finding clock_sync() {
  timex state{};
  if (::adjtimex(&state) >= 0 && (state.status & STA_UNSYNC) == 0) {
    return {"clock", Verdict::good, fmt::format("kept in step, error up to {} us", state.maxerror), ""};
  }
  return {"clock", Verdict::advice, "not synchronised: stamps do not compare with other machines'",
          "apt-get install chrony (or linuxptp with PTP cameras)"};
}

Finding cameras(const fs::path& root) {
  std::vector<std::string> seen;
  std::vector<std::string> closed;
  std::error_code none;
  for (const auto& node : fs::directory_iterator(root / "dev", none)) {
    const std::string name = node.path().filename().string();
    if (name.rfind("video", 0) != 0 || name.find_first_not_of("0123456789", 5) != std::string::npos) continue;
    seen.push_back(name);
    if (::access(node.path().c_str(), R_OK | W_OK) != 0) closed.push_back(name);
  }
  if (seen.empty()) {
    return {"video nodes", Verdict::advice, "none (recordings and the simulator need none)", "plug the cameras in"};
  }
  if (!closed.empty()) {
    return {"video nodes", Verdict::missing, fmt::format("no permission for {}", fmt::join(closed, ", ")),
            "usermod -aG video $USER, then log in again"};
  }
  return {"video nodes", Verdict::good, fmt::format("{}", fmt::join(seen, ", ")), ""};
}

// What a rate that cannot be kept, or only with smaller images, looks like.
Finding rectified_size(const daemon::Config& config, const drivers::SourceInfo& source) {
  constexpr const char* kSubject = "rectified size";
  const auto size = daemon::choose_rectified_size(config, source);
  if (!size) return {kSubject, Verdict::missing, size.error().what + ": " + size.error().where, size.error().remedy};
  Finding f{kSubject, Verdict::good, daemon::describe(*size, source),
            "a faster machine, or lower source.cameras.rate_hz or stereo.num_disparities, keeps more of it"};
  if (f.found.empty()) f.found = fmt::format("{:g} times the raw size, as it is set", size->scale);
  if (size->measured && size->scale != 1.0) f.verdict = size->fits ? Verdict::advice : Verdict::missing;
  return f;
}

void examine_source(const daemon::Config& config, std::vector<Finding>& findings) {
  const auto refused = [&findings](const Error& error) {
    findings.push_back({"source and calibration", Verdict::missing, error.what + ": " + error.where, error.remedy});
  };
  const auto source = daemon::open_source(config.source);
  if (!source) return refused(source.error());
  const auto stage = daemon::StereoStage::make(config.stereo, (*source)->info(), config.rectify);
  if (!stage) return refused(stage.error());
  const StereoModel& m = stage->model();
  findings.push_back({"source and calibration", Verdict::good,
                      fmt::format("{}; baseline {:.4f} m, focal length {:.1f} px", (*source)->info().description,
                                  m.baseline_m, m.fx_px),
                      ""});
  findings.push_back(rectified_size(config, (*source)->info()));
}

}  // namespace

std::vector<Finding> examine(const daemon::ConfigArgument& argument, const std::string& root_path) {
  const fs::path root = root_path.empty() ? fs::path("/") : fs::path(root_path);
  std::vector<Finding> findings{kernel(root),         fifo_right(),     memory_right(),   governor(root),
                                isolated_cores(root), throttling(root), compaction(root), receive_buffer(root),
                                clock_sync(),         cameras(root)};
  const auto config = daemon::read_daemon_config(argument);
  if (!config) {
    findings.push_back(
        {"configuration", Verdict::missing, config.error().what + ": " + config.error().where, config.error().remedy});
    return findings;
  }
  findings.push_back(lcm_route(config->lcm.url));
  examine_source(*config, findings);
  return findings;
}

}  // namespace cliquevo::tools

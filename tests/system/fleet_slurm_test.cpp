// SPDX-License-Identifier: BSD-3-Clause
// `cliquevo fleet` on a real Slurm: two nodes on this machine, one of which is killed in the middle.
#include <chrono>
#include <functional>
#include <thread>
#include <unistd.h>

#include "tests/system/fleet_rig.h"

namespace cliquevo::test {
namespace {

constexpr int kRecordings = 60;
constexpr int kFrames = 80;

class Cluster {
 public:
  explicit Cluster(std::string folder) : folder_(std::move(folder)) {
    const Finished started = run({CLIQUEVO_SLURM_CLUSTER, "start", folder_});
    EXPECT_EQ(started.exit_code, 0) << started.err;
    up_ = started.exit_code == 0;
  }
  ~Cluster() { run({CLIQUEVO_SLURM_CLUSTER, "stop", folder_}); }
  Cluster(const Cluster&) = delete;
  Cluster& operator=(const Cluster&) = delete;

  bool up() const { return up_; }
  void kill_node(const std::string& name) const { run({CLIQUEVO_SLURM_CLUSTER, "kill", folder_, name}); }
  Environment environment() const { return {{"SLURM_CONF", folder_ + "/slurm.conf"}}; }
  // How many elements run on the node.
  std::size_t running_on(const std::string& node) const {
    return lines_of(run({"squeue", "-h", "-r", "-t", "R", "-w", node}, environment()).out).size();
  }
  // Whether Slurm had to begin an element a second time.
  bool requeued_any() const {
    return run({"scontrol", "show", "job"}, environment()).out.find("Restarts=1") != std::string::npos;
  }
  // Jobs that wait or run.
  std::size_t jobs() const { return lines_of(run({"squeue", "-h", "-r"}, environment()).out).size(); }

 private:
  std::string folder_;
  bool up_ = false;
};

bool until(double most_s, const std::function<bool()>& reached) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(most_s);
  while (!reached()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return true;
}

TEST(FleetOnSlurm, EverythingFinishesThoughANodeIsKilledAndResultsAreThoseOfALocalRun) {
  if (::geteuid() != 0) GTEST_SKIP() << "Slurm's daemons need root";
  const std::string folder = scratch_dir();
  const Cluster cluster(folder + "/slurm");
  ASSERT_TRUE(cluster.up());
  std::vector<std::string> words = small_courses(kRecordings, kFrames);
  words.insert(words.end(), {"--set", "stereo.window=7,9"});
  const std::string there = folder + "/there";
  ASSERT_EQ(fleet("plan", there, words).exit_code, 0);
  const Finished submitted =
      fleet("run", there, {"--on", "slurm", "--throttle", "4", "--units-per-task", "20"}, cluster.environment());
  ASSERT_EQ(submitted.exit_code, 0) << submitted.err;

  const auto done = [&] { return results_in(there).size(); };
  // In the middle of what it computes: an element takes several seconds, which killing a node does not.
  ASSERT_TRUE(until(120.0, [&] { return done() >= 10 && cluster.running_on("n2") > 0; }));
  cluster.kill_node("n2");
  const std::size_t at_death = done();
  EXPECT_LT(at_death, 100U) << "killed too late to show anything";
  const Finished status = fleet("status", there);
  EXPECT_NE(status.out.find("a minute"), std::string::npos) << status.out;
  ASSERT_TRUE(until(400.0, [&] { return cluster.jobs() == 0; })) << status.out;
  ASSERT_EQ(done(), 2U * kRecordings);
  EXPECT_TRUE(cluster.requeued_any()) << "the node had nothing to do when it was killed";
  // The report was a job too.
  EXPECT_EQ(report_of(there)["units"]["done"], 2 * kRecordings);
  EXPECT_EQ(report_of(there)["units"]["failed"], 0);

  const Finished again = fleet("run", there, {"--on", "slurm"}, cluster.environment());
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_NE(again.out.find("; 0 to compute"), std::string::npos) << again.out;
  EXPECT_EQ(cluster.jobs(), 0U);

  const std::string here = folder + "/here";
  std::vector<std::string> command{binary("cliquevo"), "fleet", "run", "--out", here};
  command.insert(command.end(), words.begin(), words.end());
  ASSERT_EQ(Subprocess(command).wait(450.0).exit_code, 0);
  EXPECT_EQ(results_in(here), results_in(there));
}

TEST(FleetOnSlurm, AUnitThatFailsIsReportedAndStopsNoOther) {
  if (::geteuid() != 0) GTEST_SKIP() << "Slurm's daemons need root";
  const std::string folder = scratch_dir();
  const Cluster cluster(folder + "/slurm");
  ASSERT_TRUE(cluster.up());
  const std::string gone = folder + "/gone";
  const Finished made = run({binary("cliquevo"), "simulate", "--out", gone, "--width", "160", "--height", "120",
                             "--focal-px", "175", "--frames", "4", "--cache-dir", "none"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  std::vector<std::string> words = small_courses(5, 5);
  words.push_back(gone);
  ASSERT_EQ(fleet("plan", folder + "/fleet", words).exit_code, 0);
  std::filesystem::rename(gone, folder + "/elsewhere");
  const Finished submitted =
      fleet("run", folder + "/fleet", {"--on", "slurm", "--units-per-task", "2"}, cluster.environment());
  ASSERT_EQ(submitted.exit_code, 0) << submitted.err;
  ASSERT_TRUE(until(120.0, [&] { return cluster.jobs() == 0; }));
  EXPECT_EQ(results_in(folder + "/fleet").size(), 5U);
  const nlohmann::json report = report_of(folder + "/fleet");
  ASSERT_EQ(report["failures"].size(), 1U);
  EXPECT_EQ(report["failures"][0]["units"][0]["recording"], "gone");
  // What Slurm does not take is one line of its own words.
  std::filesystem::rename(folder + "/elsewhere", gone);
  const Finished refused =
      fleet("run", folder + "/fleet", {"--on", "slurm", "--slurm=--partition=none"}, cluster.environment());
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_EQ(lines_of(refused.err).size(), 1U) << refused.err;
  EXPECT_NE(refused.err.find("Slurm refuses the job"), std::string::npos) << refused.err;
}

}  // namespace
}  // namespace cliquevo::test

// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <charconv>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "drivers/own_folder.h"
#include "tools/fleet/digest.h"
#include "tools/fleet/engine.h"

namespace cliquevo::tools::fleet {

namespace {

constexpr std::size_t kUsualArraySize = 1001;  // elements' numbers are below it
// A minute or so of work: an element costs the controller and the node about a second.
constexpr double kFramesATask = 5000.0;
constexpr double kFramesOfUnknown = 1000.0;

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

Error no_slurm(const std::string& command, const std::string& words) {
  const std::string name = command + ": ";
  const std::string reason = words.starts_with(name) ? words.substr(name.size()) : words;
  return {"no Slurm here", fmt::format("{}{}", name, reason),
          "install slurm-client and see that its controller answers (sinfo), or run --on local"};
}

// MaxArraySize of the controller, which also shows that one answers.
Result<std::size_t> array_size() {
  const auto shown = run_program({"scontrol", "show", "config"});
  if (!shown) return no_slurm("scontrol", shown.error().remedy);
  if (shown->exit_code != 0) return no_slurm("scontrol", first_line(shown->err));
  const std::size_t key = shown->out.find("MaxArraySize");
  const std::size_t equals = key == std::string::npos ? key : shown->out.find('=', key);
  std::size_t size = kUsualArraySize;
  if (equals == std::string::npos) return size;
  const std::size_t begin = shown->out.find_first_of("0123456789", equals);
  if (begin == std::string::npos) return size;
  std::from_chars(shown->out.data() + begin, shown->out.data() + shown->out.size(), size);
  return std::max<std::size_t>(2, size);
}

std::size_t units_per_task(const Plan& plan, const std::vector<std::size_t>& units, const RunOptions& options,
                           std::size_t most_tasks) {
  double frames = 0.0;
  for (const std::size_t k : units) {
    const std::int64_t known = plan.recording_of(plan.units[k]).frames;
    frames += known > 0 ? static_cast<double>(known) : kFramesOfUnknown;
  }
  const double mean = frames / static_cast<double>(units.size());
  auto each = static_cast<std::size_t>(std::clamp(kFramesATask / mean, 1.0, 1e6));
  if (options.units_per_task > 0) each = static_cast<std::size_t>(options.units_per_task);
  return std::max(each, (units.size() + most_tasks - 1) / most_tasks);
}

// Each element of the array runs the task line of its number.
std::string array_script(const std::string& tasks_file) {
  return fmt::format(
      "#!/bin/sh\n"
      "# Written by cliquevo fleet run --on slurm.\n"
      "exec sh -c \"exec $(sed -n \"$((SLURM_ARRAY_TASK_ID + 1))p\" {})\"\n",
      quoted(tasks_file));
}

// sbatch's answer is the job's number, and behind a semicolon the cluster's name.
Result<std::string> submit(const std::vector<std::string>& words) {
  const auto done = run_program(words);
  if (!done) return no_slurm("sbatch", done.error().remedy);
  if (done->exit_code != 0) {
    return Error{"Slurm refuses the job", first_line(done->err), "see --slurm, which is passed on to sbatch"};
  }
  const std::string job = done->out.substr(0, done->out.find_first_not_of("0123456789"));
  if (job.empty()) return Error{"Slurm refuses the job", first_line(done->out), "see sbatch --parsable"};
  return job;
}

}  // namespace

Result<std::string> submit_to_slurm(const Plan& plan, const std::string& plan_file, const std::string& fleet_folder,
                                    const std::vector<std::size_t>& units, const RunOptions& options) {
  const auto size = array_size();
  if (!size) return size.error();
  const std::vector<std::string> lines =
      task_lines(plan, plan_file, units, units_per_task(plan, units, options, *size - 1));
  const std::string tasks = fmt::format("{}\n", fmt::join(lines, "\n"));
  const std::string id = sha256(tasks).substr(0, 12);
  const auto fleet = drivers::OwnFolder::open(fleet_folder);
  if (!fleet) return fleet.error();
  const auto folder = fleet->below("slurm");
  if (!folder) return folder.error();
  const std::string tasks_file = fmt::format("tasks-{}", id);
  const std::string script = fmt::format("array-{}.sh", id);
  if (auto ok = folder->write(tasks_file, tasks); !ok) return ok.error();
  if (auto ok = folder->write(script, array_script(fmt::format("{}/{}", folder->path(), tasks_file))); !ok)
    return ok.error();

  std::string array = fmt::format("--array=0-{}", lines.size() - 1);
  if (options.throttle > 0) array += fmt::format("%{}", options.throttle);
  // Of a killed node's elements the output goes on where it was; they are begun again elsewhere.
  std::vector<std::string> words{"sbatch",
                                 "--parsable",
                                 "--job-name=cliquevo-fleet",
                                 array,
                                 "--requeue",
                                 "--open-mode=append",
                                 fmt::format("--output={}/%A_%a.txt", folder->path())};
  words.insert(words.end(), options.slurm_options.begin(), options.slurm_options.end());
  words.push_back(fmt::format("{}/{}", folder->path(), script));
  auto job = submit(words);
  if (!job || options.report_command.empty()) return job;

  std::string report = "exec";
  for (const std::string& word : options.report_command) report += fmt::format(" {}", quoted(word));
  words = {"sbatch",
           "--parsable",
           "--job-name=cliquevo-fleet-report",
           fmt::format("--dependency=afterany:{}", *job),
           "--requeue",
           "--open-mode=append",
           fmt::format("--output={}/%j-report.txt", folder->path())};
  words.insert(words.end(), options.slurm_options.begin(), options.slurm_options.end());
  words.insert(words.end(), {"--wrap", report});
  const auto dependent = submit(words);
  if (!dependent) return dependent.error();
  return job;
}

}  // namespace cliquevo::tools::fleet

// SPDX-License-Identifier: BSD-3-Clause
#include "tools/fleet/engine.h"

#include <algorithm>
#include <glib.h>
#include <set>
#include <sys/wait.h>

#include <fmt/format.h>

namespace cliquevo::tools::fleet {

std::vector<std::size_t> missing_units(const Plan& plan, Store& store) {
  std::vector<std::size_t> out;
  std::set<std::string> seen;
  for (std::size_t k = 0; k < plan.units.size(); ++k) {
    const std::string& key = plan.units[k].key;
    if (seen.insert(key).second && !store.read(key, Part::result)) out.push_back(k);
  }
  return out;
}

std::string quoted(const std::string& word) {
  const std::string plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_@%+=:,./-";
  if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) return word;
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::vector<std::string> task_lines(const Plan& plan, const std::string& plan_file,
                                    const std::vector<std::size_t>& units, std::size_t units_per_task) {
  std::vector<std::string> out;
  for (std::size_t begin = 0; begin < units.size(); begin += units_per_task) {
    const auto first = units.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto last = first + static_cast<std::ptrdiff_t>(std::min(units_per_task, units.size() - begin));
    out.push_back(fmt::format("{} fleet run-unit --plan {} --units {}", quoted(plan.program), quoted(plan_file),
                              units_text({first, last})));
  }
  return out;
}

Result<ProgramEnd> run_program(const std::vector<std::string>& words) {
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  gchar* out = nullptr;
  gchar* err = nullptr;
  GError* error = nullptr;
  gint status = 0;
  if (g_spawn_sync(nullptr, arguments.data(), nullptr, G_SPAWN_SEARCH_PATH, nullptr, nullptr, &out, &err, &status,
                   &error) == 0) {
    Error why{"cannot run", words.front(), error->message};
    g_error_free(error);
    return why;
  }
  ProgramEnd end;
  end.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  end.out = out;
  end.err = err;
  g_free(out);
  g_free(err);
  return end;
}

}  // namespace cliquevo::tools::fleet

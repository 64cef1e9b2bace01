// SPDX-License-Identifier: BSD-3-Clause
// What is written from the table of configuration keys: the sample file, the page on it, a JSON schema for editors, and
// the words for completion in a shell.
#pragma once

#include <string>
#include <vector>

namespace cliquevo::tools {

std::string config_sample();  // config/cliquevo.yaml
std::string config_page();    // docs/configuration.md
std::string config_schema();  // config/cliquevo.schema.json
// The checks of the odometry, as JSON in the order of verdicts: what tools/check_tables writes into pages and messages.
std::string check_list();
// What may stand behind --set: "source.type=simulator" where the values are few, else "source.speed=".
std::vector<std::string> config_settings();

}  // namespace cliquevo::tools

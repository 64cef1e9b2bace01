// SPDX-License-Identifier: BSD-3-Clause
// Pages of the runs that have the worst frames: replayed for it, since a node draws nothing.
#pragma once

#include <map>
#include <string>

#include "tools/fleet/report_data.h"

namespace cliquevo::tools::fleet {

// At most so many pages, in FOLDER/pages, each where it is not yet; by the key of the unit, relative to the fleet's
// folder. One that cannot be made is a warning on stderr.
std::map<std::string, std::string> make_pages(const FleetResults& results, std::size_t most);

}  // namespace cliquevo::tools::fleet

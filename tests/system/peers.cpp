// SPDX-License-Identifier: BSD-3-Clause
#include "tests/system/peers.h"

namespace cliquevo::test {

std::string peers_dir() { return CLIQUEVO_PEERS_DIR; }

Finished run_peer(const std::string& script, const std::vector<std::string>& arguments) {
  // The distribution's own python has the modules, whatever else is in the path.
  std::vector<std::string> command{script.ends_with(".py") ? "/usr/bin/python3" : "node", peers_dir() + "/" + script};
  command.insert(command.end(), arguments.begin(), arguments.end());
  Finished done = run(command);
  EXPECT_EQ(done.exit_code, 0) << script << ": " << done.err;
  return done;
}

}  // namespace cliquevo::test

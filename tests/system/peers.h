// SPDX-License-Identifier: BSD-3-Clause
// Other programs' writers and readers (tests/peers), run from tests.
#pragma once

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/subprocess.h"

namespace cliquevo::test {

// A script of tests/peers with its interpreter; fails the test where it does not end with 0.
Finished run_peer(const std::string& script, const std::vector<std::string>& arguments);
// tests/peers itself.
std::string peers_dir();

}  // namespace cliquevo::test

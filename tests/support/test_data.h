// SPDX-License-Identifier: BSD-3-Clause
// Recorded sequences for tests. They are not part of the project; a test without them is reported as skipped.
#pragma once

#include <string>

#include <gtest/gtest.h>

namespace cliquevo::test {

// The recordings' folder: $CLIQUEVO_DATA, else ../shared/data beside the source tree.
std::string data_dir();
bool have_data(const std::string& name);
// Small inputs as users bring them: $CLIQUEVO_FIELD, else ../shared/field beside the source tree.
std::string field_dir();
bool have_field(const std::string& name);
// Path of a program built with the tests, e.g. binary("cliquevo").
std::string binary(const std::string& name);
// A fresh folder for this test case below the system's temporary one, removed at exit of the program.
std::string scratch_dir();

}  // namespace cliquevo::test

// First line of a test that needs the recording NAME (a folder or file below data_dir()).
#define CLIQUEVO_NEEDS_DATA(NAME)                                                               \
  if (!::cliquevo::test::have_data(NAME))                                                       \
  GTEST_SKIP() << "recording " << (NAME) << " not found below " << ::cliquevo::test::data_dir() \
               << " (set CLIQUEVO_DATA)"

// The same for an input below field_dir().
#define CLIQUEVO_NEEDS_FIELD(NAME)         \
  if (!::cliquevo::test::have_field(NAME)) \
  GTEST_SKIP() << "input " << (NAME) << " not found below " << ::cliquevo::test::field_dir() << " (set CLIQUEVO_FIELD)"

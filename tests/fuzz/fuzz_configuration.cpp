// SPDX-License-Identifier: BSD-3-Clause
// The configuration's YAML: an error of one line, or values that pass their own check and print as YAML that reads
// back.
#include "daemon/pipeline/config.h"
#include "daemon/pipeline/effective_config.h"
#include "tests/fuzz/expect.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cliquevo;
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto config = daemon::parse_config(text, "/etc/made/up.yaml");
  if (!config) {
    fuzz::expect_clear(config.error());
    return 0;
  }
  fuzz::expect(config->check().ok(), "what was read passes its check");
  const std::string printed = daemon::effective_config_yaml(*config);
  for (const char c : printed)
    fuzz::expect(c == '\n' || static_cast<unsigned char>(c) >= 0x20, "printed as plain text");
  const auto again = daemon::parse_config(printed, "/etc/made/up.yaml");
  fuzz::expect(again.ok(), "what is printed reads back: " + (again ? std::string() : again.error().line()));
  fuzz::expect(daemon::list_config(*again) == daemon::list_config(*config), "and to the same values");
  return 0;
}

// SPDX-License-Identifier: BSD-3-Clause
// Times files: stamps within bounds, and made to rise.
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "drivers/recording/stamps.h"
#include "drivers/recording/times_file.h"
#include "drivers/text_file.h"
#include "tests/fuzz/expect.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cliquevo;
  const auto table = drivers::parse_times(drivers::utf8_of(std::string(data, data + size)), "/made/up/times.txt");
  if (!table) return fuzz::expect_clear(table.error()), 0;
  fuzz::expect(!table->rows.empty(), "a table has rows");
  std::vector<TimestampNs> stamps;
  for (const drivers::StampRow& row : table->rows) {
    fuzz::expect(std::abs(row.stamp_ns) <= drivers::kMostStampNs, "stamps stay within bounds");
    stamps.push_back(row.stamp_ns);
  }
  const auto rising = drivers::make_rising(stamps, "/made/up/times.txt");
  if (!rising) return fuzz::expect_clear(rising.error()), 0;
  std::optional<TimestampNs> last;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    if (rising->skipped[i]) continue;
    fuzz::expect(!last || rising->stamps_ns[i] > *last, "stamps that are played rise");
    last = rising->stamps_ns[i];
  }
  return 0;
}

// SPDX-License-Identifier: BSD-3-Clause
// Text and numbers as recordings bring them: what is taken, and what is refused rather than guessed.
#include "drivers/text_file.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/bytes.h"
#include "drivers/recording/dates.h"
#include "drivers/recording/pair_store.h"
#include "drivers/recording/pairing.h"
#include "drivers/recording/side_words.h"
#include "drivers/recording/times_file.h"
#include "drivers/recording/times_rows.h"
#include "tests/support/test_data.h"
#include "tests/unit/recording/fixtures.h"

namespace cliquevo::drivers {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

TEST(text_file, numbers_are_numbers_and_nothing_else) {
  EXPECT_EQ(parse_number("-1.5e3"), -1500.0);
  EXPECT_EQ(parse_number("+2"), 2.0);
  for (const char* bad : {"", "+", "+-2", "1,5", "2 ", "0x10", "nan", "inf", "1e999", "1.5px"}) {
    EXPECT_FALSE(parse_number(bad).has_value()) << bad;
  }
  EXPECT_EQ(parse_integer("-42"), -42);
  for (const char* bad : {"", "4.0", "9223372036854775808", "1e3"}) EXPECT_FALSE(parse_integer(bad)) << bad;
}

TEST(text_file, seconds_keep_every_nanosecond) {
  EXPECT_EQ(parse_seconds("1687709319.100414001"), 1'687'709'319'100'414'001);
  EXPECT_EQ(parse_seconds("-0.25"), -kSecond / 4);
  EXPECT_EQ(parse_seconds("1.036e-01"), 103'600'000);
  EXPECT_EQ(parse_seconds("2E3"), 2000 * kSecond);
  EXPECT_EQ(parse_seconds("0.0000000015"), 2) << "rounded";
  EXPECT_EQ(parse_seconds("0.00000000000000000000000001"), 0);
  for (const char* bad : {"", ".", "e3", "1.2.3", "12s", "1e", "99999999999999"}) {
    EXPECT_FALSE(parse_seconds(bad).has_value()) << bad;
  }
}

TEST(text_file, lines_without_comments_and_words_between_blanks_and_commas) {
  const std::string text = "# times\n\n 1.5, 2.5 # first\r\n\t\n3\n";
  const std::vector<TextLine> lines = split_lines(text);
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0].number, 3);
  EXPECT_EQ(lines[0].text, "1.5, 2.5");
  EXPECT_EQ(lines[1].number, 5);
  EXPECT_EQ(split_words(lines[0].text), (std::vector<std::string_view>{"1.5", "2.5"}));
  EXPECT_TRUE(split_words(" ,, ").empty());
  EXPECT_EQ(trim(" \t a b\r\n"), "a b");
  EXPECT_EQ(trim("  "), "");
}

TEST(text_file, a_bad_word_is_named_and_cut) {
  const auto numbers = parse_numbers("1 2,3", "matrix", "K");
  ASSERT_TRUE(numbers.ok());
  EXPECT_EQ(*numbers, (std::vector<double>{1.0, 2.0, 3.0}));
  const auto bad = parse_numbers("1 abc\x1b" + std::string(50, 'x'), "matrix", "K");
  ASSERT_FALSE(bad.ok());
  EXPECT_EQ(bad.error().what, "matrix holds 'abc?" + std::string(28, 'x') + "...'");
  EXPECT_EQ(bad.error().where, "K");
}

TEST(text_file, what_is_no_text_file_is_refused_in_one_line) {
  const std::string folder = test::scratch_dir();
  const auto refused = [](const std::string& path) {
    const auto text = read_text_file(path, "times file", 100);
    EXPECT_FALSE(text.ok()) << path;
    return text.ok() ? std::string() : text.error().line();
  };
  EXPECT_NE(refused(folder + "/none").find("no times file"), std::string::npos);
  EXPECT_NE(refused(folder).find("regular file"), std::string::npos);
  EXPECT_NE(refused("/dev/zero").find("regular file"), std::string::npos);
  EXPECT_NE(refused(test::write_file(folder + "/empty", "")).find("empty"), std::string::npos);
  EXPECT_NE(refused(test::write_file(folder + "/long", std::string(101, 'a'))).find("100 bytes"), std::string::npos);
  EXPECT_NE(refused(test::write_file(folder + "/nul", std::string("ab\0cd", 5))).find("NUL"), std::string::npos);
  const auto marked = read_text_file(test::write_file(folder + "/bom",
                                                      "\xEF\xBB\xBF"
                                                      "1.0\n"),
                                     "times file", 100);
  ASSERT_TRUE(marked.ok());
  EXPECT_EQ(*marked, "1.0\n");
}

TEST(dates, with_and_without_an_offset_from_utc) {
  std::string_view text = "2021-03-02T10:37:17.5+01:00 rest";
  const auto with_offset = take_date_time(text);
  ASSERT_TRUE(with_offset.has_value());
  EXPECT_EQ(text, " rest");
  EXPECT_EQ(*with_offset, 1'614'677'837 * kSecond + kSecond / 2);
  EXPECT_EQ(find_date_time("at 2021/03/02 09:37:17Z, it began"), 1'614'677'837 * kSecond);
  EXPECT_FALSE(find_date_time("frame12021-03-02 10:37:17").has_value()) << "inside a number";
  std::string_view clock = "00:01:02.25;";
  EXPECT_EQ(take_time_of_day(clock), 62 * kSecond + kSecond / 4);
  EXPECT_EQ(clock, ";");
  EXPECT_EQ(parse_dashed_date("2021-03-02-09-37-17-250"), 1'614'677'837 * kSecond + kSecond / 4);
}

TEST(dates, that_are_none) {
  for (const char* bad : {"2021-02-30 10:00:00", "2021-13-01 10:00:00", "1821-03-02 10:00:00", "2021-03-02 24:00:00",
                          "2021-03-02", "2021-03/02 10:00:00"}) {
    std::string_view text = bad;
    EXPECT_FALSE(take_date_time(text).has_value()) << bad;
  }
  EXPECT_FALSE(parse_dashed_date("2021-03-02").has_value());
}

TEST(pairing, each_with_its_mutually_nearest_within_the_tolerance) {
  using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;
  EXPECT_EQ(nearest_pairs({0, 100, 200}, {3, 98, 204}, 10), (Pairs{{0, 0}, {1, 1}, {2, 2}}));
  EXPECT_EQ(nearest_pairs({0, 100, 200}, {3, 204}, 10), (Pairs{{0, 0}, {2, 1}})) << "one is missing";
  EXPECT_EQ(nearest_pairs({95, 100}, {101}, 10), (Pairs{{1, 0}})) << "no image belongs to two";
  EXPECT_TRUE(nearest_pairs({0}, {11}, 10).empty());
  EXPECT_TRUE(nearest_pairs({0}, {}, 10).empty());
  constexpr auto kEnd = std::numeric_limits<std::int64_t>::max();
  EXPECT_TRUE(nearest_pairs({-kEnd}, {kEnd}, 10).empty()) << "their distance is no number";
}

TEST(pairing, the_tolerance_is_a_quarter_of_the_period_unless_given) {
  const std::vector<TimestampNs> stamps{0, 100, 200, 300, 1000};
  EXPECT_EQ(median_period_ns(stamps), 100) << "a gap does not count";
  EXPECT_EQ(median_period_ns({5}), 0);
  EXPECT_EQ(pair_tolerance_ns(std::nullopt, stamps), 25);
  EXPECT_EQ(pair_tolerance_ns(0.002, stamps), 2'000'000);
  EXPECT_EQ(stamp_at(10, 10.0) - stamp_at(0, 10.0), kSecond);
}

TEST(times_rows, words_headings_and_decimal_commas) {
  const TimesText text = split_times("stamp;image\n1,5;\"a b.png\"\n2,5;c.png\n");
  EXPECT_TRUE(text.bare_heading);
  EXPECT_EQ(text.heading_words, (std::vector<std::string>{"stamp", "image"}));
  ASSERT_EQ(text.rows.size(), 2U);
  EXPECT_EQ(text.rows[0].words, (std::vector<std::string>{"1.5", "a b.png"}));
  EXPECT_EQ(text.rows[1].line, 3);
}

TEST(times_file, one_time_by_itself_and_the_unit_of_whole_numbers) {
  EXPECT_EQ(parse_stamp("1687709319.100414"), 1'687'709'319'100'414'000);
  EXPECT_EQ(parse_stamp("1687709319100"), 1'687'709'319'100'000'000) << "ms";
  EXPECT_EQ(parse_stamp("1687709319100414"), 1'687'709'319'100'414'000) << "us";
  EXPECT_EQ(epoch_stamp(1'687'709'319'100'414'001), 1'687'709'319'100'414'001) << "ns";
  EXPECT_FALSE(epoch_stamp(12345).has_value()) << "no time since 1970 in any unit";
  EXPECT_EQ(unit_by_step(33.0), 1'000'000) << "30 Hz in ms";
  EXPECT_EQ(unit_by_step(33'333'333.0), 1);
  EXPECT_EQ(unit_by_step(0.0), std::nullopt);
}

TEST(side_words, every_way_to_read_a_name) {
  const auto kinds = [](const char* name) {
    std::vector<std::pair<int, Side>> out;
    for (const SideReading& reading : read_sides(name)) out.emplace_back(reading.kind, reading.side);
    return out;
  };
  using Readings = std::vector<std::pair<int, Side>>;
  EXPECT_EQ(kinds("imageLeft"), (Readings{{kWordKind, Side::left}}));
  EXPECT_EQ(kinds("cam_r"), (Readings{{kLetterKind, Side::right}}));
  EXPECT_EQ(kinds("cam1"), (Readings{{kFirstNumberKind, Side::right}, {kFirstNumberKind + 1, Side::left}}));
  EXPECT_TRUE(kinds("frames").empty());
  EXPECT_EQ(pair_kind("cam0", "cam1"), kFirstNumberKind);
  EXPECT_FALSE(pair_kind("cam0", "cam2").has_value());
}

// Pairs that are nothing but their number.
class MadeStore : public PairStore {
 public:
  std::int64_t size() const override { return 10; }
  std::string name(std::int64_t i) const override { return "pair " + std::to_string(i); }
  Result<void> load(std::int64_t i, StereoPair& pair) override {
    if (i == 3) return Error{"torn image", name(i), "copy it again"};
    for (Image<std::uint8_t>* image : {&pair.left, &pair.right}) {
      image->resize(8, 6);
      image->fill(static_cast<std::uint8_t>(i));
    }
    return {};
  }
};

std::vector<int> played(const RecordingOptions& options, std::vector<TimestampNs>& stamps) {
  std::vector<TimestampNs> all;
  for (int i = 0; i < 10; ++i) all.push_back(kSecond + i * kSecond / 10);
  all[6] = all[4];  // steps back
  auto rising = make_rising(all, "made");
  EXPECT_TRUE(rising.ok());
  SourceInfo info;
  info.width = 8, info.height = 6;
  const auto source = play_pairs(std::make_unique<MadeStore>(), {}, std::move(*rising), std::move(info), options);
  std::vector<int> out;
  StereoPair pair;
  for (;;) {
    const auto more = source->next(pair);
    if (!more) {
      out.push_back(-1);
    } else if (!*more) {
      return out;
    } else {
      out.push_back(pair.left.cview()(0, 0));
      stamps.push_back(pair.stamp_ns);
    }
  }
}

TEST(pair_store, plays_what_there_is_and_reports_what_it_cannot) {
  for (const bool read_ahead : {true, false}) {
    RecordingOptions options;
    options.read_ahead = read_ahead;
    options.bayer = Bayer::none;
    std::vector<TimestampNs> stamps;
    EXPECT_EQ(played(options, stamps), (std::vector<int>{0, 1, 2, -1, 4, 5, -1, 7, 8, 9})) << "torn, and a step back";
    EXPECT_TRUE(std::is_sorted(stamps.begin(), stamps.end()));
  }
}

TEST(pair_store, a_choice_is_every_so_many_of_those_there_are_or_refused) {
  RecordingOptions options;
  options.first = 1, options.last = 8, options.every = 3;
  const auto chosen = choose_pairs(10, options);
  ASSERT_TRUE(chosen.ok());
  EXPECT_EQ(*chosen, (std::vector<std::int64_t>{1, 4, 7}));
  options = {};
  options.first = 3;
  EXPECT_FALSE(choose_pairs(3, options).ok());
  options.first = 0, options.every = 0;
  EXPECT_FALSE(choose_pairs(3, options).ok());
}

TEST(byte_reader, takes_big_endian_numbers_off_until_there_are_no_more) {
  std::vector<std::uint8_t> bytes;
  put_number<std::int16_t>(bytes, -2);
  put_number<std::uint32_t>(bytes, 0x01020304U);
  put_number<std::int64_t>(bytes, std::numeric_limits<std::int64_t>::min());
  bytes.push_back(7);
  EXPECT_EQ(bytes[2], 1) << "the highest byte first";
  ByteReader reader(bytes.data(), bytes.size());
  EXPECT_EQ(reader.number<std::int16_t>(), -2);
  EXPECT_EQ(reader.number<std::uint32_t>(), 0x01020304U);
  EXPECT_EQ(reader.number<std::int64_t>(), std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(reader.left(), 1U);
  EXPECT_EQ(reader.number<std::int16_t>(), 0);
  EXPECT_FALSE(reader.ok());
  EXPECT_EQ(reader.bytes(1), nullptr) << "what was torn stays torn";
}

}  // namespace
}  // namespace cliquevo::drivers

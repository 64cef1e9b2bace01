// SPDX-License-Identifier: BSD-3-Clause
// Times files as all kinds of programs write them, names that are times, and stamps that do not rise.
#include <filesystem>

#include <fmt/format.h>

#include "drivers/recording.h"
#include "drivers/recording/stamps.h"
#include "drivers/recording/times_file.h"
#include "drivers/text_file.h"
#include "tests/support/test_data.h"
#include "tests/unit/recording/fixtures.h"

namespace cliquevo::drivers {
namespace {

constexpr TimestampNs kMs = 1'000'000;
using Stamps = std::vector<TimestampNs>;

Stamps stamps_of(const std::string& text) {
  const auto table = parse_times(utf8_of(text), "times.txt");
  EXPECT_TRUE(table.ok()) << text << ": " << table.error().line();
  Stamps out;
  if (!table.ok()) return out;
  for (const StampRow& row : table->rows) out.push_back(row.stamp_ns);
  return out;
}

std::string utf16(const std::string& text, bool little, bool mark) {
  std::string out = mark ? (little ? "\xFF\xFE" : "\xFE\xFF") : "";
  for (const char c : text) out += little ? std::string{c, '\0'} : std::string{'\0', c};
  return out;
}

TEST(times_file, ten_hertz_however_it_is_written) {
  const Stamps expected{1'614'681'437'894'528'000, 1'614'681'437'994'528'000, 1'614'681'438'094'528'000};
  for (const char* text : {
           "1614681437.894528\n1614681437.994528\n1614681438.094528\n",
           "1614681437,894528\n1614681437,994528\n1614681438,094528\n",
           "1614681437894528000\n1614681437994528000\n1614681438094528000\n",
           "1614681437894528 1\n1614681437994528 1\n1614681438094528 1\n",
           "1614681437894528\t0\n1614681437994528\t0\n1614681438094528\t1\n",
           "1614681437 894528000\n1614681437 994528000\n1614681438 94528000\n",
           "0,1614681437,894528000\n1,1614681437,994528000\n2,1614681438,94528000\n",
           "0 1614681437 894528\n1 1614681437 994528\n2 1614681438 94528\n",
           "timestamp,filename\n1614681437894528000,0.png\n1614681437994528000,1.png\n1614681438094528000,2.png\n",
           "\"id\";\"time\"\n\"0\";\"1614681437,894528\"\n\"1\";\"1614681437,994528\"\n\"2\";\"1614681438,094528\"\n",
           "0;1614681437.894528\n1;1614681437.994528\n2;1614681438.094528\n",
           "0\t1614681437,894528\n1\t1614681437,994528\n2\t1614681438,094528\n",
           "# frame stamp exposure\n000000 1614681437.894528 0.5\n000001 1614681437.994528 0.4\n000002 "
           "1614681438.094528 0.6\n",
           "1614681437894528000 1614681437.894528 0.5\n1614681437994528000 1614681437.994528 0.5\n1614681438094528000 "
           "1614681438.094528 0.5\n",
           "2021-03-02T10:37:17.894528Z\n2021-03-02T10:37:17.994528Z\n2021-03-02T10:37:18.094528Z\n",
           "2021-03-02T11:37:17.894528+01:00\n2021-03-02T11:37:17.994528+01:00\n2021-03-02T11:37:18.094528+01:00\n",
           "2021-03-02 05:07:17,894528-0530\n2021-03-02 05:07:17,994528-0530\n2021-03-02 05:07:18,094528-0530\n",
           "a.png,2021/03/02 10:37:17.894528\nb.png,2021/03/02 10:37:17.994528\nc.png,2021/03/02 10:37:18.094528\n",
           "id,left,right,t\n0,l/0.png,r/0.png,1614681437.894528\n1,l/1.png,r/1.png,1614681437.994528\n"
           "2,l/2.png,r/2.png,1614681438.094528\n",
           "20210302T103717.894528\n20210302T103717.994528\n20210302T103718.094528\n",
           "20210302T113717.894528+01:00\n20210302T113717.994528+01:00\n20210302T113718.094528+01:00\n",
           "[1614681437.894528,\n1614681437.994528,\n1614681438.094528]\n",
           "[1614681437.894528, 1614681437.994528, 1614681438.094528]\n",
           "(0, 1614681437.894528)\n(1, 1614681437.994528)\n(2, 1614681438.094528)\n",
           "\"2021-03-02 10:37:17.894528\",1\n\"2021-03-02 10:37:17.994528\",2\n\"2021-03-02 10:37:18.094528\",3\n",
       }) {
    EXPECT_EQ(stamps_of(text), expected) << text;
  }
}

TEST(times_file, clocks_that_do_not_count_from_1970) {
  const auto steps = [](const std::string& text) {
    const Stamps s = stamps_of(text);
    return s.size() == 3 && s[2] - s[1] == s[1] - s[0] ? s[1] - s[0] : -1;
  };
  EXPECT_EQ(steps("5123456789012\n5123556789012\n5123656789012\n"), 100 * kMs) << "ns since boot";
  EXPECT_EQ(steps("49599300523\n49599350523\n49599400523\n"), 50 * kMs) << "us since boot";
  EXPECT_EQ(steps("1234567\n1234600\n1234633\n"), 33 * kMs) << "ms since boot";
  EXPECT_EQ(steps("0\n33.5\n67\n"), 33'500'000) << "ms since the start";
  EXPECT_EQ(steps("time_us\n0\n100000\n200000\n"), 100 * kMs);
  EXPECT_EQ(steps("t [ms]\n0\n2\n4\n"), 2 * kMs) << "as the heading says, though seconds would do";
  EXPECT_EQ(steps("10:37:17.0\n10:37:17.1\n10:37:17.2\n"), 100 * kMs) << "times of the day";
  EXPECT_EQ(steps("0,000\n0,100\n0,200\n"), 100 * kMs);
  EXPECT_EQ(steps("0\n1\n2\n"), 1000 * kMs) << "seconds that are likely stay seconds";
  const auto said = parse_times("5123456789012\n5123556789012\n", "times.txt");
  ASSERT_TRUE(said.ok());
  EXPECT_NE(said->note.find("ns"), std::string::npos);
  EXPECT_TRUE(parse_times("0.0\n0.1\n", "times.txt")->note.empty()) << "nothing was concluded";
}

TEST(times_file, ticks_and_days_from_other_years_than_1970) {
  const TimestampNs start = 1'625'228'302'405'400'000;
  EXPECT_EQ(stamps_of("frame,filetime\n0,132697019024054000\n1,132697019025054000\n"),
            (Stamps{start, start + 100 * kMs}));
  EXPECT_EQ(stamps_of("637608251024054000\n637608251025054000\n"), (Stamps{start, start + 100 * kMs})) << ".NET's";
  const Stamps days = stamps_of("738339.500000000\n738339.500001157\n738339.500002315\n");
  ASSERT_EQ(days.size(), 3U);
  EXPECT_NEAR(static_cast<double>(days[0] - 1'625'227'200'000'000'000), 0.0, 1e5) << "noon of a day in 2021";
  EXPECT_NEAR(static_cast<double>(days[2] - days[1]), 1e8, 1e5);
  const auto said = parse_times("637608251024054000\n637608251025054000\n", "times.txt");
  ASSERT_TRUE(said.ok());
  EXPECT_NE(said->note.find("ticks of 100 ns"), std::string::npos) << said->note;
}

TEST(times_file, utf_16_of_either_order_with_its_mark_or_without) {
  for (const bool little : {true, false}) {
    for (const bool mark : {true, false}) {
      EXPECT_EQ(stamps_of(utf16("0.0\r\n0.1\r\n0.2\r\n", little, mark)), (Stamps{0, 100 * kMs, 200 * kMs}));
    }
  }
  EXPECT_EQ(utf8_of(std::string("\xFF\xFE\x3D\xD8\x00\xDE\xB5\x00", 8)), "\xF0\x9F\x98\x80\xC2\xB5");
}

TEST(times_file, lines_that_end_as_on_an_old_mac) {
  const std::string path = test::write_file(test::scratch_dir() + "/times.txt", "time\r0.0\r0.1\r0.2\r");
  const auto text = read_text_file(path, "times file", 1000);
  ASSERT_TRUE(text.ok()) << text.error().line();
  EXPECT_EQ(stamps_of(*text), (Stamps{0, 100'000'000, 200'000'000}));
}

TEST(times_file, junk_is_an_error_with_its_line) {
  for (const auto& [text, line] : std::vector<std::pair<const char*, const char*>>{
           {"0\nabc\n0.2\n", ":2"},
           {"nan\n0.1\n0.2\n", ":1"},
           {"0\n0.1\n9e18\n", ":3"},
           {"2021-03-02 10:37:17\n2021-03-02 10:37:61\n", ":2"},
           {"2021-03-02T10:37:17+25:00\n2021-03-02T10:37:18+25:00\n", ":1"},
           {"1614681437 894528000\n1614681437 x\n1614681438 094528000\n", ":2"},
           {"a\nb\n", ":2"},
       }) {
    const auto table = parse_times(text, "times.txt");
    ASSERT_FALSE(table.ok()) << text;
    test::expect_clear(table.error(), {"no time", std::string("times.txt") + line});
  }
}

// A recording of ten pairs with this times file.
std::string ten_pairs(const std::string& times, const std::string& name = "times.txt") {
  const std::string dir = test::write_kitti_odometry(test::scratch_dir(), 10);
  std::filesystem::remove(dir + "/times.txt");
  test::write_file(dir + "/" + name, times);
  return dir;
}

Result<std::unique_ptr<FrameSource>> open(const std::string& path, std::optional<double> rate_hz = {}) {
  RecordingOptions options;
  options.path = path;
  options.rate_hz = rate_hz;
  return open_recording(options);
}

std::string rows(int count, const char* pattern = "{0:.1f}\n") {
  std::string out;
  for (int i = 0; i < count; ++i) out += fmt::format(fmt::runtime(pattern), 0.1 * i, i);
  return out;
}

TEST(times_file, one_row_more_or_fewer_is_said_and_others_are_refused) {
  auto source = open(ten_pairs(rows(11)));
  ASSERT_TRUE(source.ok()) << source.error().line();
  EXPECT_EQ((*source)->info().frame_count, 10);
  EXPECT_NE((*source)->info().description.find("one row more"), std::string::npos);
  source = open(ten_pairs(rows(9)));
  ASSERT_TRUE(source.ok()) << source.error().line();
  EXPECT_EQ((*source)->info().frame_count, 9);
  EXPECT_NE((*source)->info().description.find("one row fewer"), std::string::npos);
  test::expect_open_error(ten_pairs(rows(8)), {"8 rows for 10 images", "--rate"});
  test::expect_open_error(ten_pairs("garbage\n" + rows(9)), {"9 rows for 10 images"});
}

TEST(times_file, rows_whose_image_is_gone_are_left_out) {
  auto source = open(ten_pairs(rows(14, "{0:.1f} image_0/{1:06}.png\n")));
  ASSERT_TRUE(source.ok()) << source.error().line();
  EXPECT_EQ((*source)->info().frame_count, 10);
  EXPECT_NE((*source)->info().description.find("4 rows"), std::string::npos);
  source = open(ten_pairs(rows(7, "{0:.1f},{1:06}\n")));
  ASSERT_TRUE(source.ok()) << source.error().line();
  EXPECT_EQ((*source)->info().frame_count, 7);
  EXPECT_NE((*source)->info().description.find("3 images not in"), std::string::npos);
  test::expect_open_error(ten_pairs(rows(10, "{0:.1f},frame{1:06}.png\n")),
                          {"names no image that is there", "frame000000"});
}

TEST(times_file, a_list_that_names_the_images_serves_whatever_its_name) {
  for (const char* row : {"{0:.1f} image_0/{1:06}.png\n", "{1:06}.png;{0:.1f}\n",
                          "{1},image_0/{1:06}.png,image_1/{1:06}.png,{0:.1f}\n"}) {
    const auto source = open(ten_pairs(rows(10, row), "associations.txt"));
    ASSERT_TRUE(source.ok()) << row << ": " << source.error().line();
    EXPECT_NEAR((*source)->info().rate_hz, 10.0, 1e-6) << row;
    EXPECT_NE((*source)->info().description.find("times from associations.txt"), std::string::npos);
  }
  // Of other pictures, or of none.
  test::expect_open_error(ten_pairs(rows(10, "{0:.1f} depth/{1:06}.png\n"), "associations.txt"), {"no times"});
  test::expect_open_error(ten_pairs(rows(10), "imu_timestamps.txt"), {"no times"});
}

TEST(times_file, names_in_any_case_and_the_rate_that_is_given_wins) {
  for (const char* name : {"Times.txt", "TIMESTAMPS.TXT", "timestamps.csv", "time.txt", "Timestamps",
                           "stereo.timestamps", "camera_timestamps.txt"}) {
    const auto source = open(ten_pairs(rows(10), name));
    ASSERT_TRUE(source.ok()) << name << ": " << source.error().line();
    EXPECT_NEAR((*source)->info().rate_hz, 10.0, 1e-6) << name;
  }
  // Of each camera, under its folder's name.
  for (const char* name : {"image_0_times.txt", "timestamps_image_0.txt", "timestamp_image_0.csv", "frames.csv"}) {
    const auto own = open(ten_pairs(rows(10, "{0:.1f}\n"), name));
    ASSERT_TRUE(own.ok()) << name << ": " << own.error().line();
    EXPECT_NEAR((*own)->info().rate_hz, 10.0, 1e-6) << name;
  }
  const auto source = open(ten_pairs(rows(10)), 25.0);
  ASSERT_TRUE(source.ok());
  EXPECT_NEAR((*source)->info().rate_hz, 25.0, 1e-6);
}

TEST(times_file, a_list_above_the_images_names_those_of_each_camera) {
  const std::string dir = test::scratch_dir();
  std::string lists[2];
  for (int i = 0; i < 4; ++i) {
    for (const int camera : {0, 1}) {
      const std::string name = fmt::format("img/image_{}_{}.png", camera, i);
      test::write_image(dir + "/" + name, 64, 48, 2 * i + camera);
      lists[camera] += fmt::format("{} {:.3f} {}\n", i, 1540822844.759 + 0.033 * i, name);
    }
  }
  test::write_file(dir + "/left_images.txt", "# id timestamp image_name\n" + lists[0]);
  test::write_file(dir + "/right_images.txt", "# id timestamp image_name\n" + lists[1]);
  test::write_file(dir + "/calib.txt", test::kitti_calibration());
  const auto source = open(dir);
  ASSERT_TRUE(source.ok()) << source.error().line();
  EXPECT_NEAR((*source)->info().rate_hz, 1.0 / 0.033, 0.01);
}

TEST(times_file, a_rate_that_no_camera_has_is_said) {
  const auto fast = open(ten_pairs("0.0\n0.0001\n0.0002\n0.0003\n0.0004\n0.0005\n0.0006\n0.0007\n0.0008\n0.0009\n"));
  ASSERT_TRUE(fast.ok()) << fast.error().line();
  EXPECT_NE((*fast)->info().description.find("--rate"), std::string::npos) << (*fast)->info().description;
}

TEST(names, times_in_names_with_what_else_they_hold) {
  const auto rate_of = [](const std::vector<std::string>& names) {
    const std::string dir = test::scratch_dir();
    for (std::size_t i = 0; i < names.size(); ++i) {
      for (const char* side : {"left", "right"})
        test::write_image(dir + "/" + side + "/" + names[i] + ".png", 64, 48, 0);
    }
    test::write_file(dir + "/calib.txt", test::kitti_calibration());
    const auto source = open(dir);
    return source.ok() ? (*source)->info().rate_hz : 0.0;
  };
  EXPECT_NEAR(rate_of({"1614681437894528000", "1614681437994528000"}), 10.0, 1e-6);
  EXPECT_NEAR(rate_of({"frame_1614681437894528000", "frame_1614681437994528000"}), 10.0, 1e-6);
  EXPECT_NEAR(rate_of({"1614681437_894528000", "1614681437_994528000", "1614681438_94528000"}), 10.0, 1e-6);
  EXPECT_NEAR(rate_of({"1614681437_000000000", "1614681437_100000000", "1614681437_200000000"}), 10.0, 1e-6);
  EXPECT_NEAR(rate_of({"5123456789012", "5123556789012", "5123656789012"}), 10.0, 1e-6) << "ns since boot";
  EXPECT_NEAR(rate_of({"49599300523", "49599350523"}), 20.0, 1e-6) << "us since boot";
  EXPECT_NEAR(rate_of({"2018-07-09-16-11-56_2018-07-09-16-12-51-201", "2018-07-09-16-11-56_2018-07-09-16-12-51-301"}),
              10.0, 1e-6);
  EXPECT_NEAR(rate_of({"20180709_161251_201", "20180709_161251_301", "20180709_161251_401"}), 10.0, 1e-6);
  EXPECT_NEAR(rate_of({"20180709-161251.201", "20180709-161251.301"}), 10.0, 1e-6);
  EXPECT_EQ(rate_of({"000001", "000002", "000003"}), 0.0) << "numbers are no times";
  EXPECT_EQ(rate_of({"v1.0001", "v1.0002"}), 0.0);
}

TEST(rising_stamps, one_that_is_out_of_order_costs_its_pair_alone) {
  const auto rising = [](const Stamps& in) { return *make_rising(in, "log"); };
  RisingStamps r = rising({0, 100, 50, 300});
  EXPECT_EQ(r.skipped, (std::vector<bool>{false, false, true, false}));
  EXPECT_EQ(r.stamps_ns[3], 300);
  r = rising({0, 100, 100, 200});
  EXPECT_EQ(r.skipped, (std::vector<bool>{false, false, true, false}));
  EXPECT_NE(r.reason[2].find("repeats"), std::string::npos);
  // A clock that was set back: one pair goes, the others keep their distances.
  r = rising({0, 100, -150, -50, 50, 150});
  EXPECT_EQ(r.skipped_count, 1);
  EXPECT_TRUE(r.skipped[2]);
  for (std::size_t i = 1; i < 6; ++i) EXPECT_EQ(r.stamps_ns[i] - r.stamps_ns[i - 1], 100) << i;
  EXPECT_EQ(rising({5, 6, 7}).skipped_count, 0);
  EXPECT_FALSE(make_rising({5, 5, 5, 5}, "log").ok());
  EXPECT_FALSE(make_rising({kMostStampNs, 0, 1, 2}, "log").ok());
}

TEST(times_file, those_of_the_field) {
  CLIQUEVO_NEEDS_FIELD("21-times-files");
  for (const auto& [name, pairs, rate] :
       std::vector<std::tuple<const char*, int, double>>{{"header-nohash", 10, 10.0},
                                                         {"iso-offset", 10, 10.0},
                                                         {"onemore", 10, 10.0},
                                                         {"robotcar", 10, 10.0},
                                                         {"sec-nsec", 10, 10.0},
                                                         {"seq-sec-nsec", 10, 10.0},
                                                         {"utf16", 10, 10.0},
                                                         {"dsec-us-since-boot", 6, 20.0}}) {
    const std::string dir = test::write_kitti_odometry(test::scratch_dir(), pairs);
    std::filesystem::copy_file(test::field_dir() + "/21-times-files/" + name + ".txt", dir + "/times.txt",
                               std::filesystem::copy_options::overwrite_existing);
    const auto source = open(dir);
    ASSERT_TRUE(source.ok()) << name << ": " << source.error().line();
    EXPECT_EQ((*source)->info().frame_count, pairs) << name;
    EXPECT_NEAR((*source)->info().rate_hz, rate, 1e-3) << name;
  }
}

TEST(times_file, nanoseconds_since_boot_of_the_field) {
  CLIQUEVO_NEEDS_FIELD("03-stamps-monotonic-ns");
  const auto source = open(test::field_dir() + "/03-stamps-monotonic-ns");
  ASSERT_TRUE(source.ok()) << source.error().line();
  EXPECT_NEAR((*source)->info().rate_hz, 10.0, 1e-6);
  EXPECT_NE((*source)->info().description.find("taken for ns"), std::string::npos);
}

}  // namespace
}  // namespace cliquevo::drivers

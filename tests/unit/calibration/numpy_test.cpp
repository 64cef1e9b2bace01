// SPDX-License-Identifier: BSD-3-Clause
// NumPy's archives: what np.savez and np.savez_compressed write, and what nobody should.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <zlib.h>

#include <fmt/format.h>

#include "drivers/calibration/calibration.h"
#include "drivers/calibration_file.h"
#include "tests/support/test_data.h"
#include "tests/unit/recording/fixtures.h"

namespace cliquevo::drivers {
namespace {

using test::write_file;

std::string little_endian(std::size_t value, int bytes) {
  std::string out;
  for (int i = 0; i < bytes; ++i, value >>= 8U) out += static_cast<char>(value & 255U);
  return out;
}

template <typename T>
std::string cells_of(const Eigen::MatrixXd& m, bool by_columns) {
  std::string out;
  const Eigen::MatrixXd rows = by_columns ? Eigen::MatrixXd(m) : Eigen::MatrixXd(m.transpose());
  for (Eigen::Index i = 0; i < rows.size(); ++i) {
    const auto value = static_cast<T>(rows.data()[i]);
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    out.append(bytes, sizeof(T));
  }
  return out;
}

std::string array_of(const std::string& descr, const std::string& shape, const std::string& cells, int version = 1,
                     bool by_columns = false) {
  std::string head =
      fmt::format("{{'descr': '{}', 'fortran_order': {}, 'shape': {}, }}", descr, by_columns ? "True" : "False", shape);
  head.resize(117, ' ');
  head += '\n';
  std::string out = "\x93NUMPY";
  out += static_cast<char>(version);
  out += '\0';
  return out + little_endian(head.size(), version == 1 ? 2 : 4) + head + cells;
}

std::string array_of(const Eigen::MatrixXd& m) {
  return array_of("<f8", fmt::format("({}, {})", m.rows(), m.cols()), cells_of<double>(m, false));
}
std::string array_of(const std::vector<double>& v) {
  return array_of(Eigen::MatrixXd(Eigen::Map<const Eigen::RowVectorXd>(v.data(), static_cast<Eigen::Index>(v.size()))));
}

std::string deflated(const std::string& data) {
  z_stream stream{};
  EXPECT_EQ(deflateInit2(&stream, 9, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY), Z_OK);
  std::string in = data;
  std::string out(data.size() + 1000, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(in.data());
  stream.avail_in = static_cast<uInt>(in.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(out.size() - stream.avail_out);
  deflateEnd(&stream);
  return out;
}

using Arrays = std::vector<std::pair<std::string, std::string>>;

std::string archive_of(const Arrays& arrays, bool compressed = false) {
  std::string out;
  std::string directory;
  for (const auto& [name, data] : arrays) {
    const std::string packed = compressed ? deflated(data) : data;
    const std::string file = name + ".npy";
    const std::string middle =
        little_endian(compressed ? 8 : 0, 2) + little_endian(0, 4) +
        little_endian(crc32(0, reinterpret_cast<const Bytef*>(data.data()), static_cast<uInt>(data.size())), 4);
    const std::string sizes = little_endian(packed.size(), 4) + little_endian(data.size(), 4);
    directory += "PK\1\2" + little_endian(20, 2) + little_endian(20, 2) + little_endian(0, 2) + middle + sizes +
                 little_endian(file.size(), 2) + little_endian(0, 12) + little_endian(out.size(), 4) + file;
    // NumPy leaves room for sizes beyond 4 GB in the head of each member, and says so in place of them.
    out += "PK\3\4" + little_endian(45, 2) + little_endian(0, 2) + middle + little_endian(0xFFFFFFFFU, 4) +
           little_endian(0xFFFFFFFFU, 4) + little_endian(file.size(), 2) + little_endian(20, 2) + file +
           std::string(20, '\1') + packed;
  }
  return out + directory + "PK\5\6" + little_endian(0, 4) + little_endian(arrays.size(), 2) +
         little_endian(arrays.size(), 2) + little_endian(directory.size(), 4) + little_endian(out.size(), 4) +
         little_endian(0, 2);
}

Arrays arrays_of(const test::Rig& rig) {
  return {{"mtxL", array_of(rig.K_left)},
          {"distL", array_of(rig.D_left)},
          {"mtxR", array_of(rig.K_right)},
          {"distR", array_of(rig.D_right)},
          {"R", array_of(Eigen::MatrixXd(rig.T_right_left.R))},
          {"T", array_of(Eigen::MatrixXd(rig.T_right_left.t))}};
}

std::string& array_named(Arrays& arrays, const std::string& name) {
  return std::find_if(arrays.begin(), arrays.end(), [&](const auto& a) { return a.first == name; })->second;
}

Result<StereoCalibration> read_archive(const std::string& bytes) {
  return read_calibration(write_file(test::scratch_dir() + "/stereo_calibration.npz", bytes), 640, 480);
}

void expect_rig(const Result<StereoCalibration>& c, const test::Rig& rig, double tolerance = 1e-9) {
  ASSERT_TRUE(c.ok()) << c.error().line();
  EXPECT_NEAR(c->left.fx_px, rig.K_left(0, 0), 1e3 * tolerance);
  EXPECT_NEAR(c->right.cx_px, rig.K_right(0, 2), 1e3 * tolerance);
  EXPECT_NEAR(c->right.coefficients[1], rig.D_right[1], tolerance);
  EXPECT_LT((c->T_right_left.R - rig.T_right_left.R).norm(), 1e-6);
  EXPECT_LT((c->T_right_left.t - rig.T_right_left.t).norm(), 1e-6);
}

TEST(NumpyArchive, IsReadAsSavezAndSavezCompressedWriteIt) {
  const test::Rig rig = test::make_rig();
  expect_rig(read_archive(archive_of(arrays_of(rig))), rig);
  expect_rig(read_archive(archive_of(arrays_of(rig), true)), rig);
}

TEST(NumpyArchive, HoldsArraysOfAllVersionsTypesAndOrders) {
  const test::Rig rig = test::make_rig();
  Arrays arrays = arrays_of(rig);
  array_named(arrays, "mtxL") = array_of("<f4", "(3, 3)", cells_of<float>(rig.K_left, false), 2);
  array_named(arrays, "R") = array_of("<f8", "(3, 3)", cells_of<double>(rig.T_right_left.R, true), 3, true);
  array_named(arrays, "T") = array_of("<f8", "(3,)", cells_of<double>(rig.T_right_left.t, false));
  arrays.emplace_back("image_size", array_of("<i8", "(2,)", cells_of<std::int64_t>(Eigen::Vector2d(640, 480), false)));
  arrays.emplace_back("rms", array_of("<f8", "()", cells_of<double>(Eigen::MatrixXd::Constant(1, 1, 0.3), false)));
  const auto c = read_archive(archive_of(arrays));
  expect_rig(c, rig, 1e-4);
  EXPECT_EQ(c->left.width, 640);
}

TEST(NumpyArchive, LensIsThatOfItsWord) {
  Arrays arrays = arrays_of(test::make_rig());
  array_named(arrays, "distL") = array_named(arrays, "distR") =
      array_of(std::vector<double>{0.01, 0.002, 0.001, 0.0005});
  std::string word;
  for (const char c : std::string("fisheye")) word += c + std::string(3, '\0');
  arrays.emplace_back("model", array_of("<U7", "()", word));
  const auto c = read_archive(archive_of(arrays));
  ASSERT_TRUE(c.ok()) << c.error().line();
  EXPECT_EQ(c->left.distortion, Distortion::equidistant);
}

TEST(NumpyArchive, IsFoundBesideARecordingAlsoWithLargeMapsInIt) {
  const test::Rig rig = test::make_rig();
  Arrays arrays = arrays_of(rig);
  arrays.insert(arrays.begin(), {"left_map_x", array_of("<f4", "(480, 640)", std::string(4 * 480 * 640, '\0'))});
  const std::string folder = test::scratch_dir();
  const std::string path = write_file(folder + "/stereo_params.npz", archive_of(arrays));
  write_file(folder + "/poses.npz", archive_of({{"poses", array_of(Eigen::MatrixXd::Identity(4, 4))}}));
  EXPECT_EQ(find_calibration(folder), path);
  expect_rig(read_calibration(path, 640, 480), rig);
}

TEST(NumpyArchive, NamesWhatItHasWhereNothingIsACalibration) {
  const auto c = read_archive(archive_of({{"arr_0", array_of(Eigen::MatrixXd::Identity(3, 3))}}));
  ASSERT_FALSE(c.ok());
  test::expect_clear(c.error(), {"no known format", "arr_0"});
}

TEST(NumpyArchive, MatrixThatIsNoneIsAnError) {
  Arrays arrays = arrays_of(test::make_rig());
  array_named(arrays, "R") = array_of("|O", "()", "pickled");
  const auto c = read_archive(archive_of(arrays));
  ASSERT_FALSE(c.ok());
  test::expect_clear(c.error(), {"(R)", "dtype=O"});
}

TEST(NumpyArchive, TornAndHostileOnesAreErrorsAndTakeNoMemory) {
  const Arrays arrays = arrays_of(test::make_rig());
  const std::string whole = archive_of(arrays, true);
  for (std::size_t size = 4; size < whole.size(); size += 7) {
    const auto c = read_archive(whole.substr(0, size));
    ASSERT_FALSE(c.ok()) << size;
    test::expect_clear(c.error(), {"stereo_calibration.npz"});
  }
  std::string flipped = archive_of(arrays);
  flipped[flipped.find("NUMPY") + 140] ^= 1;
  test::expect_clear(read_archive(flipped).error(), {"torn"});
  Arrays absurd = arrays;
  for (const char* shape : {"(99999999999, 3)", "(4294967296, 4294967296)", "(3, 3", "", "(-3, 3)", "(60, 60)"}) {
    array_named(absurd, "R") = array_of("<f8", shape, "12345678");
    EXPECT_FALSE(read_archive(archive_of(absurd)).ok()) << shape;
  }
  std::string huge = whole;  // a member that claims 4 GB
  for (std::size_t at = 0; (at = huge.find("PK\1\2", at)) != std::string::npos; at += 4) {
    huge.replace(at + 24, 4, "\xFE\xFF\xFF\xFF", 4);
  }
  EXPECT_FALSE(read_archive(huge).ok());
}

TEST(BinaryCalibration, IsNamedWithHowToWriteItOtherwise) {
  for (const char* name : {"K1.npy", "stereoParams.mat", "calib.pkl"}) {
    const std::string folder = test::scratch_dir();
    const auto c = read_calibration(write_file(folder + "/" + name, "PK"), 640, 480);
    ASSERT_FALSE(c.ok());
    test::expect_clear(c.error(), {"no text", "K1", "D1", "T"});
    const bool by_name = name[0] != 'K';
    test::expect_clear(missing_calibration(folder), {by_name ? "no calibration that can be read" : "--calibration"});
    const auto missing = read_calibration(folder + "/nowhere/" + name, 640, 480);
    ASSERT_FALSE(missing.ok());
    test::expect_clear(missing.error(), {"no calibration", "nowhere"});
  }
}

}  // namespace
}  // namespace cliquevo::drivers

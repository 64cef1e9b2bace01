// SPDX-License-Identifier: BSD-3-Clause
// The calibration formats: a row each. A new one is a file with its recognise and read, and a row in formats.cpp.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/calibration/calibration.h"
#include "drivers/calibration/document.h"
#include "drivers/text_file.h"

namespace cliquevo::drivers {

// A file in the forms that formats look at.
struct CalibrationText {
  std::string path;
  std::string text;
  std::vector<TextLine> lines;       // views into `text`; none of an archive
  std::optional<Document> document;  // where the text is YAML, JSON, XML or INI, or NumPy's archive
  std::optional<Error> broken;       // where it should be one of them and is none

  CalibrationText(std::string path, std::string text);
  CalibrationText(const CalibrationText&) = delete;  // `lines` point into it
  CalibrationText& operator=(const CalibrationText&) = delete;

  std::string name() const;  // of the file, without folder
  // Whether a line begins "key:".
  bool has_line(std::string_view key) const;
  bool has(std::string_view key) const { return document && document->has(key); }
};

struct CalibrationFormat {
  const char* name;  // as messages have it
  const char* keys;  // what it is known by
  bool (*recognise)(const CalibrationText& file);
  Result<StereoCalibration> (*read)(const CalibrationText& file, const CalibrationRequest& request,
                                    const OtherFile& other);
};

// In the order in which a file is tried.
std::span<const CalibrationFormat> calibration_formats();

// Formats that others read too. Whatever names its matrices: OpenCV, ORB-SLAM, stella_vslam.
bool is_keyed(const CalibrationText& file);
Result<StereoCalibration> read_keyed(const CalibrationText& file, const CalibrationRequest& request,
                                     const OtherFile& other);
// Texts that ROS's calibrator printed, whatever their file's name.
bool is_ost(const CalibrationText& file);
Result<StereoCalibration> read_ost(const CalibrationText& file, const CalibrationRequest& request,
                                   const OtherFile& other);
// No format of its own: a camera alone. The other one's file and the pose are looked for beside it.
bool is_one_camera(const CalibrationText& file);
Result<StereoCalibration> read_one_camera(const CalibrationText& file, const CalibrationRequest& request,
                                          const OtherFile& other);

// Whether a text without syntax names matrices as programs print them.
bool names_printed_matrices(const CalibrationText& file);
// The text of a file that may be a calibration; of NumPy's archives (.npz) the bytes.
Result<std::string> read_calibration_text(const std::string& path);
// What is said of a file that Python or MATLAB alone read, by its name; nothing = it is none.
std::optional<Error> binary_calibration(const std::string& path);
// Syntaxes of other files of a calibration.
Result<Document> read_other(const OtherFile& other, const std::vector<std::string>& paths);
// The names that the file of the other camera may have: the same one with "left" for "right" and so on.
std::vector<std::string> other_camera_paths(const std::string& path);
// Whether of two files whose names differ in the camera `path` is the right one's.
bool is_right_of(const std::string& path, const std::string& other);
// `path` with its file's name replaced.
std::string beside(const std::string& path, const std::string& name);
// `path` with the last `from` in its last `depth` components replaced; empty = it has none.
std::string replaced(const std::string& path, const std::string& from, const std::string& to, int depth);

}  // namespace cliquevo::drivers

// SPDX-License-Identifier: BSD-3-Clause
// ROS: camera_info of each camera as YAML, or the text that its calibrator prints (ost.txt).
#include <algorithm>

#include <fmt/format.h>

#include "drivers/calibration/camera_parts.h"
#include "drivers/calibration/format.h"

namespace cliquevo::drivers {

namespace {

Result<CameraParts> read_info(const Document& yaml) {
  CameraParts parts;
  parts.where = yaml.path();
  const auto required = [&](std::initializer_list<const char*> names, const char* name) {
    const std::string key = yaml.first_of(names);
    return key.empty() ? std::string(name) : key;
  };
  const std::string k = required({"camera_matrix", "K", "k"}, "camera_matrix");
  const Result<std::vector<double>> K = yaml.numbers(k, 9);
  if (!K) return K.error();
  if (const auto ok = put_camera_matrix(*K, yaml.where(k), parts); !ok) return ok.error();
  const std::string d =
      required({"distortion_coefficients", "distortion_coefficents", "D", "d"}, "distortion_coefficients");
  const Result<std::vector<double>> D = yaml.numbers(d);
  if (!D) return D.error();
  parts.D = *D;
  parts.D_where = yaml.where(d);
  parts.lens = yaml.word("distortion_model");
  if (parts.lens.empty() && D->size() == 4) parts.lens = "plumb_bob";  // ROS' own default
  if (const std::string r = yaml.first_of({"rectification_matrix", "R", "r"}); !r.empty()) {
    const Result<std::vector<double>> R = yaml.numbers(r, 9);
    if (!R) return R.error();
    if (const auto ok = put_rectification(*R, yaml.where(r), parts); !ok) return ok.error();
  } else {
    parts.R = Eigen::Matrix3d::Identity();
  }
  const Result<std::vector<double>> P =
      yaml.numbers(required({"projection_matrix", "P", "p"}, "projection_matrix"), 12);
  if (!P) return P.error();
  parts.P = *P;
  if (auto ok = set_image_size(yaml, parts.camera); !ok) return ok.error();
  return parts;
}

Result<StereoCalibration> read_pair(const Document& left, const Document& right, const CalibrationRequest& request) {
  const Result<CameraParts> l = read_info(left);
  if (!l) return l.error();
  const Result<CameraParts> r = read_info(right);
  if (!r) return r.error();
  std::optional<Eigen::Vector3d> T;
  if (right.has("T")) {
    const Result<std::vector<double>> t = right.numbers("T", 3);
    if (!t) return t.error();
    T = Eigen::Vector3d((*t)[0], (*t)[1], (*t)[2]);
  }
  return rig_of_projections(*l, *r, T, request);
}

// ost.txt: words on a line of their own are a key, the numbers below them its value; [name/left] begins a camera.
// One map of keys a camera.
std::vector<Document> ost_cameras(std::string_view text, const std::string& path) {
  std::vector<Document> cameras;
  DocumentNode camera;
  camera.kind = DocumentNode::Kind::map;
  const auto finish = [&] {
    if (camera.find("camera_matrix") != nullptr) cameras.push_back(Document::of(camera, path));
    camera.entries.clear();
  };
  for (const TextLine& line : split_lines(text)) {
    if (line.text.front() == '[') {
      // A new camera's part begins at [image], or at the second section with matrices.
      if (line.text == "[image]" || camera.find("camera_matrix") != nullptr) {
        const DocumentNode* width = camera.find("width");
        const DocumentNode* height = camera.find("height");
        std::vector<DocumentEntry> size;
        if (width != nullptr && height != nullptr) size = {{"width", *width}, {"height", *height}};
        finish();
        if (line.text != "[image]") camera.entries = std::move(size);
      }
      continue;
    }
    const bool number = line.text.front() == '-' || line.text.front() == '+' || line.text.front() == '.' ||
                        (line.text.front() >= '0' && line.text.front() <= '9');
    if (!number && line.text.substr(0, 3) != "nan" && line.text.substr(0, 3) != "inf") {
      std::string key(line.text.substr(0, 64));
      for (char& c : key) c = c == ' ' ? '_' : c;
      DocumentNode value;
      value.kind = DocumentNode::Kind::scalar;
      value.line = line.number;
      if (camera.entries.size() < 100) camera.entries.push_back({std::move(key), std::move(value)});
      continue;
    }
    if (camera.entries.empty()) continue;
    std::string& value = camera.entries.back().node.scalar;
    if (value.size() > 10000) continue;
    value += ' ';
    value += line.text;
  }
  finish();
  return cameras;
}

// The calibrator prints each camera once more when it writes its files.
void leave_out_repeated(std::vector<Document>& cameras) {
  const auto same = [](const Document& a, const Document& b) {
    return a.word("camera_matrix") == b.word("camera_matrix") && a.word("projection") == b.word("projection");
  };
  for (std::size_t i = 1; i < cameras.size();) {
    const auto end = cameras.begin() + static_cast<std::ptrdiff_t>(i);
    const bool again = std::any_of(cameras.begin(), end, [&](const Document& one) { return same(one, *end); });
    if (again) {
      cameras.erase(end);
    } else {
      ++i;
    }
  }
}

// The keys of ost.txt by their names in YAML.
Document as_camera_info(const Document& camera) {
  DocumentNode root = camera.root();
  for (auto& [key, node] : root.entries) {
    if (key == "distortion") key = "distortion_coefficients";
    if (key == "rectification") key = "rectification_matrix";
    if (key == "projection") key = "projection_matrix";
  }
  return Document::of(std::move(root), camera.path());
}

}  // namespace

bool is_ros(const CalibrationText& file) {
  return file.document && !file.document->first_of({"camera_matrix", "K", "k"}).empty() &&
         !file.document->first_of({"projection_matrix", "P", "p"}).empty();
}

Result<StereoCalibration> read_ros(const CalibrationText& file, const CalibrationRequest& request,
                                   const OtherFile& other) {
  const Result<Document> second = read_other(other, other_camera_paths(file.path));
  if (!second) return second.error();
  const bool swapped = is_right_of(file.path, second->path());
  return read_pair(swapped ? *second : *file.document, swapped ? *file.document : *second, request);
}

bool is_ost(const CalibrationText& file) {
  bool matrix = false;
  for (const TextLine& line : file.lines) {
    matrix = matrix || line.text == "camera matrix";
    if (matrix && line.text == "projection") return true;
  }
  return false;
}

Result<StereoCalibration> read_ost(const CalibrationText& file, const CalibrationRequest& request,
                                   const OtherFile& other) {
  std::vector<Document> cameras = ost_cameras(file.text, file.path);
  leave_out_repeated(cameras);
  if (cameras.size() == 1) {
    const Result<NamedText> second = other(other_camera_paths(file.path));
    if (!second) return second.error();
    std::vector<Document> more = ost_cameras(second->text, second->path);
    if (more.empty()) return Error{"calibration lacks a camera matrix", second->path, "copy it again"};
    cameras.insert(is_right_of(file.path, second->path) ? cameras.begin() : cameras.end(), more.front());
  }
  if (cameras.size() != 2) {
    return Error{fmt::format("calibration is of {} cameras instead of 2", cameras.size()), file.path,
                 "name the text of both cameras, or of one with that of the other beside it"};
  }
  // The first is the left camera's unless its projection is that of the right one.
  Document left = as_camera_info(cameras[0]);
  Document right = as_camera_info(cameras[1]);
  const auto P_left = left.numbers("projection_matrix", 12);
  const auto P_right = right.numbers("projection_matrix", 12);
  if (P_left && P_right && (*P_left)[3] < 0.0 && (*P_right)[3] == 0.0) std::swap(left, right);
  return read_pair(left, right, request);
}

}  // namespace cliquevo::drivers

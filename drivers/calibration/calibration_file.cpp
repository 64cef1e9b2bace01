// SPDX-License-Identifier: BSD-3-Clause
// From a file's name to its calibration: syntax, format, and the other files that belong to it.
#include "drivers/calibration_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "drivers/calibration/checks.h"
#include "drivers/calibration/format.h"
#include "drivers/calibration/zip_archive.h"

namespace cliquevo::drivers {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = 1U << 20U;
constexpr std::size_t kMostArchiveBytes = 256U << 20U;  // rectification maps lie in some

std::string extension_of(const std::string& path) {
  std::string out = fs::path(path).extension().string();
  for (char& c : out) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return out;
}

bool has_key_line(const std::vector<TextLine>& lines, std::string_view key) {
  return std::any_of(lines.begin(), lines.end(), [&](const TextLine& line) {
    return line.text.substr(0, key.size()) == key && trim(line.text.substr(key.size())).substr(0, 1) == ":";
  });
}

bool looks_like_yaml(const std::string& path, const CalibrationText& file) {
  const std::string extension = extension_of(path);
  if (extension == ".yaml" || extension == ".yml" || extension == ".json" || file.text.compare(0, 5, "%YAML") == 0 ||
      file.text.compare(0, 1, "{") == 0) {
    return true;
  }
  const auto known = {"cam0", "T_BS",    "camera_matrix", "image_width", "distortion_model", "K1",     "M1",
                      "K",    "cameras", "cameraMatrix1", "body_T_cam0", "Camera.fx",        "LEFT.K", "K_left"};
  return std::any_of(known.begin(), known.end(), [&](const char* key) { return has_key_line(file.lines, key); });
}

// [section] lines with key = value below them.
bool looks_like_ini(const CalibrationText& file) {
  bool section = false;
  for (const TextLine& line : file.lines) {
    section = section || (line.text.front() == '[' && line.text.back() == ']');
    if (section && line.text.find('=') != std::string_view::npos) return true;
  }
  return false;
}

// Text that a program printed, in a file that is named otherwise.
bool is_printed(const CalibrationText& file) {
  const std::string extension = extension_of(file.path);
  return extension == ".txt" || extension == ".log" || extension == ".m" || extension == ".out";
}

Error unknown_format(const CalibrationText& file) {
  std::string looked_for;
  for (const CalibrationFormat& format : calibration_formats()) {
    looked_for += fmt::format("{}{} ({})", looked_for.empty() ? "" : ", ", format.name, format.keys);
  }
  std::string found = "nothing";
  if (file.document) {
    found = file.document->keys_found();
  } else if (!file.lines.empty()) {
    found = fmt::format("'{}'", printable(file.lines.front().text.substr(0, 40)));
  }
  const std::string where =
      file.document || file.lines.empty() ? file.path : fmt::format("{}:{}", file.path, file.lines.front().number);
  return {fmt::format("calibration is of no known format (found: {})", found), where, "name one of " + looked_for};
}

Result<NamedText> read_first(const std::string& path, const std::vector<std::string>& paths) {
  std::error_code ec;
  std::string wanted;
  for (const std::string& candidate : paths) {
    if (candidate.empty() || candidate == path) continue;
    if (wanted.empty()) wanted = candidate;
    if (!fs::exists(candidate, ec)) continue;
    Result<std::string> text = read_calibration_text(candidate);
    if (!text) return text.error();
    return NamedText{candidate, std::move(*text)};
  }
  return Error{"calibration of the other camera is missing", wanted.empty() ? path : wanted,
               "put both beside each other, named left and right or cam0 and cam1"};
}

}  // namespace

CalibrationText::CalibrationText(std::string file_path, std::string file_text)
    : path(std::move(file_path)),
      text(std::move(file_text)),
      lines(is_zip(text) ? std::vector<TextLine>{} : split_lines(text)) {
  const std::string_view begin = trim(std::string_view(text).substr(0, 256));
  Result<Document> read = Error{};
  if (is_zip(text)) {
    read = Document::parse_numpy(text, path);
  } else if (begin.starts_with("<")) {
    read = Document::parse_xml(text, path);
  } else if (looks_like_yaml(path, *this)) {
    read = Document::parse_yaml(text, path);
  } else if (looks_like_ini(*this)) {
    read = Document::parse_ini(text, path);
  } else {
    return;
  }
  if (read) {
    document = std::move(*read);
  } else {
    broken = read.error();
  }
}

std::string CalibrationText::name() const { return fs::path(path).filename().string(); }

bool CalibrationText::has_line(std::string_view key) const { return has_key_line(lines, key); }

Result<std::string> read_calibration_text(const std::string& path) {
  if (extension_of(path) == ".npz") {
    Result<std::string> bytes = read_whole_file(path, "calibration", kMostArchiveBytes);
    if (!bytes || is_zip(*bytes)) return bytes;
  }
  return read_text_file(path, "calibration", kMostBytes);
}

Result<Document> read_other(const OtherFile& other, const std::vector<std::string>& paths) {
  Result<NamedText> file = other(paths);
  if (!file) return file.error();
  CalibrationText parsed(std::move(file->path), std::move(file->text));
  if (parsed.broken) return *parsed.broken;
  if (!parsed.document) return unknown_format(parsed);
  return std::move(*parsed.document);
}

bool names_printed_matrices(const CalibrationText& file) {
  if (file.document) return false;
  CalibrationText plain(file.path, "");
  for (const auto parse : {Document::parse_ini, Document::parse_printed}) {
    auto lines = parse(file.text, file.path);
    if (!lines) continue;
    plain.document = std::move(*lines);
    if (is_keyed(plain)) return true;
  }
  return false;
}

Result<StereoCalibration> parse_calibration(const std::string& text, const CalibrationRequest& request,
                                            const OtherFile& other) {
  const CalibrationText file(request.path, text);
  if (file.lines.empty() && !is_zip(text)) return Error{"calibration is empty", request.path, "copy it again"};
  if (is_ost(file)) return read_ost(file, request, other);  // what the calibrator printed, whatever its file's name
  if (file.broken && !is_printed(file)) return *file.broken;
  for (const CalibrationFormat& format : calibration_formats()) {
    if (format.recognise(file)) return format.read(file, request, other);
  }
  if (!file.document) {  // lines "key: numbers", or numbers below their key, of nobody's format may name what they are
    CalibrationText plain(request.path, text);
    std::optional<Error> found;
    for (const auto parse : {Document::parse_ini, Document::parse_printed}) {
      auto lines = parse(text, request.path);
      if (!lines) continue;
      plain.document = std::move(*lines);
      if (!is_keyed(plain)) continue;
      auto read = read_keyed(plain, request, other);
      if (read) return read;
      found = read.error();
    }
    if (found) return *found;
  }
  if (file.document && is_one_camera(file)) return read_one_camera(file, request, other);
  return file.broken ? *file.broken : unknown_format(file);
}

namespace {

Result<StereoCalibration> read_from_memory(const CalibrationRequest& request) {
  const auto other = [&](const std::vector<std::string>&) -> Result<NamedText> {
    if (request.texts.size() > 1) return request.texts[1];
    return Error{"calibration of the other camera is missing", request.path, "name one of both cameras"};
  };
  auto read = parse_calibration(request.texts.front().text, request, other);
  if (read) read->notes.insert(read->notes.end(), request.notes.begin(), request.notes.end());
  return read;
}

}  // namespace

Result<StereoCalibration> read_calibration(const CalibrationRequest& request) {
  if (auto ok = request.options.check(); !ok) return ok.error();
  if (!request.texts.empty()) return read_from_memory(request);
  std::error_code ec;
  CalibrationRequest file = request;
  if (fs::is_directory(request.path, ec)) {
    file.path = find_calibration(request.path);
    if (file.path.empty()) {
      return Error{"folder holds no calibration", request.path, "name the file with --calibration"};
    }
    if (file.path == request.path) {
      return Error{"folder holds several calibrations", request.path, "name one with --calibration"};
    }
  }
  if (const auto binary = fs::exists(file.path, ec) ? binary_calibration(file.path) : std::nullopt) return *binary;
  const Result<std::string> text = read_calibration_text(file.path);
  if (!text) return text.error();
  return parse_calibration(*text, file, [&](const std::vector<std::string>& paths) {
    auto found = read_first("", paths);
    if (!found && found.error().where.empty())
      return Result<NamedText>(Error{found.error().what, file.path, found.error().remedy});
    return found;
  });
}

Result<StereoCalibration> read_calibration(const std::string& path, int width, int height,
                                           const CalibrationOptions& options) {
  CalibrationRequest request;
  request.path = path;
  request.width = width;
  request.height = height;
  request.options = options;
  return read_calibration(request);
}

Result<void> CalibrationOptions::check() const {
  if (!(baseline_unit_m >= 0.0 && baseline_unit_m <= 1e6)) {
    return Error{"configuration value out of range", "baseline_unit", "give metres a unit, 0 to 1e6"};
  }
  if (!(readout_ms >= 0.0 && readout_ms <= 1000.0)) {
    return Error{"configuration value out of range", "readout_ms", "give milliseconds, 0 to 1000"};
  }
  if (lens.empty() || lens == "plumb_bob" || lens == "equidistant") return {};
  return Error{"configuration value out of range", "lens", "give plumb_bob, equidistant, or nothing"};
}

}  // namespace cliquevo::drivers

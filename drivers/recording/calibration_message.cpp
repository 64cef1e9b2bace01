// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/calibration_message.h"

#include <algorithm>
#include <cmath>
#include <exception>

#include <cliquevo/calibration_t.hpp>
#include <cliquevo/prism_calibration_t.hpp>

#include "drivers/bytes.h"
#include "drivers/calibration/checks.h"

namespace cliquevo::drivers {

namespace {

void put(const Eigen::Matrix3d& R, double (&out)[3][3]) {
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) out[r][c] = R(r, c);
  }
}

Eigen::Matrix3d matrix(const double (&in)[3][3]) {
  Eigen::Matrix3d R;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) R(r, c) = in[r][c];
  }
  return R;
}

void put(const CameraCalibration& camera, std::int32_t& width, std::int32_t& height, double (&pinhole)[4],
         std::int8_t& distortion, double (&coefficients)[8]) {
  width = camera.width;
  height = camera.height;
  pinhole[0] = camera.fx_px;
  pinhole[1] = camera.fy_px;
  pinhole[2] = camera.cx_px;
  pinhole[3] = camera.cy_px;
  distortion = static_cast<std::int8_t>(camera.distortion);
  std::copy(camera.coefficients.begin(), camera.coefficients.end(), coefficients);
}

CameraCalibration camera(std::int32_t width, std::int32_t height, const double (&pinhole)[4], std::int8_t distortion,
                         const double (&coefficients)[8]) {
  CameraCalibration out;
  out.width = width;
  out.height = height;
  out.fx_px = pinhole[0];
  out.fy_px = pinhole[1];
  out.cx_px = pinhole[2];
  out.cy_px = pinhole[3];
  out.distortion = static_cast<Distortion>(distortion);
  std::copy(std::begin(coefficients), std::end(coefficients), out.coefficients.begin());
  return out;
}

void put(const Image<std::uint8_t>& mask, std::int32_t& size, std::vector<std::uint8_t>& out) {
  const ImageView<const std::uint8_t> view = mask.cview();
  for (int y = 0; y < view.height; ++y) out.insert(out.end(), view.row(y), view.row(y) + view.width);
  size = static_cast<std::int32_t>(out.size());
}

// Whether the message is as long as its own counts imply: the generated decoder allocates by them unchecked.
bool is_whole(const std::uint8_t* data, std::size_t size) {
  ByteReader reader(data, size);
  const bool of_prism = reader.number<std::int64_t>() == prism_calibration_t::getHash();
  // From the texts to the masks: an empty message but for type, time, two texts of one byte and two counts.
  const auto between = static_cast<std::size_t>(calibration_t{}.getEncodedSize()) - 2 * 8 - 2 * (4 + 1) - 2 * 4;
  const auto behind =
      of_prism ? static_cast<std::size_t>(prism_calibration_t{}.getEncodedSize() - calibration_t{}.getEncodedSize())
               : 0;
  const auto counted = [&reader](std::int32_t least) {
    const auto count = reader.number<std::int32_t>();
    return count >= least && reader.bytes(static_cast<std::size_t>(count)) != nullptr;
  };
  reader.bytes(8);  // time
  const bool texts = counted(1) && counted(1);
  reader.bytes(between);
  const bool masks = counted(0) && counted(0);
  reader.bytes(behind);
  return texts && masks && reader.ok() && reader.left() == 0;
}

bool read_mask(const std::vector<std::uint8_t>& bytes, const CameraCalibration& of, Image<std::uint8_t>& mask) {
  if (bytes.empty()) return true;
  if (bytes.size() != static_cast<std::size_t>(of.width) * static_cast<std::size_t>(of.height)) return false;
  mask.copy_from({bytes.data(), of.width, of.height, of.width});
  return true;
}

template <typename Message>
std::vector<std::uint8_t> encoded(const Message& m) {
  std::vector<std::uint8_t> out(static_cast<std::size_t>(m.getEncodedSize()));
  m.encode(out.data(), 0, static_cast<int>(out.size()));
  return out;
}

// False: it is another type, or torn; the message is left empty.
template <typename Message>
bool decode(const std::uint8_t* data, std::size_t size, Message& message) {
  if (size < sizeof(std::int64_t) || size > (std::size_t{1} << 30)) return false;
  try {  // the generated decoder takes negative lengths for huge ones
    if (message.decode(data, 0, static_cast<int>(size)) >= 0) return true;
  } catch (const std::exception&) {
  }
  message = Message{};
  return false;
}

}  // namespace

std::vector<std::uint8_t> encode_calibration(const SourceInfo& info, TimestampNs now_ns) {
  calibration_t m{};
  const StereoCalibration& c = info.calibration;
  m.utime = now_ns / 1000;
  m.description = info.description;
  m.source = c.source;
  m.rate_hz = info.rate_hz;
  put(c.left, m.left_width, m.left_height, m.left_camera, m.left_distortion, m.left_coefficients);
  put(c.right, m.right_width, m.right_height, m.right_camera, m.right_distortion, m.right_coefficients);
  put(c.T_right_left.R, m.R_right_left);
  for (int i = 0; i < 3; ++i) m.t_right_left[i] = c.T_right_left.t[i];
  m.rectified = c.rectified ? 1 : 0;
  m.prescribed = c.prescribed ? 1 : 0;
  const PrescribedRectification p = c.prescribed.value_or(PrescribedRectification{});
  put(p.R_left, m.R_left);
  put(p.R_right, m.R_right);
  m.model_width = p.model.width;
  m.model_height = p.model.height;
  const double model[6] = {p.model.fx_px, p.model.fy_px,      p.model.cx_px,
                           p.model.cy_px, p.model.baseline_m, p.model.doffs_px};
  std::copy(std::begin(model), std::end(model), m.model);
  put(info.left_mask, m.left_mask_size, m.left_mask);
  put(info.right_mask, m.right_mask_size, m.right_mask);
  if (c.left.distortion != Distortion::thin_prism && c.right.distortion != Distortion::thin_prism) return encoded(m);
  prism_calibration_t with_prism{};
  with_prism.calibration = m;
  std::copy(c.left.prism.begin(), c.left.prism.end(), std::begin(with_prism.left_prism));
  std::copy(c.right.prism.begin(), c.right.prism.end(), std::begin(with_prism.right_prism));
  return encoded(with_prism);
}

Result<SourceInfo> parse_calibration_message(const std::uint8_t* data, std::size_t size, const std::string& path) {
  const auto bad = [&path] { return calibration_error("calibration message is torn or of another version", path); };
  if (size > (std::size_t{1} << 30) || !is_whole(data, size)) return bad();
  prism_calibration_t with_prism{};
  if (!decode(data, size, with_prism) && !decode(data, size, with_prism.calibration)) return bad();
  const calibration_t& m = with_prism.calibration;
  SourceInfo info;
  info.description = m.description;
  info.rate_hz = std::isfinite(m.rate_hz) && m.rate_hz > 0.0 ? m.rate_hz : 0.0;
  StereoCalibration c;
  for (const std::int8_t distortion : {m.left_distortion, m.right_distortion}) {
    if (distortion < calibration_t::NONE || distortion > calibration_t::DOUBLE_SPHERE) return bad();
  }
  c.left = camera(m.left_width, m.left_height, m.left_camera, m.left_distortion, m.left_coefficients);
  c.right = camera(m.right_width, m.right_height, m.right_camera, m.right_distortion, m.right_coefficients);
  std::copy(std::begin(with_prism.left_prism), std::end(with_prism.left_prism), c.left.prism.begin());
  std::copy(std::begin(with_prism.right_prism), std::end(with_prism.right_prism), c.right.prism.begin());
  c.T_right_left.R = matrix(m.R_right_left);
  for (int i = 0; i < 3; ++i) c.T_right_left.t[i] = m.t_right_left[i];
  if (m.prescribed != 0) {
    PrescribedRectification p;
    p.R_left = matrix(m.R_left);
    p.R_right = matrix(m.R_right);
    p.model = {m.model_width, m.model_height, m.model[0], m.model[1], m.model[2], m.model[3], m.model[4], m.model[5]};
    c.prescribed = p;
  }
  c.rectified = m.rectified != 0;
  if (c.rectified && !c.prescribed) return bad();
  CalibrationRequest request;
  request.path = path;
  request.options.baseline_unit_m = 1.0;  // metres, whatever the file had
  const StereoCalibration as_written = c;
  auto finished = finish_calibration(std::move(c), request);  // its checks; the numbers stay those that were written
  if (!finished) return finished.error();
  info.calibration = as_written;
  info.calibration.source = m.source.empty() ? path : m.source;
  info.width = as_written.left.width;
  info.height = as_written.left.height;
  if (!read_mask(m.left_mask, as_written.left, info.left_mask) ||
      !read_mask(m.right_mask, as_written.right, info.right_mask)) {
    return bad();
  }
  return info;
}

}  // namespace cliquevo::drivers

// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/libcamera/libcamera_camera.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <ctime>
#include <linux/videodev2.h>
#include <sys/mman.h>
#include <unistd.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "drivers/libcamera/log_filter.h"

namespace cliquevo::drivers {

namespace {

using libcamera::PixelFormat;

constexpr unsigned kBuffers = 6;

std::int64_t now_ns(clockid_t clock) {
  timespec now = {};
  ::clock_gettime(clock, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

// libcamera names formats as the kernel's display side does; all but the grey ones are called alike.
// MIPI's packed formats have the names of the unpacked ones and a modifier.
std::uint32_t packed_to_v4l2(std::uint32_t fourcc) {
  switch (fourcc) {
    case v4l2_fourcc('R', '1', '0', ' '):
      return V4L2_PIX_FMT_Y10P;
    case v4l2_fourcc('R', '1', '2', ' '):
      return v4l2_fourcc('Y', '1', '2', 'P');
    case V4L2_PIX_FMT_SBGGR10:
      return V4L2_PIX_FMT_SBGGR10P;
    case V4L2_PIX_FMT_SGBRG10:
      return V4L2_PIX_FMT_SGBRG10P;
    case V4L2_PIX_FMT_SGRBG10:
      return V4L2_PIX_FMT_SGRBG10P;
    case V4L2_PIX_FMT_SRGGB10:
      return V4L2_PIX_FMT_SRGGB10P;
    case V4L2_PIX_FMT_SBGGR12:
      return V4L2_PIX_FMT_SBGGR12P;
    case V4L2_PIX_FMT_SGBRG12:
      return V4L2_PIX_FMT_SGBRG12P;
    case V4L2_PIX_FMT_SGRBG12:
      return V4L2_PIX_FMT_SGRBG12P;
    case V4L2_PIX_FMT_SRGGB12:
      return V4L2_PIX_FMT_SRGGB12P;
    default:
      return 0;  // none that is known
  }
}

std::uint32_t to_v4l2(const PixelFormat& format) {
  constexpr std::uint64_t kMipiPacked = 11ULL << 56U | 1U;  // MIPI_FORMAT_MOD_CSI2_PACKED
  if (format.modifier() == kMipiPacked) return packed_to_v4l2(format);
  if (format.modifier() != 0) return 0;
  switch (format.fourcc()) {
    case v4l2_fourcc('R', '8', ' ', ' '):
      return V4L2_PIX_FMT_GREY;
    case v4l2_fourcc('R', '1', '0', ' '):
      return V4L2_PIX_FMT_Y10;
    case v4l2_fourcc('R', '1', '2', ' '):
      return V4L2_PIX_FMT_Y12;
    default:
      return format.fourcc();
  }
}

}  // namespace

libcamera::CameraManager* camera_manager() {
  [[maybe_unused]] static const bool quiet = (show_only_errors_of_libcamera(), true);
  static libcamera::CameraManager manager;
  static const bool started = manager.start() == 0;
  return started ? &manager : nullptr;
}

Error LibcameraCamera::refused(const std::string& what) const {
  return {fmt::format("camera refuses {}", what), id_, "check its settings (`cliquevo cameras` lists what there is)"};
}

Result<std::unique_ptr<LibcameraCamera>> LibcameraCamera::open(const std::string& id, const CameraOptions& options,
                                                               std::function<void(const LibcameraFrame&)> on_frame,
                                                               OpenTrouble& trouble) {
  trouble = OpenTrouble::lasting;
  libcamera::CameraManager* manager = camera_manager();
  if (manager == nullptr) return Error{"libcamera does not start", id, "its own lines above have the reason"};
  std::unique_ptr<LibcameraCamera> out(new LibcameraCamera());
  out->id_ = id;
  out->on_frame_ = std::move(on_frame);
  out->camera_ = manager->get(id);
  if (!out->camera_) {
    trouble = OpenTrouble::absent;
    std::vector<std::string> seen;
    for (const auto& camera : manager->cameras()) seen.push_back(camera->id());
    return Error{"no such camera", id,
                 seen.empty() ? "libcamera sees none: check cable, power and the group video"
                              : fmt::format("there is {}", fmt::join(seen, ", "))};
  }
  const int acquired = out->camera_->acquire();
  if (acquired != 0) {
    trouble = acquired == -EBUSY ? OpenTrouble::held : OpenTrouble::absent;
    return Error{"camera is busy", id, "another program holds it: end that one"};
  }
  out->acquired_ = true;
  auto set_up = out->configure(options);
  if (set_up) set_up = out->map_buffers();
  if (set_up) set_up = out->set_controls(options);
  if (!set_up) {
    trouble = out->trouble();
    return set_up.error();
  }
  out->camera_->requestCompleted.connect(out.get(), &LibcameraCamera::completed);
  out->camera_->disconnected.connect(out.get(), &LibcameraCamera::disconnected);
  return out;
}

OpenTrouble LibcameraCamera::trouble() const {
  libcamera::CameraManager* manager = camera_manager();
  return manager != nullptr && manager->get(id_) ? OpenTrouble::lasting : OpenTrouble::absent;
}

LibcameraCamera::~LibcameraCamera() {
  stopping_ = true;
  if (camera_) {
    if (started_) camera_->stop();
    camera_->requestCompleted.disconnect(this);
    camera_->disconnected.disconnect(this);
  }
  requests_.clear();
  for (const auto& [buffer, mapped] : mapped_) ::munmap(mapped.data, mapped.size);
  if (allocator_ && configuration_) allocator_->free(configuration_->at(0).stream());
  allocator_.reset();
  if (acquired_) camera_->release();
}

Result<void> LibcameraCamera::configure(const CameraOptions& options) {
  configuration_ = video_configuration(*camera_);
  if (!configuration_ || configuration_->empty()) return refused("to be configured");
  libcamera::StreamConfiguration& stream = configuration_->at(0);
  std::vector<std::string> names;
  PixelFormat wanted;
  for (const PixelFormat& format : stream.formats().pixelformats()) {
    names.push_back(format.toString());
    const std::uint32_t fourcc = to_v4l2(format);
    const bool named = format.toString() == options.pixel_format;
    const bool open = options.pixel_format.empty();
    const bool better = !wanted.isValid() || (is_mosaic_format(to_v4l2(wanted)) && !is_mosaic_format(fourcc));
    const bool first_known = open && better && is_known_format(fourcc);
    const bool grey = open && fourcc == V4L2_PIX_FMT_GREY;
    if (named || first_known || grey) wanted = format;
  }
  if (!wanted.isValid() || !is_known_format(to_v4l2(wanted))) {
    return Error{"pixel format is not offered",
                 fmt::format("{}: {}", id_, options.pixel_format.empty() ? "any that is known" : options.pixel_format),
                 fmt::format("it offers {}", fmt::join(names, ", "))};
  }
  stream.pixelFormat = wanted;
  const int images = image_width(options.layout, to_v4l2(wanted), 2) == 2 ? 1 : 2;
  if (options.width > 0) stream.size.width = static_cast<unsigned>(options.width * images);
  if (options.height > 0) stream.size.height = static_cast<unsigned>(options.height);
  stream.bufferCount = kBuffers;
  if (configuration_->validate() == libcamera::CameraConfiguration::Invalid) return refused("the configuration");
  const bool as_wanted = stream.pixelFormat == wanted &&
                         (options.width == 0 || stream.size.width == static_cast<unsigned>(options.width * images)) &&
                         (options.height == 0 || stream.size.height == static_cast<unsigned>(options.height));
  if (!as_wanted) {
    return Error{"camera refuses the size", id_,
                 fmt::format("it gives {}: set width and height to what it can (0 = as it likes)", stream.toString())};
  }
  if (camera_->configure(configuration_.get()) != 0) return refused("the configuration");
  width_ = static_cast<int>(stream.size.width);
  height_ = static_cast<int>(stream.size.height);
  stride_ = stream.stride;
  fourcc_ = to_v4l2(stream.pixelFormat);
  return {};
}

Result<void> LibcameraCamera::map_buffers() {
  libcamera::Stream* stream = configuration_->at(0).stream();
  allocator_ = std::make_unique<libcamera::FrameBufferAllocator>(camera_);
  if (allocator_->allocate(stream) < 0) return refused("buffers");
  for (const auto& buffer : allocator_->buffers(stream)) {
    // All planes lie in one piece of memory, the grey one first.
    const auto& plane = buffer->planes().front();
    const std::size_t offset = plane.offset == libcamera::FrameBuffer::Plane::kInvalidOffset ? 0 : plane.offset;
    const std::size_t size = offset + plane.length;
    void* data = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, plane.fd.get(), 0);
    if (data == MAP_FAILED) return refused("to share its buffers");
    mapped_[buffer.get()] = {static_cast<std::uint8_t*>(data), size, offset};
    auto request = camera_->createRequest();
    if (!request || request->addBuffer(stream, buffer.get()) != 0) return refused("requests");
    requests_.push_back(std::move(request));
  }
  return {};
}

Result<void> LibcameraCamera::set_controls(const CameraOptions& options) {
  const libcamera::ControlInfoMap& offered = camera_->controls();
  controls_ = libcamera::ControlList(offered);
  const auto has = [&offered](const libcamera::ControlId& id) { return offered.find(&id) != offered.end(); };
  if (has(libcamera::controls::FrameDurationLimits)) {
    const auto period_us = static_cast<std::int64_t>(std::llround(1e6 / options.rate_hz));
    const std::int64_t limits[2] = {period_us, period_us};
    controls_.set(libcamera::controls::FrameDurationLimits, libcamera::Span<const std::int64_t, 2>(limits));
  }
  if (options.exposure_us) {
    if (!has(libcamera::controls::ExposureTime)) return refused("the exposure time (set exposure_us to auto)");
    if (has(libcamera::controls::AeEnable)) controls_.set(libcamera::controls::AeEnable, false);
    controls_.set(libcamera::controls::ExposureTime, static_cast<std::int32_t>(std::lround(*options.exposure_us)));
  }
  if (options.exposure_max_us > 0.0 && !options.exposure_us) {
    if (auto ok = limit_exposure(options); !ok) return ok;
  }
  if (options.gain) {
    if (!has(libcamera::controls::AnalogueGain)) return refused("the gain (set gain to auto)");
    controls_.set(libcamera::controls::AnalogueGain, static_cast<float>(*options.gain));
  }
  return {};
}

// libcamera's own control knows no limit of the exposure time: it is ours that acts.
Result<void> LibcameraCamera::limit_exposure(const CameraOptions& options) {
  const libcamera::ControlInfoMap& offered = camera_->controls();
  const auto time = offered.find(&libcamera::controls::ExposureTime);
  if (time == offered.end() || time->second.min().get<std::int32_t>() > options.exposure_max_us) {
    return refused("so short a limit of its exposure time (set exposure_max_us to more, or to 0)");
  }
  ExposureRange range;
  range.least.exposure_us = std::max(1, time->second.min().get<std::int32_t>());
  range.most.exposure_us = std::min<double>(time->second.max().get<std::int32_t>(), options.exposure_max_us);
  const auto gain = offered.find(&libcamera::controls::AnalogueGain);
  if (gain != offered.end()) {
    range.least.gain = gain->second.min().get<float>();
    range.most.gain = gain->second.max().get<float>();
  }
  if (options.gain) range.least.gain = range.most.gain = *options.gain;
  exposure_range_ = range;
  if (offered.find(&libcamera::controls::AeEnable) != offered.end()) {
    controls_.set(libcamera::controls::AeEnable, false);
  }
  controls_.set(libcamera::controls::ExposureTime, static_cast<std::int32_t>(range.most.exposure_us));
  return {};
}

Result<void> LibcameraCamera::start() {
  last_frame_mono_ns_ = now_ns(CLOCK_MONOTONIC);
  if (camera_->start(&controls_) != 0) return refused("to start");
  started_ = true;
  for (const auto& request : requests_) {
    if (camera_->queueRequest(request.get()) != 0) return refused("requests");
  }
  return {};
}

void LibcameraCamera::follow(std::int32_t exposure_us, float gain) {
  follow_exposure_us_ = exposure_us;
  follow_gain_ = gain;
}

void LibcameraCamera::completed(libcamera::Request* request) {
  if (stopping_ || request->status() == libcamera::Request::RequestCancelled) return;
  const libcamera::FrameBuffer* buffer = request->buffers().begin()->second;
  const libcamera::FrameMetadata& metadata = buffer->metadata();
  LibcameraFrame frame;
  frame.arrival_mono_ns = now_ns(CLOCK_MONOTONIC);
  frame.arrival_utc_ns = now_ns(CLOCK_REALTIME);
  last_frame_mono_ns_ = frame.arrival_mono_ns;
  const auto sensor_ns = request->metadata().get(libcamera::controls::SensorTimestamp);
  const std::int64_t stamp_ns = sensor_ns ? *sensor_ns : static_cast<std::int64_t>(metadata.timestamp);
  frame.stamp_utc_ns = stamp_ns + (frame.arrival_utc_ns - frame.arrival_mono_ns);
  if (const auto exposure_us = request->metadata().get(libcamera::controls::ExposureTime)) {
    exposure_us_ = *exposure_us;
    frame.taken_with.exposure_us = *exposure_us;
    frame.stamp_utc_ns += std::int64_t{*exposure_us} * 500;  // the stamp is of its start
  }
  if (const auto gain = request->metadata().get(libcamera::controls::AnalogueGain)) {
    gain_ = *gain;
    frame.taken_with.gain = *gain;
  }
  frame.sequence = metadata.sequence;
  const Mapped& mapped = mapped_.at(buffer);
  frame.whole = metadata.status == libcamera::FrameMetadata::FrameSuccess;
  const std::size_t used = metadata.planes().empty() ? 0 : metadata.planes()[0].bytesused;
  frame.raw = {
      mapped.data + mapped.offset, std::min(used, mapped.size - mapped.offset), fourcc_, width_, height_, stride_};
  on_frame_(frame);
  request->reuse(libcamera::Request::ReuseBuffers);
  if (follow_exposure_us_ > 0) {
    request->controls().set(libcamera::controls::AeEnable, false);
    request->controls().set(libcamera::controls::ExposureTime, follow_exposure_us_.load());
    if (follow_gain_ > 0.0F) request->controls().set(libcamera::controls::AnalogueGain, follow_gain_.load());
  }
  if (camera_->queueRequest(request) != 0) lost_ = true;
}

}  // namespace cliquevo::drivers

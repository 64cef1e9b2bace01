// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/v4l2/v4l2_camera.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <ctime>
#include <fcntl.h>
#include <grp.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace cliquevo::drivers {

namespace {

constexpr std::uint32_t kBuffers = 6;
constexpr std::int64_t kYoungNs = 10'000'000'000;  // a node of this age may still be root's alone: udev is about to act

std::int64_t now_ns(clockid_t clock) {
  timespec now = {};
  ::clock_gettime(clock, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

std::string group_of(const std::string& path) {
  struct stat status = {};
  if (::stat(path.c_str(), &status) != 0) return "video";
  const group* entry = ::getgrgid(status.st_gid);
  return entry != nullptr ? entry->gr_name : std::to_string(status.st_gid);
}

bool is_young(const std::string& path) {
  struct stat status = {};
  if (::stat(path.c_str(), &status) != 0) return true;  // gone again
  const std::int64_t changed_ns = std::int64_t{status.st_ctim.tv_sec} * 1'000'000'000 + status.st_ctim.tv_nsec;
  return std::abs(now_ns(CLOCK_REALTIME) - changed_ns) < kYoungNs;
}

Error cannot_open(const std::string& path) {
  if (errno == EACCES || errno == EPERM) {
    const std::string group = group_of(path);
    return {"no permission for camera", path,
            group == "root" ? "it is root's alone: install udev, which gives cameras to the group video"
                            : fmt::format("join the group {0}: adduser USER {0}", group)};
  }
  if (errno == EBUSY) return {"camera is busy", path, "another program holds it: end that one"};
  return {"cannot open camera", path, std::string(std::strerror(errno)) + ": check that it is plugged in"};
}

}  // namespace

int control_device(int descriptor, unsigned long request, void* argument) {
  int result = 0;
  do {
    result = ::ioctl(descriptor, request, argument);
  } while (result < 0 && errno == EINTR);
  return result;
}

OpenTrouble trouble_of(int error_number) {
  switch (error_number) {
    case EBUSY:
      return OpenTrouble::held;
    case ENOENT:
    case ENODEV:
    case ENXIO:
    case EIO:
    case EPIPE:
    case EPROTO:
    case ETIMEDOUT:
    case ESHUTDOWN:
      return OpenTrouble::absent;
    default:
      return OpenTrouble::lasting;
  }
}

std::vector<std::uint32_t> v4l2_formats(int descriptor) {
  std::vector<std::uint32_t> out;
  v4l2_fmtdesc description = {};
  description.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  for (; control_device(descriptor, VIDIOC_ENUM_FMT, &description) == 0; ++description.index) {
    out.push_back(description.pixelformat);
  }
  return out;
}

V4l2Camera::V4l2Camera(V4l2Camera&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      width_(other.width_),
      height_(other.height_),
      stride_(other.stride_),
      fourcc_(other.fourcc_),
      buffers_(std::move(other.buffers_)),
      taken_(other.taken_),
      exposure_ns_(other.exposure_ns_) {
  other.buffers_.clear();
}

V4l2Camera::~V4l2Camera() {
  for (const Mapped& buffer : buffers_) ::munmap(buffer.data, buffer.size);
  if (descriptor_ >= 0) ::close(descriptor_);  // ends the streaming, too
}

Error V4l2Camera::refused(const std::string& what) const {
  trouble_ = trouble_of(errno);
  if (errno == EBUSY) return {"camera is busy", path_, "another program holds it: end that one"};
  return {fmt::format("camera refuses {}", what), path_, std::strerror(errno)};
}

Result<V4l2Camera> V4l2Camera::open(const std::string& path, const CameraOptions& options, bool follows,
                                    OpenTrouble& trouble) {
  trouble = OpenTrouble::lasting;
  V4l2Camera out;
  out.path_ = path;
  out.descriptor_ = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (out.descriptor_ < 0) {
    const int why = errno;
    trouble = trouble_of(why);
    if ((why == EACCES || why == EPERM) && is_young(path)) trouble = OpenTrouble::absent;
    errno = why;
    return cannot_open(path);
  }
  if (auto ok = out.set_up(options, follows); !ok) {
    trouble = out.trouble_;
    return ok.error();
  }
  return out;
}

Result<void> V4l2Camera::set_up(const CameraOptions& options, bool follows) {
  v4l2_capability capability = {};
  if (control_device(descriptor_, VIDIOC_QUERYCAP, &capability) != 0) {
    trouble_ = trouble_of(errno);
    return Error{"no camera", path_, "name a device of Video4Linux (`cliquevo cameras` lists them)"};
  }
  const std::uint32_t can =
      (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps : capability.capabilities;
  if ((can & V4L2_CAP_VIDEO_CAPTURE) == 0 || (can & V4L2_CAP_STREAMING) == 0) {
    return Error{"device captures no video", path_, "name another of its nodes (`cliquevo cameras` lists them)"};
  }
  if (auto ok = choose_format(options); !ok) return ok;
  if (auto ok = set_rate(options.rate_hz); !ok) return ok;
  if (auto ok = set_controls(options, follows); !ok) return ok;
  return map_buffers();
}

Result<void> V4l2Camera::choose_format(const CameraOptions& options) {
  const std::vector<std::uint32_t> offered = v4l2_formats(descriptor_);
  std::vector<std::string> names;
  names.reserve(offered.size());
  for (const std::uint32_t fourcc : offered) names.push_back(fourcc_name(fourcc));
  std::uint32_t wanted = 0;
  if (!options.pixel_format.empty()) {
    const auto named = std::find(names.begin(), names.end(), options.pixel_format);
    if (named != names.end()) wanted = offered[static_cast<std::size_t>(named - names.begin())];
  } else {
    for (const std::uint32_t best : {V4L2_PIX_FMT_GREY, V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_UYVY, V4L2_PIX_FMT_Y10,
                                     V4L2_PIX_FMT_Y12, V4L2_PIX_FMT_Y16, V4L2_PIX_FMT_NV12, V4L2_PIX_FMT_MJPEG}) {
      if (wanted == 0 && std::find(offered.begin(), offered.end(), best) != offered.end()) wanted = best;
    }
    const auto known = std::find_if(offered.begin(), offered.end(), is_known_format);
    if (wanted == 0 && known != offered.end()) wanted = *known;  // rather a mosaic than nothing
  }
  if (wanted == 0 || !is_known_format(wanted)) {
    return Error{
        "pixel format is not offered",
        fmt::format("{}: {}", path_, options.pixel_format.empty() ? "any that is known" : options.pixel_format),
        fmt::format(
            "it offers {}; usable are GREY, Y10 to Y16, Y10P, Y12P, YUYV, UYVY, NV12, YU12, Y8I, MJPG and raw Bayer",
            fmt::join(names, ", "))};
  }
  v4l2_format format = {};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (control_device(descriptor_, VIDIOC_G_FMT, &format) != 0) return refused("to report its format");
  const int images = options.layout == CameraLayout::two_cameras ? 1 : 2;
  const int per_image =
      image_width(options.layout, wanted, images) == images ? 1 : images;  // pixels of the frame for one of an image
  if (options.width > 0) format.fmt.pix.width = static_cast<std::uint32_t>(options.width * per_image);
  if (options.height > 0) format.fmt.pix.height = static_cast<std::uint32_t>(options.height);
  format.fmt.pix.pixelformat = wanted;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  format.fmt.pix.bytesperline = 0;
  if (control_device(descriptor_, VIDIOC_S_FMT, &format) != 0) return refused("the format");
  const v4l2_pix_format& got = format.fmt.pix;
  const bool as_wanted = got.pixelformat == wanted &&
                         (options.width == 0 || got.width == static_cast<std::uint32_t>(options.width * per_image)) &&
                         (options.height == 0 || got.height == static_cast<std::uint32_t>(options.height));
  if (!as_wanted) {
    return Error{"camera refuses the size", path_,
                 fmt::format("it gives {}x{} {}: set width and height to what it can (0 = as it is set)", got.width,
                             got.height, fourcc_name(got.pixelformat))};
  }
  fourcc_ = wanted;
  width_ = static_cast<int>(got.width);
  height_ = static_cast<int>(got.height);
  stride_ = got.bytesperline;
  return {};
}

Result<void> V4l2Camera::set_rate(double rate_hz) const {
  v4l2_streamparm parameters = {};
  parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (control_device(descriptor_, VIDIOC_G_PARM, &parameters) != 0) return {};  // it has one rate
  if ((parameters.parm.capture.capability & V4L2_CAP_TIMEPERFRAME) == 0) return {};
  v4l2_fract& period = parameters.parm.capture.timeperframe;
  period.numerator = 1000;
  period.denominator = static_cast<std::uint32_t>(std::lround(rate_hz * 1000.0));
  if (control_device(descriptor_, VIDIOC_S_PARM, &parameters) != 0) return refused("the frame rate");
  const double got_hz = period.numerator > 0 ? static_cast<double>(period.denominator) / period.numerator : 0.0;
  if (got_hz <= 0.0 || std::abs(got_hz - rate_hz) <= 0.05 * rate_hz) return {};
  return Error{"camera refuses the frame rate", path_,
               fmt::format("it gives {:.3f} Hz where {:.3f} are set: set rate_hz to that", got_hz, rate_hz)};
}

Result<void> V4l2Camera::map_buffers() {
  v4l2_requestbuffers request = {};
  request.count = kBuffers;
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  if (control_device(descriptor_, VIDIOC_REQBUFS, &request) != 0) return refused("buffers");
  for (std::uint32_t i = 0; i < request.count; ++i) {
    v4l2_buffer buffer = {};
    buffer.index = i;
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.memory = V4L2_MEMORY_MMAP;
    if (control_device(descriptor_, VIDIOC_QUERYBUF, &buffer) != 0) return refused("buffers");
    void* data = ::mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor_, buffer.m.offset);
    if (data == MAP_FAILED) return refused("to share its buffers");
    buffers_.push_back({data, buffer.length});
  }
  return {};
}

bool V4l2Camera::give_back(std::uint32_t index) const {
  v4l2_buffer buffer = {};
  buffer.index = index;
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  return control_device(descriptor_, VIDIOC_QBUF, &buffer) == 0;
}

Result<void> V4l2Camera::start() {
  for (std::uint32_t i = 0; i < buffers_.size(); ++i) {
    if (!give_back(i)) return refused("buffers");
  }
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (control_device(descriptor_, VIDIOC_STREAMON, &type) != 0) return refused("to stream");
  return {};
}

// Drivers stamp by the monotonic clock; one that stamps by none at all gets the arrival.
TimestampNs V4l2Camera::stamp_of(std::int64_t driver_ns, std::uint32_t flags, const V4l2Frame& frame) const {
  if ((flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) return frame.arrival_utc_ns;
  const std::int64_t stamp_ns = driver_ns + (frame.arrival_utc_ns - frame.arrival_mono_ns);
  const bool at_start = (flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  return stamp_ns + (at_start ? exposure_ns_ / 2 : -exposure_ns_ / 2);
}

V4l2Taken V4l2Camera::take(int timeout_ms, V4l2Frame& frame) {
  if (taken_) {
    if (!give_back(*taken_)) return V4l2Taken::lost;
    taken_.reset();
  }
  pollfd wait = {descriptor_, POLLIN, 0};
  const int ready = ::poll(&wait, 1, timeout_ms);
  if (ready == 0 || (ready < 0 && errno == EINTR)) return V4l2Taken::nothing;
  if (ready < 0) return V4l2Taken::lost;
  v4l2_buffer buffer = {};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  if (control_device(descriptor_, VIDIOC_DQBUF, &buffer) != 0) {
    return errno == EAGAIN && (wait.revents & (POLLERR | POLLHUP)) == 0 ? V4l2Taken::nothing : V4l2Taken::lost;
  }
  taken_ = buffer.index;
  frame.arrival_mono_ns = now_ns(CLOCK_MONOTONIC);
  frame.arrival_utc_ns = now_ns(CLOCK_REALTIME);
  frame.stamp_utc_ns = stamp_of(std::int64_t{buffer.timestamp.tv_sec} * 1'000'000'000 + buffer.timestamp.tv_usec * 1000,
                                buffer.flags, frame);
  frame.sequence = buffer.sequence;
  frame.raw = {static_cast<const std::uint8_t*>(buffers_[buffer.index].data),
               buffer.bytesused,
               fourcc_,
               width_,
               height_,
               stride_};
  return (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0 ? V4l2Taken::incomplete : V4l2Taken::frame;
}

}  // namespace cliquevo::drivers

// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/aravis/aravis_camera.h"

#include <algorithm>
#include <arpa/inet.h>
#include <cmath>
#include <cstring>
#include <mutex>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "drivers/aravis/stream_guard.h"
#include "drivers/bytes.h"

namespace cliquevo::drivers {

namespace {

constexpr int kBuffers = 16;
constexpr int kSocketBuffer = 8 << 20;
constexpr std::size_t kMostAround = 2;         // a frame with 16 bits a pixel may be padded to so many times its size
constexpr std::size_t kMostExtra = 1U << 20U;  // and bring chunks
constexpr int kPriority = 20;  // of who takes packets: below stereo and odometry, above all that may wait
constexpr double kHopePeriods = 0.5;
constexpr int kNice = -10;                              // where that right is not granted
constexpr std::uint32_t kActionDeviceKey = 0x636c7176;  // "clqv"
constexpr std::uint32_t kActionGroupKey = 1;

// Looking for cameras and opening them is not safe from two threads at once.
std::mutex& library_mutex() {
  static std::mutex mutex;
  return mutex;
}

// The library's name of the camera that is called so: by serial number, address or any other name of it.
std::optional<std::string> find_device(const std::string& name) {
  for (unsigned i = 0; i < arv_get_n_devices(); ++i) {
    for (const char* known : {arv_get_device_serial_nbr(i), arv_get_device_address(i), arv_get_device_id(i),
                              arv_get_device_physical_id(i)}) {
      if (known != nullptr && name == known) return arv_get_device_id(i);
    }
  }
  return std::nullopt;
}

Error unknown_camera(const std::string& name) {
  std::vector<std::string> seen;
  for (unsigned i = 0; i < arv_get_n_devices(); ++i) {
    seen.push_back(fmt::format("{} ({})", arv_get_device_serial_nbr(i), arv_get_device_address(i)));
  }
  return {"no such camera", name,
          seen.empty() ? "none answers: check cable, power and the network's addresses"
                       : fmt::format("there is {}", fmt::join(seen, ", "))};
}

}  // namespace

std::vector<FeatureSetting> trigger_settings(const CameraOptions& options) {
  switch (options.trigger) {
    case CameraTrigger::off:
      return {{"TriggerMode", "Off"}};
    case CameraTrigger::software:
      return {{"TriggerSelector", "FrameStart"}, {"TriggerMode", "On"}, {"TriggerSource", "Software"}};
    case CameraTrigger::hardware:
      return {{"TriggerSelector", "FrameStart"},
              {"TriggerMode", "On"},
              {"TriggerActivation", "RisingEdge"},
              {"TriggerSource", options.trigger_line}};
    case CameraTrigger::action:
      return {{"TriggerSelector", "FrameStart"},
              {"TriggerMode", "On"},
              {"TriggerSource", "Action1"},
              {"ActionDeviceKey", std::to_string(kActionDeviceKey)},
              {"ActionSelector", "1"},
              {"ActionGroupKey", std::to_string(kActionGroupKey)},
              {"ActionGroupMask", std::to_string(kActionGroupKey)}};
  }
  return {};
}

std::vector<std::uint8_t> action_command(std::uint16_t request_id) {
  std::vector<std::uint8_t> out{0x42, 0x00, 0x01, 0x00};  // key, no acknowledge, ACTION_CMD
  put_number(out, std::uint16_t{12});
  put_number(out, request_id);
  put_number(out, kActionDeviceKey);
  put_number(out, kActionGroupKey);
  put_number(out, std::uint32_t{0xffffffff});
  return out;
}

// Frames behind an incomplete one wait as long as it is hoped for; their arrivals must not scatter by that.
StreamRequest stream_request(const CameraOptions& options) {
  const auto hope_us = static_cast<unsigned>(std::clamp(kHopePeriods * 1e6 / options.rate_hz, 3'000.0, 100'000.0));
  return {hope_us / 2, hope_us, options.packet_resend};
}

const char* ptp_feature(bool has_present_name) { return has_present_name ? "PtpEnable" : "GevIEEE1588"; }

void hurry_this_thread() {
  if (arv_make_thread_realtime(kPriority) == 0) arv_make_thread_high_priority(kNice);
}

AravisCamera::AravisCamera(AravisCamera&&) noexcept = default;
AravisCamera::~AravisCamera() {
  if (camera_ && started_ && !lost()) arv_camera_stop_acquisition(camera_.get(), GlibError().out());
  stream_.reset();
  const std::lock_guard<std::mutex> lock(library_mutex());
  camera_.reset();
}

Error AravisCamera::refused(const char* what, const std::string& why) const {
  return {fmt::format("camera refuses {}", what), name_, why};
}

Result<AravisCamera> AravisCamera::open(const std::string& name, const CameraOptions& options, bool follows,
                                        OpenTrouble& trouble) {
  trouble = OpenTrouble::absent;
  AravisCamera out;
  out.name_ = name;
  GlibError error;
  {
    const std::lock_guard<std::mutex> lock(library_mutex());
    arv_update_device_list();
    const std::optional<std::string> id = find_device(name);
    if (!id) return unknown_camera(name);
    out.camera_.reset(arv_camera_new(id->c_str(), error.out()));
    if (!out.camera_) {
      if (error.is(ARV_DEVICE_ERROR, ARV_DEVICE_ERROR_NOT_CONTROLLER)) trouble = OpenTrouble::held;
      return Error{"cannot open camera", name, error.text()};
    }
  }
  ArvDevice* device = arv_camera_get_device(out.camera_.get());
  if (ARV_IS_GV_DEVICE(device) && arv_gv_device_is_controller(ARV_GV_DEVICE(device)) == 0) {
    trouble = OpenTrouble::held;
    return Error{"camera is busy", name, "another program holds it: end that one"};
  }
  g_signal_connect(device, "control-lost", G_CALLBACK(+[](ArvGvDevice*, std::atomic<bool>* lost) { *lost = true; }),
                   out.lost_.get());
  auto set_up = out.set_up(options, follows);
  if (set_up) set_up = out.open_stream(options);
  trouble = OpenTrouble::lasting;
  if (set_up) return out;
  if (out.lost() || !out.answers()) trouble = OpenTrouble::absent;
  return set_up.error();
}

// Whether it is still there and ours: else what it refused means nothing.
bool AravisCamera::answers() {
  GlibError error;
  guint32 ignored = 0;
  ArvDevice* device = arv_camera_get_device(camera_.get());
  if (ARV_IS_GV_DEVICE(device) && arv_gv_device_is_controller(ARV_GV_DEVICE(device)) == 0) return false;
  constexpr guint64 kVersion = 0;  // a register that every GigE Vision and USB3 Vision camera has
  return arv_device_read_register(device, kVersion, &ignored, error.out()) != 0 && !error.failed();
}

Result<void> AravisCamera::choose_format(const std::string& wanted) {
  GlibError error;
  guint count = 0;
  const char** names = arv_camera_dup_available_pixel_formats_as_strings(camera_.get(), &count, error.out());
  const std::vector<std::string> offered(names, names + (names != nullptr ? count : 0));
  g_free(names);
  const std::string format = wanted.empty() ? "Mono8" : wanted;
  arv_camera_set_pixel_format_from_string(camera_.get(), format.c_str(), error.out());
  if (error.failed()) {
    return Error{"pixel format is not offered", fmt::format("{}: {}", name_, format),
                 fmt::format("it offers {}", fmt::join(offered, ", "))};
  }
  samples_ = aravis_samples(arv_camera_get_pixel_format(camera_.get(), error.out()));
  if (samples_.bits != 0) return {};
  return Error{"pixel format is not grey", fmt::format("{}: {}", name_, format),
               "choose Mono8 to Mono16, or Bayer of 8 to 16 bits"};
}

Result<void> AravisCamera::set_up_trigger(const CameraOptions& options) {
  GlibError error;
  ArvDevice* device = arv_camera_get_device(camera_.get());
  for (const FeatureSetting& setting : trigger_settings(options)) {
    const bool needed = setting.feature != "TriggerActivation" && setting.feature != "TriggerSelector" &&
                        options.trigger != CameraTrigger::off;
    if (!needed && !has_feature(camera_.get(), setting.feature.c_str())) continue;
    arv_device_set_features_from_string(device, (setting.feature + "=" + setting.value).c_str(), error.out());
    if (error.failed()) {
      return refused("the trigger", fmt::format("{} = {}: {}", setting.feature, setting.value, error.text()));
    }
  }
  if (options.trigger == CameraTrigger::off && arv_camera_is_frame_rate_available(camera_.get(), error.out()) != 0) {
    arv_camera_set_frame_rate(camera_.get(), options.rate_hz, error.out());
    if (error.failed()) return refused("the frame rate", error.text());
    const double rate_hz = arv_camera_get_frame_rate(camera_.get(), error.out());
    if (std::abs(rate_hz - options.rate_hz) > 0.05 * options.rate_hz) {
      return refused("the frame rate", fmt::format("it gives {:.3f} Hz where {:.3f} are set: set rate_hz to that",
                                                   rate_hz, options.rate_hz));
    }
  }
  return {};
}

Result<void> AravisCamera::set_up(const CameraOptions& options, bool follows) {
  ArvCamera* camera = camera_.get();
  GlibError error;
  arv_camera_stop_acquisition(camera, error.out());  // what a program that died left on
  if (options.binning > 1) {
    arv_camera_set_binning(camera, options.binning, options.binning, error.out());
    if (error.failed()) return refused("the binning", error.text());
  }
  if (auto ok = choose_format(options.pixel_format); !ok) return ok;
  gint x = 0;
  gint y = 0;
  gint width = 0;
  gint height = 0;
  if (options.width > 0 || options.height > 0 || options.offset_x > 0 || options.offset_y > 0) {
    arv_camera_get_region(camera, &x, &y, &width, &height, error.out());
    arv_camera_set_region(camera, options.offset_x, options.offset_y, options.width > 0 ? options.width : width,
                          options.height > 0 ? options.height : height, error.out());
    if (error.failed()) return refused("the region", error.text());
  }
  arv_camera_get_region(camera, &x, &y, &width, &height, error.out());
  if (error.failed() || width < 16 || height < 16) return refused("to report its region", error.text());
  width_ = width;
  height_ = height;
  if ((options.width > 0 && width != options.width) || (options.height > 0 && height != options.height)) {
    return refused("the size", fmt::format("it gives {}x{}: set width and height to that", width, height));
  }
  if (auto ok = set_up_exposure(options, follows); !ok) return ok;
  if (options.ptp) {
    const char* feature = ptp_feature(has_feature(camera, ptp_feature(true)));
    if (!has_feature(camera, feature)) return refused("PTP", "it does not offer it: set ptp to false");
    arv_camera_set_boolean(camera, feature, TRUE, error.out());
    if (error.failed()) return refused("PTP", error.text());
  }
  return set_up_trigger(options);
}

Result<void> AravisCamera::open_stream(const CameraOptions& options) {
  GlibError error;
  if (arv_camera_is_gv_device(camera_.get()) != 0) {
    if (options.packet_size > 0) {
      arv_camera_gv_set_packet_size(camera_.get(), options.packet_size, error.out());
    } else {
      arv_camera_gv_auto_packet_size(camera_.get(), error.out());
    }
    if (error.failed()) return refused("the packet size", error.text());
    // The packet socket, which root would get, hands packets on in blocks of up to 5 ms: late, and of a frame across
    // two blocks the second half counts as lost at high rates.
    arv_camera_gv_set_stream_options(camera_.get(), ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
  }
  const auto on_event = [](void*, ArvStreamCallbackType event, ArvBuffer*) {
    if (event == ARV_STREAM_CALLBACK_TYPE_INIT) hurry_this_thread();
  };
  stream_.reset(arv_camera_create_stream(camera_.get(), on_event, nullptr, error.out()));
  if (!stream_) return refused("to stream", error.text());
  if (ARV_IS_GV_STREAM(stream_.get())) {
    const StreamRequest request = stream_request(options);
    g_object_set(stream_.get(), "frame-retention", request.frame_retention_us, "packet-timeout",
                 request.packet_timeout_us, "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED, "socket-buffer-size",
                 kSocketBuffer, "packet-resend",
                 request.resend ? ARV_GV_STREAM_PACKET_RESEND_ALWAYS : ARV_GV_STREAM_PACKET_RESEND_NEVER, nullptr);
  }
  const auto payload = static_cast<std::size_t>(arv_camera_get_payload(camera_.get(), error.out()));
  if (error.failed()) return refused("to report its frames' size", error.text());
  const std::size_t most = 2 * kMostAround * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  if (payload > most + kMostExtra) {
    return refused("frames of a size that fits its region", fmt::format("it reports {} bytes for {}x{}: set width and "
                                                                        "height",
                                                                        payload, width_, height_));
  }
  if (auto ok = guard(payload); !ok) return ok;
  for (int i = 0; i < kBuffers; ++i) arv_stream_push_buffer(stream_.get(), arv_buffer_new(payload, nullptr));
  return {};
}

// Before any buffer is there for a datagram to fill.
Result<void> AravisCamera::guard(std::size_t payload_bytes) {
  if (!ARV_IS_GV_STREAM(stream_.get())) return {};
  GlibError error;
  ArvDevice* device = arv_camera_get_device(camera_.get());
  auto* address = G_INET_SOCKET_ADDRESS(arv_gv_device_get_device_address(ARV_GV_DEVICE(device)));
  GInetAddress* host = g_inet_socket_address_get_address(address);
  if (g_inet_address_get_family(host) != G_SOCKET_FAMILY_IPV4) return refused("to stream", "its address is not IPv4");
  StreamShape shape;
  std::uint32_t network_order = 0;
  std::memcpy(&network_order, g_inet_address_to_bytes(host), sizeof network_order);
  shape.camera_address = ntohl(network_order);
  shape.payload_bytes = payload_bytes;
  shape.packet_bytes = static_cast<std::size_t>(arv_camera_gv_get_packet_size(camera_.get(), error.out()));
  if (error.failed()) return refused("to report its packets' size", error.text());
  shape.width = static_cast<std::uint32_t>(width_);
  shape.height = static_cast<std::uint32_t>(height_);
  const auto ok = guard_stream(arv_gv_stream_get_port(ARV_GV_STREAM(stream_.get())), stream_filter(shape));
  return ok ? ok : refused("to stream", ok.error().what + ": " + ok.error().remedy);
}

Result<void> AravisCamera::start() {
  GlibError error;
  arv_camera_start_acquisition(camera_.get(), error.out());
  if (error.failed()) return refused("to start", error.text());
  started_ = true;
  return {};
}

void AravisCamera::convert(AravisFrame& frame, const std::uint8_t* data, std::size_t size) {
  if (samples_.is_grey_bytes()) {
    frame.whole = size >= static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
    frame.image = {data, width_, height_, width_};
    return;
  }
  converted_.resize(width_, height_);
  frame.whole = aravis_to_grey(samples_, data, size, converted_.view());
  if (!frame.whole) return;
  if (samples_.mosaic) to_grey_.convert(converted_.view());
  frame.image = converted_.cview();
}

std::optional<AravisFrame> AravisCamera::take(std::uint64_t timeout_us) {
  AravisFrame frame;
  frame.buffer = arv_stream_timeout_pop_buffer(stream_.get(), timeout_us);
  if (frame.buffer == nullptr) return std::nullopt;
  frame.stamp_ns = static_cast<TimestampNs>(arv_buffer_get_timestamp(frame.buffer));
  const bool complete = arv_buffer_get_status(frame.buffer) == ARV_BUFFER_STATUS_SUCCESS &&
                        arv_buffer_get_payload_type(frame.buffer) == ARV_BUFFER_PAYLOAD_TYPE_IMAGE &&
                        arv_buffer_get_image_width(frame.buffer) == width_ &&
                        arv_buffer_get_image_height(frame.buffer) == height_;
  std::size_t size = 0;
  const auto* data =
      complete ? static_cast<const std::uint8_t*>(arv_buffer_get_image_data(frame.buffer, &size)) : nullptr;
  if (data != nullptr) convert(frame, data, size);
  return frame;
}

void AravisCamera::give_back(const AravisFrame& frame) { arv_stream_push_buffer(stream_.get(), frame.buffer); }

void AravisCamera::trigger() { arv_camera_software_trigger(camera_.get(), GlibError().out()); }

}  // namespace cliquevo::drivers

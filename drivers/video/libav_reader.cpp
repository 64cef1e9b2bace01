// SPDX-License-Identifier: BSD-3-Clause
// Video files through libavformat and libavcodec: a module that programs load when they open one.
#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

#include "drivers/images/grey_picture.h"
#include "drivers/video/grey_frame.h"
#include "drivers/video/video_reader.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/log.h>
}

namespace cliquevo::drivers {

namespace {

// Other demuxers open further files and addresses that are named in the one they were given.
constexpr const char* kFormats = "mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,avi";
constexpr const char* kCodecs =
    "h264,hevc,mjpeg,mpeg4,mpeg2video,ffv1,huffyuv,ffvhuff,utvideo,png,rawvideo,vp8,vp9,libdav1d,av1";
constexpr std::size_t kMostFrames = 10'000'000;
constexpr std::int64_t kWorthDecoding = 64;  // frames ahead: nearer than the next key frame, mostly

struct CloseInput {
  void operator()(AVFormatContext* input) const { avformat_close_input(&input); }
};
struct FreeDecoder {
  void operator()(AVCodecContext* decoder) const { avcodec_free_context(&decoder); }
};
struct FreePacket {
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};
struct FreeFrame {
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
};

std::string text_of(int code) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(code, text, sizeof text);
  return text;
}

class LibavReader final : public VideoReader {
 public:
  explicit LibavReader(std::string path) : path_(std::move(path)) {}

  Result<void> open() {
    AVDictionary* options = nullptr;
    av_dict_set(&options, "format_whitelist", kFormats, 0);
    av_dict_set(&options, "protocol_whitelist", "file", 0);
    AVFormatContext* input = nullptr;
    const int opened = avformat_open_input(&input, ("file:" + path_).c_str(), nullptr, &options);
    av_dict_free(&options);
    if (opened < 0) return Error{"cannot open video", path_, text_of(opened) + ": copy it again"};
    input_.reset(input);
    if (const int found = avformat_find_stream_info(input, nullptr); found < 0) {
      return Error{"cannot open video", path_, text_of(found)};
    }
    const AVCodec* codec = nullptr;
    stream_ = av_find_best_stream(input, AVMEDIA_TYPE_VIDEO, -1, -1, &codec, 0);
    if (stream_ < 0 || codec == nullptr) {
      return Error{"video has no pictures that can be decoded", path_, "convert it to H.264 or MJPEG"};
    }
    for (unsigned i = 0; i < input->nb_streams; ++i) {
      if (static_cast<int>(i) != stream_) input->streams[i]->discard = AVDISCARD_ALL;
    }
    packet_.reset(av_packet_alloc());
    frame_.reset(av_frame_alloc());
    if (auto ok = open_decoder(*codec); !ok) return ok;
    return list_frames();
  }

  const VideoInfo& info() const override { return info_; }

  Result<void> read(std::int64_t i, Image<std::uint8_t>& out) override {
    const std::int64_t wanted = stamps_[static_cast<std::size_t>(i)];
    const bool goes_on = i > last_ && i - last_ <= kWorthDecoding;
    if (!goes_on && i != last_) seek(wanted);
    for (int attempt = 0; attempt < 2; ++attempt) {
      const Found found = decode_until(wanted);
      if (found == Found::yes) {
        last_ = i;
        if (frame_->decode_error_flags != 0 || (frame_->flags & AV_FRAME_FLAG_CORRUPT) != 0) return damaged(i);
        if (frame_->width != info_.width || frame_->height != info_.height || !grey_of_frame(*frame_, out)) {
          return Error{"frame has another size or form than the video", name_of(i), "convert it to H.264"};
        }
        return {};
      }
      // Behind the wanted one already: some indexes lead too far.
      if (attempt == 0) seek(std::numeric_limits<std::int64_t>::min());
    }
    last_ = kNowhere;
    return damaged(i);
  }

 private:
  static constexpr std::int64_t kNowhere = std::numeric_limits<std::int64_t>::min() / 2;
  enum class Found { yes, passed, ended };

  std::string name_of(std::int64_t i) const { return path_ + ", frame " + std::to_string(i); }
  Error damaged(std::int64_t i) const { return {"cannot decode frame", name_of(i), "copy the video again"}; }

  Result<void> open_decoder(const AVCodec& codec) {
    const AVCodecParameters& parameters = *input_->streams[stream_]->codecpar;
    info_.width = parameters.width;
    info_.height = parameters.height;
    info_.codec = avcodec_get_name(parameters.codec_id);
    info_.container = input_->iformat->name;
    if (info_.width <= 0 || info_.height <= 0 || info_.width > 2 * kMostSidePx || info_.height > kMostSidePx ||
        std::int64_t{info_.width} * info_.height > 2 * kMostPixels) {
      return Error{"video has an absurd size", path_, "use at most 16384 px a side"};
    }
    decoder_.reset(avcodec_alloc_context3(&codec));
    avcodec_parameters_to_context(decoder_.get(), &parameters);
    decoder_->thread_count = 1;
    decoder_->pkt_timebase = input_->streams[stream_]->time_base;
    AVDictionary* options = nullptr;
    av_dict_set(&options, "codec_whitelist", kCodecs, 0);
    const int opened = avcodec_open2(decoder_.get(), &codec, &options);
    av_dict_free(&options);
    if (opened < 0) return Error{"cannot decode video", path_ + " (" + info_.codec + ")", "convert it to H.264"};
    return {};
  }

  // The frames' stamps, without decoding any.
  Result<void> list_frames() {
    while (av_read_frame(input_.get(), packet_.get()) >= 0) {
      if (packet_->stream_index == stream_ && stamps_.size() < kMostFrames) {
        const std::int64_t stamp = packet_->pts != AV_NOPTS_VALUE ? packet_->pts : packet_->dts;
        if (stamp != AV_NOPTS_VALUE && (packet_->flags & AV_PKT_FLAG_DISCARD) == 0) stamps_.push_back(stamp);
      }
      av_packet_unref(packet_.get());
    }
    std::sort(stamps_.begin(), stamps_.end());
    stamps_.erase(std::unique(stamps_.begin(), stamps_.end()), stamps_.end());
    if (stamps_.empty()) return Error{"video has no frame with a time", path_, "copy it again"};
    for (const std::int64_t stamp : stamps_) {
      info_.stamps_ns.push_back(av_rescale_q(stamp, input_->streams[stream_]->time_base, {1, 1'000'000'000}));
    }
    return {};
  }

  void seek(std::int64_t stamp) {
    const std::int64_t to = std::max(stamp, stamps_.front());
    if (av_seek_frame(input_.get(), stream_, to, AVSEEK_FLAG_BACKWARD) < 0) {
      av_seek_frame(input_.get(), stream_, stamps_.front(), AVSEEK_FLAG_BACKWARD | AVSEEK_FLAG_ANY);
    }
    avcodec_flush_buffers(decoder_.get());
    drained_ = false;
    last_ = kNowhere;
  }

  // The frame of this stamp into frame_.
  Found decode_until(std::int64_t wanted) {
    for (;;) {
      const int got = avcodec_receive_frame(decoder_.get(), frame_.get());
      if (got == 0) {
        const std::int64_t stamp = frame_->best_effort_timestamp;
        if (stamp == wanted) return Found::yes;
        if (stamp != AV_NOPTS_VALUE && stamp > wanted) return Found::passed;
        continue;
      }
      if (got == AVERROR_EOF || drained_) return Found::ended;
      feed();
    }
  }

  // The next packet of the stream, or the end. What the decoder refuses is a frame that will be missing.
  void feed() {
    while (av_read_frame(input_.get(), packet_.get()) >= 0) {
      const bool ours = packet_->stream_index == stream_;
      if (ours) avcodec_send_packet(decoder_.get(), packet_.get());
      av_packet_unref(packet_.get());
      if (ours) return;
    }
    drained_ = avcodec_send_packet(decoder_.get(), nullptr) < 0;
  }

  std::string path_;
  VideoInfo info_;
  std::unique_ptr<AVFormatContext, CloseInput> input_;
  std::unique_ptr<AVCodecContext, FreeDecoder> decoder_;
  std::unique_ptr<AVPacket, FreePacket> packet_;
  std::unique_ptr<AVFrame, FreeFrame> frame_;
  int stream_ = -1;
  std::vector<std::int64_t> stamps_;  // in the stream's unit
  std::int64_t last_ = kNowhere;      // the frame that was read last
  bool drained_ = false;
};

}  // namespace

}  // namespace cliquevo::drivers

extern "C" __attribute__((visibility("default"))) int cliquevo_video_interface() {
  return cliquevo::drivers::kVideoInterface;
}

extern "C" __attribute__((visibility("default"))) void cliquevo_video_open(
    const std::string& path, std::unique_ptr<cliquevo::drivers::VideoReader>& reader, cliquevo::Error& error) {
  av_log_set_level(AV_LOG_QUIET);
  auto opened = std::make_unique<cliquevo::drivers::LibavReader>(path);
  if (auto ok = opened->open(); !ok) {
    error = ok.error();
    return;
  }
  reader = std::move(opened);
}

// SPDX-License-Identifier: BSD-3-Clause
// Bags of ROS 1 and ROS 2 as recordings.
#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "core/base/saturating.h"
#include "drivers/calibration/checks.h"
#include "drivers/images/masks.h"
#include "drivers/images/sample_depth.h"
#include "drivers/recording/bag_images.h"
#include "drivers/recording/bag_topics.h"
#include "drivers/recording/pair_store.h"
#include "drivers/recording/pairing.h"
#include "drivers/recording/times_file.h"

namespace cliquevo::drivers {

namespace {

struct BagPair {
  SetMessage left;
  SetMessage right;
  TimestampNs stamp_ns = 0;  // the left image's
  std::int64_t right_offset_ns = 0;
};

class BagPairs final : public PairStore {
 public:
  BagPairs(BagSet bags, std::vector<BagPair> pairs, std::vector<std::int64_t> numbers)
      : bags_(std::move(bags)), pairs_(std::move(pairs)), numbers_(std::move(numbers)) {}

  std::int64_t size() const override { return static_cast<std::int64_t>(pairs_.size()); }
  std::string name(std::int64_t i) const override {
    const auto at = static_cast<std::size_t>(i);
    return fmt::format("{}, pair {}", bags_.files()[pairs_[at].left.file]->path(), numbers_[at]);
  }
  Result<void> load(std::int64_t i, StereoPair& pair) override {
    const BagPair& from = pairs_[static_cast<std::size_t>(i)];
    if (auto ok = images_.read(bags_, from.left, name(i) + ", left", pair.left); !ok) return ok;
    if (auto ok = images_.read(bags_, from.right, name(i) + ", right", pair.right); !ok) return ok;
    for (const Image<std::uint8_t>* image : {&pair.left, &pair.right}) {
      if (width_ == 0 || image->cview().same_size(width_, height_)) continue;
      return Error{"image has another size than the recording", name(i),
                   fmt::format("it is {}x{}, the others are {}x{}: choose pairs of one size", image->width(),
                               image->height(), width_, height_)};
    }
    pair.right_offset_ns = from.right_offset_ns;
    pair.host_ns = from.left.message.received_ns;
    return {};
  }
  std::int64_t warned() const override { return images_.warned(); }

  // Size of the first pair that can be read; from here on all others must have it.
  Result<std::pair<int, int>> settle_size() {
    std::optional<Error> first_error;
    StereoPair pair;
    for (std::int64_t i = 0; i < size(); ++i) {
      if (auto ok = load(i, pair); !ok) {
        if (!first_error) first_error = ok.error();
        continue;
      }
      if (!pair.right.cview().same_size(pair.left.width(), pair.left.height())) {
        return Error{"cameras have images of unequal size", name(i), "use images of one size"};
      }
      if (pair.left.width() < 16 || pair.left.height() < 16) {
        return Error{"image is too small", name(i), "use images of at least 16 px a side"};
      }
      width_ = pair.left.width();
      height_ = pair.left.height();
      return std::pair{width_, height_};
    }
    return *first_error;
  }

  // How all images are treated: their depth, over some pairs, and whether they say that they are mosaics.
  std::string settle_treatment(Bayer& wanted) {
    constexpr std::int64_t kPairs = 8;
    SampleDepth depth;
    const std::int64_t n = std::min(size(), kPairs);
    bool mosaic = false;
    for (std::int64_t k = 0; k < n; ++k) {
      const BagPair& pair = pairs_[static_cast<std::size_t>(n == 1 ? 0 : k * (size() - 1) / (n - 1))];
      for (const SetMessage& message : {pair.left, pair.right}) {
        const auto picture = images_.read_as_stored(bags_, message, "");
        if (!picture) continue;
        mosaic = mosaic || images_.said_mosaic();
        depth.add(**picture);
      }
      if (k == 0 && !depth.deep()) break;
    }
    std::string said;
    if (depth.deep()) {
      images_.set_shift(depth.shift());
      said += fmt::format(", samples of {} bits, scaled by 1/{}", depth.shift() + 8, 1 << depth.shift());
    }
    if (mosaic && wanted != Bayer::none) {
      images_.set_mosaic(true);
      wanted = Bayer::none;
      said += ", Bayer mosaic by its encoding, made grey";
    }
    return said;
  }

 private:
  BagSet bags_;
  std::vector<BagPair> pairs_;
  std::vector<std::int64_t> numbers_;  // among all pairs of the bag
  BagImages images_;
  int width_ = 0;
  int height_ = 0;
};

// A message with the stamp in its header; where that cannot be read, the time of its arrival: it is next()'s to report.
struct Stamped {
  SetMessage message;
  TimestampNs stamp_ns = 0;
};

// Of both cameras in the order of the file: chunks that hold images of both are opened once.
std::array<std::vector<Stamped>, 2> read_stamps(BagSet& bags, const StereoTopics& topics) {
  std::array<std::vector<Stamped>, 2> out;
  std::vector<std::uint8_t> bytes;
  bool any_stamp = false;
  for (std::size_t file = 0; file < bags.files().size(); ++file) {
    const Bag& bag = *bags.files()[file];
    for (const BagMessage& message : bag.messages()) {
      const std::string& name = bag.topics()[message.topic].name;
      if (name != topics.left && name != topics.right) continue;
      Stamped one{{file, message}, message.received_ns};
      if (bags.read(one.message, bytes, kStampBytes)) {
        const auto stamp = parse_stamp(bytes, bag.topics()[message.topic].serialization);
        if (stamp) one.stamp_ns = std::clamp(*stamp, -kMostStampNs, kMostStampNs);
        any_stamp = any_stamp || (stamp && *stamp != 0);
      }
      out[name == topics.left ? 0 : 1].push_back(one);
    }
  }
  for (std::vector<Stamped>& side : out) {
    for (Stamped& one : side) {
      if (!any_stamp) one.stamp_ns = std::clamp(one.message.message.received_ns, -kMostStampNs, kMostStampNs);
    }
    // In the order of their stamps, those that repeat one left out.
    std::stable_sort(side.begin(), side.end(), [](const auto& a, const auto& b) { return a.stamp_ns < b.stamp_ns; });
    side.erase(
        std::unique(side.begin(), side.end(), [](const auto& a, const auto& b) { return a.stamp_ns == b.stamp_ns; }),
        side.end());
  }
  return out;
}

Result<std::vector<BagPair>> find_pairs(BagSet& bags, const StereoTopics& topics, const RecordingOptions& options,
                                        std::int64_t& unpaired) {
  const std::array<std::vector<Stamped>, 2> sides = read_stamps(bags, topics);
  std::array<std::vector<TimestampNs>, 2> stamps;
  for (std::size_t i = 0; i < 2; ++i) {
    for (const Stamped& one : sides[i]) stamps[i].push_back(one.stamp_ns);
  }
  const std::int64_t tolerance_ns = pair_tolerance_ns(options.pair_tolerance_s, stamps[0]);
  std::vector<BagPair> pairs;
  for (const auto& [l, r] : nearest_pairs(stamps[0], stamps[1], tolerance_ns)) {
    pairs.push_back({sides[0][l].message, sides[1][r].message, stamps[0][l], stamps[1][r] - stamps[0][l]});
  }
  unpaired = static_cast<std::int64_t>(stamps[0].size() + stamps[1].size() - 2 * pairs.size());
  if (!pairs.empty()) return pairs;
  return Error{fmt::format("no image of {} is within {:.6g} s of one of {}", topics.left,
                           static_cast<double>(tolerance_ns) * 1e-9, topics.right),
               options.path, "give a larger --pair-tolerance, or other --topics"};
}

template <typename Numbers>
std::string yaml_list(const Numbers& numbers) {
  std::string out;
  for (const double value : numbers) out += fmt::format("{}{:.17g}", out.empty() ? "" : ", ", value);
  return "[" + out + "]";
}

// As the file that ROS' own tools write of it, which is read with all checks.
std::string as_yaml(const RosCameraInfo& info) {
  std::string out;
  if (info.width > 0 && info.height > 0) out += fmt::format("width: {}\nheight: {}\n", info.width, info.height);
  std::string model;  // of a name that a bag made up, nothing may become syntax
  for (const char c : info.distortion_model) {
    const bool plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
    if (plain) model += c;
  }
  if (!model.empty()) out += fmt::format("distortion_model: {}\n", model);
  return out + fmt::format("K: {}\nD: {}\nR: {}\nP: {}\n", yaml_list(info.K), yaml_list(info.D), yaml_list(info.R),
                           yaml_list(info.P));
}

// The first of the topic that can be read; whether a later one says something else.
struct FoundInfo {
  std::string yaml;
  bool changes = false;
};
std::optional<FoundInfo> find_info(BagSet& bags, const std::string& topic) {
  constexpr std::size_t kTries = 100;
  const std::vector<SetMessage> messages = bags.messages_of(topic);
  std::vector<std::uint8_t> bytes;
  const auto read = [&](const SetMessage& m) {
    std::optional<std::string> yaml;
    if (!bags.read(m, bytes)) return yaml;
    if (const auto info = parse_camera_info(bytes, bags.topic_of(m).serialization)) yaml = as_yaml(*info);
    return yaml;
  };
  for (std::size_t i = 0; i < std::min(kTries, messages.size()); ++i) {
    auto yaml = read(messages[i]);
    if (!yaml) continue;
    const auto last = read(messages.back());
    return FoundInfo{*yaml, last && *last != *yaml};
  }
  return std::nullopt;
}

Result<CalibrationRequest> request_of(BagSet& bags, const StereoTopics& topics, const RecordingOptions& options) {
  CalibrationRequest request;
  request.options = options.calibration_options;
  request.path = options.calibration;
  if (!request.path.empty()) return request;
  if (topics.left_info.empty() || topics.right_info.empty()) {
    return Error{
        "bag has no camera_info of both cameras", options.path,
        "name a calibration with --calibration FILE, or the topics with --topics LEFT,RIGHT,LEFT_INFO,RIGHT_INFO"};
  }
  const auto left = find_info(bags, topics.left_info);
  const auto right = find_info(bags, topics.right_info);
  if (!left || !right) {
    return Error{"cannot read camera_info", options.path + ", " + (left ? topics.right_info : topics.left_info),
                 "name a calibration with --calibration FILE"};
  }
  request.path = options.path + "/left_camera_info.yaml";
  request.texts = {{request.path, left->yaml}, {options.path + "/right_camera_info.yaml", right->yaml}};
  request.options.rectified = request.options.rectified || topics.rectified;
  if (left->changes || right->changes) request.notes.push_back("camera_info changes within the bag: its first is used");
  return request;
}

}  // namespace

Result<std::unique_ptr<FrameSource>> open_bags(const std::vector<std::string>& files, const RecordingOptions& options) {
  auto bags = BagSet::open(files);
  if (!bags) return bags.error();
  const auto topics = choose_topics(*bags, options.topics, options.path);
  if (!topics) return topics.error();
  std::int64_t unpaired = 0;
  auto all = find_pairs(*bags, *topics, options, unpaired);
  if (!all) return all.error();
  const auto chosen = choose_pairs(static_cast<std::int64_t>(all->size()), options);
  if (!chosen) return chosen.error();
  std::vector<BagPair> pairs;
  std::vector<TimestampNs> recorded;
  for (const std::int64_t i : *chosen) {
    const auto number = static_cast<std::size_t>(i);
    pairs.push_back((*all)[number]);
    recorded.push_back(options.rate_hz ? stamp_at(number, *options.rate_hz) : pairs.back().stamp_ns);
  }
  auto stamps = make_rising(recorded, options.path);
  if (!stamps) return stamps.error();
  auto request = options.needs_calibration ? request_of(*bags, *topics, options)
                                           : Result<CalibrationRequest>(CalibrationRequest{});
  if (!request) return request.error();

  SourceInfo info;
  info.description = fmt::format("{} ({}, {})", bags->describe(options.path), topics->left, topics->right);
  if (unpaired > 0) info.description += fmt::format(" ({} images without a partner)", unpaired);
  info.frame_count = options.pingpong ? -1 : static_cast<std::int64_t>(pairs.size());
  info.rate_hz = rate_of(*stamps);
  auto store = std::make_unique<BagPairs>(std::move(*bags), std::move(pairs), *chosen);
  RecordingOptions playing = options;
  info.description += store->settle_treatment(playing.bayer);
  const auto size = store->settle_size();
  if (!size) return size.error();
  std::tie(info.width, info.height) = *size;
  std::tie(request->width, request->height) = *size;
  if (options.needs_calibration) {
    auto calibration = calibrate(*request, *store);
    if (!calibration) return calibration.error();
    info.calibration = std::move(*calibration);
  }
  if (auto ok = read_masks(options.left_mask, options.right_mask, "", info); !ok) return ok.error();
  return play_pairs(std::move(store), {topics->left, topics->right}, std::move(*stamps), std::move(info), playing);
}

}  // namespace cliquevo::drivers

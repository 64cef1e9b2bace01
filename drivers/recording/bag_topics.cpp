// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/bag_topics.h"

#include <algorithm>
#include <array>
#include <map>
#include <tuple>

#include <fmt/format.h>

#include "drivers/bags/ros_messages.h"
#include "drivers/recording/side_words.h"

namespace cliquevo::drivers {

namespace {

bool is_image(const SetTopic& t) {
  static constexpr std::array kNoPictures{"depth", "disparity", "mask", "label", "confidence", "semantic", "theora"};
  const bool of_type = t.topic.type == kImageType || t.topic.type == kCompressedImageType;
  return of_type && t.count > 0 && t.topic.serialization != Serialization::other &&
         std::none_of(kNoPictures.begin(), kNoPictures.end(), [&](const char* word) {
           std::string low = t.topic.name;
           for (char& c : low) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
           return low.find(word) != std::string::npos;
         });
}

// "/stereo/left/image_raw/compressed" -> "/stereo/left/image_raw"
std::string without_transport(const std::string& name) {
  return name.ends_with("/compressed") ? name.substr(0, name.rfind('/')) : name;
}

std::string camera_of(const std::string& image_topic) {
  const std::string image = without_transport(image_topic);
  const std::size_t slash = image.rfind('/');
  return slash == std::string::npos ? std::string() : image.substr(0, slash);
}

// By the last part of the name: image_rect, image_rect_raw, rectified.
bool is_rectified(const std::string& image_topic) {
  const std::string image = without_transport(image_topic);
  const std::string last = image.substr(image.rfind('/') + 1);
  for (std::size_t at = last.find("rect"); at != std::string::npos; at = last.find("rect", at + 1)) {
    const bool begins = at == 0 || last[at - 1] == '_';
    const std::string rest = last.substr(at + 4);
    if (begins && (rest.empty() || rest[0] == '_' || rest.starts_with("ified"))) return true;
  }
  return false;
}

struct Candidate {
  int kind = 0;  // how their names differ for left and right
  const SetTopic* left = nullptr;
  const SetTopic* right = nullptr;

  // Best first.
  auto rank() const {
    const std::string& name = left->topic.name;
    return std::tuple(kind, !is_rectified(name), left->topic.type == kCompressedImageType, name.size(), name);
  }
};

std::vector<Candidate> find_candidates(const BagSet& bags) {
  std::vector<const SetTopic*> images;
  for (const SetTopic& topic : bags.topics()) {
    if (is_image(topic)) images.push_back(&topic);
  }
  std::vector<Candidate> out;
  for (const SetTopic* left : images) {
    for (const SetTopic* right : images) {
      if (left->topic.type != right->topic.type) continue;
      const auto kind = pair_kind(left->topic.name, right->topic.name);
      if (kind) out.push_back({*kind, left, right});
    }
  }
  std::sort(out.begin(), out.end(), [](const Candidate& a, const Candidate& b) { return a.rank() < b.rank(); });
  return out;
}

std::string list_topics(const BagSet& bags) {
  constexpr std::size_t kMost = 12;
  std::string out;
  std::size_t listed = 0;
  for (const SetTopic& t : bags.topics()) {
    if (++listed > kMost) return out + fmt::format(", and {} more", bags.topics().size() - kMost);
    out += fmt::format("{}{} ({}, {})", out.empty() ? "" : ", ", t.topic.name,
                       t.topic.type.empty() ? "no type" : t.topic.type, t.count);
  }
  return out;
}

// camera_info beside the images, else the only pair of such topics.
void find_infos(const BagSet& bags, StereoTopics& topics) {
  const auto is_info = [&](const SetTopic* t) {
    return t != nullptr && t->topic.type == kCameraInfoType && t->count > 0;
  };
  const auto beside = [&](const std::string& image) {
    const SetTopic* found = bags.find(camera_of(image) + "/camera_info");
    return is_info(found) ? found->topic.name : std::string();
  };
  topics.left_info = beside(topics.left);
  topics.right_info = beside(topics.right);
  if (!topics.left_info.empty() && !topics.right_info.empty()) return;
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const SetTopic& left : bags.topics()) {
    for (const SetTopic& right : bags.topics()) {
      if (is_info(&left) && is_info(&right) && pair_kind(left.topic.name, right.topic.name)) {
        pairs.emplace_back(left.topic.name, right.topic.name);
      }
    }
  }
  if (pairs.size() == 1) std::tie(topics.left_info, topics.right_info) = pairs.front();
}

Result<StereoTopics> topics_named(const BagSet& bags, const std::string& wanted, const std::string& path) {
  std::vector<std::string> names{""};
  for (const char c : wanted) {
    if (c == ',') {
      names.emplace_back();
    } else if (c != ' ') {
      names.back() += c;
    }
  }
  if (names.size() != 2 && names.size() != 4) {
    return Error{"topics are neither two nor four", wanted, "give LEFT,RIGHT or LEFT,RIGHT,LEFT_INFO,RIGHT_INFO"};
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    const SetTopic* found = bags.find(names[i]);
    if (found == nullptr || found->count == 0) {
      return Error{"bag has no such topic", path + ", " + names[i], "choose from " + list_topics(bags)};
    }
    const std::string& type = found->topic.type;
    const bool fits = i < 2 ? type == kImageType || type == kCompressedImageType : type == kCameraInfoType;
    if (fits && found->topic.serialization != Serialization::other) continue;
    return Error{
        fmt::format("topic is of type {}", type), path + ", " + names[i],
        i < 2 ? "name topics of sensor_msgs Image or CompressedImage" : "name topics of sensor_msgs CameraInfo"};
  }
  StereoTopics out;
  out.left = names[0];
  out.right = names[1];
  out.rectified = is_rectified(out.left) && is_rectified(out.right);
  if (names.size() == 4) {
    out.left_info = names[2];
    out.right_info = names[3];
  } else {
    find_infos(bags, out);
  }
  return out;
}

}  // namespace

Result<StereoTopics> choose_topics(const BagSet& bags, const std::string& wanted, const std::string& path) {
  if (!wanted.empty()) return topics_named(bags, wanted, path);
  const std::vector<Candidate> candidates = find_candidates(bags);
  if (candidates.empty()) {
    return Error{"bag has no two image topics that are left and right by their names", path,
                 "name them with --topics LEFT,RIGHT; it has " + list_topics(bags)};
  }
  const Candidate& best = candidates.front();
  // Another rig whose names are as clear: it is unknown which is meant.
  std::map<std::string, const Candidate*> rigs;
  for (const Candidate& c : candidates) {
    if (c.kind == best.kind) rigs.emplace(camera_of(c.left->topic.name), &c);
  }
  if (rigs.size() > 1) {
    std::string names;
    for (const auto& [camera, c] : rigs) {
      names += fmt::format("{}{},{}", names.empty() ? "" : "; ", c->left->topic.name, c->right->topic.name);
    }
    return Error{"bag holds several stereo pairs", path, "choose one with --topics: " + names};
  }
  StereoTopics out;
  out.left = best.left->topic.name;
  out.right = best.right->topic.name;
  out.rectified = is_rectified(out.left);
  find_infos(bags, out);
  return out;
}

}  // namespace cliquevo::drivers

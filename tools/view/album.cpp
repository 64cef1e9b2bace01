// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view/album.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "tools/view/base64.h"
#include "tools/view/page_files.h"

namespace cliquevo::view {

namespace {

constexpr std::size_t kMostWorst = 10;
constexpr std::int64_t kApart = 8;  // frames: of two bad ones so near, the worse is shown
constexpr std::size_t kMostSmall = 240;
constexpr int kSmallWidth = 192;
constexpr int kSmallQuality = 55;
constexpr int kQuality = 75;

double badness_of(const FrameFacts& f) {
  if (f.status == static_cast<int>(vo::Status::no_data)) return 0.0;
  const double scatter = f.expected_error_px > 0.0 ? f.error_px / f.expected_error_px : f.error_px;
  if (f.status == static_cast<int>(vo::Status::valid)) return 100.0 - f.quality + std::min(scatter, 50.0);
  double most = 0.0;
  for (const CheckFact& check : f.checks) most = std::max(most, check.ratio);
  return 1000.0 + std::min(most, 100.0);
}

void replace(std::string& text, std::string_view what, std::string_view by) {
  const std::size_t at = text.find(what);
  if (at != std::string::npos) text.replace(at, what.size(), by);
}

std::span<const unsigned char> bytes_of(std::string_view text) {
  return {reinterpret_cast<const unsigned char*>(text.data()), text.size()};
}

// "./colours.js" becomes a name that the import map knows: a module from a data: address has no folder.
std::string with_bare_names(std::string_view source) {
  std::string out(source);
  constexpr std::string_view kFrom = "from \"./";
  constexpr std::string_view kBare = "from \"cliquevo/";
  for (std::size_t at = out.find(kFrom); at != std::string::npos; at = out.find(kFrom, at + kBare.size())) {
    out.replace(at, kFrom.size(), kBare);
  }
  return out;
}

std::string import_map() {
  constexpr std::string_view kModules[] = {"/colours.js", "/fleet.js",  "/frame.js", "/map.js", "/picture.js",
                                           "/record.js",  "/report.js", "/when.js",  "/why.js", "/vendor/uPlot.esm.js"};
  std::string out = "{\"imports\":{";
  for (const std::string_view name : kModules) {
    const PageFile* file = find_page_file(name);
    if (file == nullptr) continue;
    if (out.back() != '{') out += ',';
    out += fmt::format("\"cliquevo{}\":\"data:text/javascript;base64,{}\"", name,
                       base64(bytes_of(with_bare_names(file->content))));
  }
  return out + "}}";
}

}  // namespace

void Album::add(const daemon::FramePipeline& pipeline, const drivers::StereoPair& pair) {
  const FrameFacts facts = facts_.make(pipeline, pair);
  const auto number = static_cast<std::int64_t>(records_.size());
  records_.push_back(to_json(facts, number));
  keep_small(pipeline, number);
  keep_if_bad(pipeline, facts, number);
}

void Album::keep_small(const daemon::FramePipeline& pipeline, std::int64_t number) {
  if (number % every_ != 0) return;
  if (small_.size() >= kMostSmall) {
    every_ *= 2;
    std::erase_if(small_, [this](const Kept& k) { return k.number % every_ != 0; });
    if (number % every_ != 0) return;
  }
  const Image<std::uint8_t> picture = shrunk(pipeline.rectified_left(), kSmallWidth);
  small_.push_back({number, 0.0, jpeg_.encode(picture.cview(), kSmallQuality), {}});
}

void Album::keep_if_bad(const daemon::FramePipeline& pipeline, const FrameFacts& facts, std::int64_t number) {
  const double badness = badness_of(facts);
  if (badness <= 0.0) return;
  const auto better = [](const Kept& a, const Kept& b) { return a.badness < b.badness; };
  const auto near =
      std::find_if(worst_.begin(), worst_.end(), [number](const Kept& k) { return number - k.number < kApart; });
  auto place = near;
  if (near == worst_.end() && worst_.size() >= kMostWorst) {
    place = std::min_element(worst_.begin(), worst_.end(), better);
  }
  if (place != worst_.end() && place->badness >= badness) return;
  Kept kept{number, badness, jpeg_.encode(pipeline.rectified_left(), kQuality), pack_features(facts_.features())};
  if (place == worst_.end()) {
    worst_.push_back(std::move(kept));
  } else {
    *place = std::move(kept);
  }
}

std::string Album::records() const {
  std::string out = "[";
  for (const std::string& record : records_) {
    if (out.size() > 1) out += ',';
    out += record;
  }
  return out + "]";
}

std::string Album::thumbnails() const {
  std::string out = "[";
  for (const Kept& k : small_) {
    if (out.size() > 1) out += ',';
    out += fmt::format("{{\"n\":{},\"jpeg\":\"{}\"}}", k.number, base64(k.jpeg));
  }
  return out + "]";
}

std::string Album::worst() const {
  std::vector<const Kept*> sorted;
  for (const Kept& k : worst_) sorted.push_back(&k);
  std::sort(sorted.begin(), sorted.end(), [](const Kept* a, const Kept* b) {
    return a->badness != b->badness ? a->badness > b->badness : a->number < b->number;
  });
  std::string out = "[";
  for (const Kept* k : sorted) {
    if (out.size() > 1) out += ',';
    out += fmt::format("{{\"n\":{},\"jpeg\":\"{}\",\"features\":\"{}\"}}", k->number, base64(k->jpeg),
                       base64(k->features));
  }
  return out + "]";
}

std::string report_page(const std::string& data_json) {
  std::string data = data_json;
  // Nothing in it may end the script that it stands in.
  for (std::size_t at = data.find("</"); at != std::string::npos; at = data.find("</", at + 3))
    data.insert(at + 1, 1, '\\');
  for (std::size_t at = data.find("<!--"); at != std::string::npos; at = data.find("<!--", at)) data[at] = ' ';
  std::string out(find_page_file("/report.html")->content);
  replace(out, "/*STYLE*/",
          std::string(find_page_file("/vendor/uPlot.min.css")->content) +
              std::string(find_page_file("/style.css")->content));
  replace(out, "/*IMPORTS*/", import_map());
  replace(out, "/*DATA*/", data);
  return out;
}

}  // namespace cliquevo::view

// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/capture_page.h"

#include <chrono>

#include <nlohmann/json.hpp>

#include "core/vo/seen_feature.h"
#include "tools/view/store.h"

namespace cliquevo::tools {

namespace {

using calibration::Side;
using nlohmann::json;

constexpr int kJpegQuality = 85;
constexpr std::int64_t kStoreBytes = std::int64_t{64} << 20;
constexpr std::size_t kStoredPairs = 60;
constexpr auto kLinger = std::chrono::milliseconds(500);
constexpr int kMostLingers = 40;

std::string text_of(const json& value) { return value.dump(-1, ' ', false, json::error_handler_t::replace); }

// The corners of both images, as features: the role is the side.
view::Bytes packed_corners(const calibration::View& seen) {
  std::vector<vo::SeenFeature> out;
  for (const Side side : {Side::left, Side::right}) {
    for (const calibration::SeenCorner& c : seen.of(side)) {
      vo::SeenFeature feature;
      feature.x_px = static_cast<float>(c.px.x());
      feature.y_px = static_cast<float>(c.px.y());
      feature.role = static_cast<vo::FeatureRole>(side);
      out.push_back(feature);
    }
  }
  return view::pack_features(out);
}

const char* refusal_name(Refusal refusal) {
  static constexpr std::array<const char*, 6> kNames{"taken", "no board", "moving", "skewed", "blurred", "alike"};
  return kNames[static_cast<std::size_t>(refusal)];
}

json cells_of(const Guide& guide, Side side) {
  json out = json::array();
  for (const bool cell : guide.cells(side)) out.push_back(cell ? 1 : 0);
  return out;
}

}  // namespace

Result<std::unique_ptr<CapturePage>> CapturePage::open(const view::ServerOptions& options, const std::string& source,
                                                       const std::string& version) {
  std::unique_ptr<CapturePage> page(new CapturePage);
  auto store = view::Store::make(kStoreBytes, kStoredPairs);
  if (!store) return store.error();
  page->store_ = std::move(*store);
  view::PageContent content;
  CapturePage* self = page.get();
  content.hello = [self, source, version] {
    self->greeted_ = true;
    return text_of({{"op", "hello"}, {"source", source}, {"version", version}, {"across", kCellsAcross}});
  };
  content.state = [self] { return self->state(); };
  content.mask = [] { return nullptr; };
  content.metrics = [] { return std::string(); };
  content.command = [self](view::PageCommand::What what) {
    if (what == view::PageCommand::What::take_view) self->take_ = true;
    if (what == view::PageCommand::What::drop_view) self->drop_ = true;
    if (what == view::PageCommand::What::finish) self->finish_ = true;
  };
  auto server = view::Server::open(options, *page->store_, page->topics_, std::move(content));
  if (!server) return server.error();
  page->server_ = std::move(*server);
  page->thread_ = std::thread([self] { self->server_->run([self] { return self->ending_.load(); }); });
  return page;
}

CapturePage::~CapturePage() {
  ending_ = true;
  if (thread_.joinable()) thread_.join();
}

std::string CapturePage::address() const {
  std::string out = server_->address();
  const std::size_t question = std::min(out.find('?'), out.size());
  return out.insert(question, "calibrate.html");
}

std::string CapturePage::state() const {
  const std::lock_guard lock(mutex_);
  if (phase_ == "done" || phase_ == "failed") last_sent_ = true;
  std::string out = text_of({{"op", "state"}, {"phase", phase_}, {"text", text_}});
  if (!looked_.empty()) out.insert(out.size() - 1, "," + looked_);
  return out;
}

void CapturePage::show(const drivers::StereoPair& pair, const Look& look, Refusal refusal, const Guide& guide) {
  view::FrameFacts facts;
  facts.index = pair.index;
  facts.stamp_us = pair.stamp_ns / 1000;
  view::FrameParts parts;
  parts.features = packed_corners(look.view);
  parts.left = jpeg_.encode(pair.left.cview(), kJpegQuality);
  parts.right = jpeg_.encode(pair.right.cview(), kJpegQuality);
  store_->add(facts, parts);
  json bars = json::array();
  for (const Bar& bar : guide.bars()) bars.push_back({{"name", bar.name}, {"share", bar.share}});
  const std::string members = text_of({{"pair", pair.index},
                                       {"views", guide.views().size()},
                                       {"refusal", refusal_name(refusal)},
                                       {"advice", guide.advice(look, refusal)},
                                       {"estimate", guide.estimate()},
                                       {"bars", bars},
                                       {"edge_px", std::max(look.edge_px[0], look.edge_px[1])},
                                       {"speed_px_s", look.speed_px_s ? json(*look.speed_px_s) : json(nullptr)},
                                       {"skew_ms", 1e3 * look.skew_s},
                                       {"left", cells_of(guide, Side::left)},
                                       {"right", cells_of(guide, Side::right)},
                                       {"size", {pair.left.width(), pair.left.height()}}});
  const std::lock_guard lock(mutex_);
  looked_ = members.substr(1, members.size() - 2);
  if (refusal == Refusal::none && phase_ == "looking") text_.clear();  // what was missing may be there now
}

void CapturePage::set_phase(const std::string& phase, const std::string& text) {
  const std::lock_guard lock(mutex_);
  phase_ = phase;
  text_ = text;
}

void CapturePage::linger() const {
  for (int i = 0; greeted_ && !last_sent_ && i < kMostLingers; ++i) std::this_thread::sleep_for(kLinger);
  if (last_sent_) std::this_thread::sleep_for(kLinger);  // it is on its way
}

}  // namespace cliquevo::tools

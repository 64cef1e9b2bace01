// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/live/shared_clock.h"

#include <algorithm>
#include <cmath>

namespace cliquevo::drivers {

namespace {

// Arrivals scatter by +-0.4 periods: frames of different exposures, whole periods apart, are never nearer than this.
constexpr double kTogether = 0.2;
constexpr std::size_t kMostUnnumbered = 4;
// Frames of one stamp that came together speak for a shared clock, those that came apart against it, and more so.
constexpr int kTrustGain = 1;
constexpr int kTrustLoss = 2;
constexpr int kMostTrust = 4;
constexpr int kLeastTrust = -8;

}  // namespace

SharedClock::SharedClock(const PairSyncOptions& options)
    : shared_(options.shared_clock),
      tolerance_ns_(options.tolerance * (1e9 / options.rate_hz)),
      together_ns_(kTogether * (1e9 / options.rate_hz)) {
  for (auto& list : unnumbered_) list.reserve(kMostUnnumbered + 1);
}

const WaitingFrame* SharedClock::partner_of(CameraSide camera, const WaitingFrame& frame,
                                            const NumberedGrid& grid) const {
  const auto is_partner = [&](const WaitingFrame& w) {
    return std::abs(static_cast<double>(w.stamp_ns) - static_cast<double>(frame.stamp_ns)) <= tolerance_ns_;
  };
  const CameraSide theirs = other(camera);
  const WaitingFrame* found = nullptr;
  for (const std::vector<WaitingFrame>* list :
       {&grid.waiting(theirs), &unnumbered_[static_cast<std::size_t>(theirs)]}) {
    const auto w = std::find_if(list->begin(), list->end(), is_partner);
    if (w != list->end()) found = &*w;
  }
  return found;
}

// A clock that is shared by name alone brings frames of one stamp whole periods apart, every time: pairing by stamp is
// then closed, and the clocks must have been learnt. A stalled host brings them apart now and then.
bool SharedClock::trusts(const WaitingFrame& frame, const WaitingFrame& partner) {
  if (std::abs(static_cast<double>(partner.arrival_ns - frame.arrival_ns)) > together_ns_) {
    trust_ = std::max(trust_ - kTrustLoss, kLeastTrust);
    return false;
  }
  trust_ = std::min(trust_ + kTrustGain, kMostTrust);
  return trust_ >= 0;
}

bool SharedClock::pair(CameraSide camera, const WaitingFrame& frame, NumberedGrid& grid, SyncBooks& books) {
  if (!shared_) return false;
  const WaitingFrame* found = partner_of(camera, frame, grid);
  if (found == nullptr || !trusts(frame, *found)) return false;
  const WaitingFrame partner = *found;
  const WaitingFrame& left = camera == CameraSide::left ? frame : partner;
  const WaitingFrame& right = camera == CameraSide::left ? partner : frame;
  if (!books.is_after_last(left.stamp_ns)) return false;
  take_out(CameraSide::left, left, grid, books);
  take_out(CameraSide::right, right, grid, books);
  books.pair(left, right, right.stamp_ns - left.stamp_ns);
  return true;
}

// Removes a frame that is paired, and hands back the older ones of its camera.
void SharedClock::take_out(CameraSide camera, const WaitingFrame& frame, NumberedGrid& grid, SyncBooks& books) {
  if (frame.numbered) grid.take_out(camera, frame, books);
  const auto gone = [&](const WaitingFrame& w) {
    if (w.token == frame.token) return true;
    if (w.stamp_ns > frame.stamp_ns) return false;
    books.release(camera, w, SyncLoss::uncertain);
    return true;
  };
  std::vector<WaitingFrame>& list = unnumbered_[static_cast<std::size_t>(camera)];
  list.erase(std::remove_if(list.begin(), list.end(), gone), list.end());
}

void SharedClock::keep(CameraSide camera, const WaitingFrame& frame, SyncBooks& books) {
  if (!shared_ || !books.is_after_last(frame.stamp_ns)) {
    books.release(camera, frame, SyncLoss::uncertain);
    return;
  }
  std::vector<WaitingFrame>& list = unnumbered_[static_cast<std::size_t>(camera)];
  if (list.size() == kMostUnnumbered) {
    books.release(camera, list.front(), SyncLoss::uncertain);
    list.erase(list.begin());
  }
  list.push_back(frame);
}

void SharedClock::release_all(SyncBooks& books) {
  for (const CameraSide camera : {CameraSide::left, CameraSide::right}) {
    std::vector<WaitingFrame>& list = unnumbered_[static_cast<std::size_t>(camera)];
    for (const WaitingFrame& frame : list) books.release(camera, frame, SyncLoss::uncertain);
    list.clear();
  }
}

}  // namespace cliquevo::drivers

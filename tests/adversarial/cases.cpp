// SPDX-License-Identifier: BSD-3-Clause
#include "tests/adversarial/cases.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>

#include "drivers/simulator.h"

namespace cliquevo::test {

namespace {

constexpr const char* kCamera = "width=256,height=192,focal_px=280";
constexpr const char* kNames[] = {"plain",   "blank", "noise",    "frozen", "swapped", "gap",   "calibration",
                                  "covered", "mover", "rotation", "flare",  "night",   "water", "blur"};

using Rng = std::mt19937_64;

// The standard library's distributions differ between implementations; these do not.
double uniform(Rng& rng, double low, double high) {
  return low + (high - low) * static_cast<double>(rng() >> 11) * 0x1.0p-53;
}
int whole(Rng& rng, int low, int high) {
  return low + static_cast<int>(rng() % static_cast<std::uint64_t>(high - low + 1));
}
double normal(Rng& rng) {  // of twelve uniform ones
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += uniform(rng, 0.0, 1.0);
  return sum;
}

template <typename F>
void each_pixel(Image<std::uint8_t>& image, F&& f) {
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      std::uint8_t& p = image.view()(x, y);
      p = static_cast<std::uint8_t>(std::clamp(f(x, y, static_cast<double>(p)) + 0.5, 0.0, 255.0));
    }
  }
}

void blur(Image<std::uint8_t>& image, int radius) {
  for (int pass = 0; pass < 2; ++pass) {
    Image<std::uint8_t> from;
    from.copy_from(image.cview());
    const bool across = pass == 0;
    each_pixel(image, [&](int x, int y, double) {
      double sum = 0.0;
      for (int i = -radius; i <= radius; ++i) {
        sum += across ? from.cview()(std::clamp(x + i, 0, image.width() - 1), y)
                      : from.cview()(x, std::clamp(y + i, 0, image.height() - 1));
      }
      return sum / (2 * radius + 1);
    });
  }
}

// Images are copied only on purpose.
drivers::StereoPair copy_of(const drivers::StereoPair& pair) {
  drivers::StereoPair out;
  out.index = pair.index;
  out.stamp_ns = pair.stamp_ns;
  out.left.copy_from(pair.left.cview());
  out.right.copy_from(pair.right.cview());
  out.truth_T_world_camera = pair.truth_T_world_camera;
  return out;
}

drivers::SourceInfo copy_of(const drivers::SourceInfo& info) {
  drivers::SourceInfo out;
  out.description = info.description;
  out.width = info.width;
  out.height = info.height;
  out.rate_hz = info.rate_hz;
  out.calibration = info.calibration;
  return out;
}

}  // namespace

const char* kind_name(Kind kind) { return kNames[static_cast<int>(kind)]; }

CaseMaker::CaseMaker() = default;

const CaseMaker::Course& CaseMaker::course(const std::string& text) {
  const auto known = courses_.find(text);
  if (known != courses_.end()) return known->second;
  const auto options = drivers::parse_simulator_options(fmt::format("{},{}", kCamera, text));
  if (!options) {
    std::fprintf(stderr, "%s\n", options.error().line().c_str());
    std::abort();
  }
  auto simulator = drivers::open_simulator(*options);
  if (!simulator) {
    std::fprintf(stderr, "%s\n", simulator.error().line().c_str());
    std::abort();
  }
  Course out;
  out.info = copy_of((*simulator)->info());
  drivers::StereoPair pair;
  for (;;) {
    const auto more = (*simulator)->next(pair);
    if (!more || !*more) break;
    out.pairs.push_back(copy_of(pair));
  }
  return courses_.emplace(text, std::move(out)).first->second;
}

Case CaseMaker::make(std::uint64_t k) {
  Case out;
  Rng rng(0x9e3779b97f4a7c15ULL * (k + 1));
  rng.discard(8);
  out.kind = kind_of(k);
  int frames = 7;
  int stride = whole(rng, 1, 2);
  std::string source = fmt::format("course={},frames=240,world_seed={}", whole(rng, 0, 2) == 0 ? "walking" : "wheeled",
                                   whole(rng, 1, 2));
  switch (out.kind) {
    case Kind::calibration: {
      const int axis = whole(rng, 0, 2);
      const int sign = whole(rng, 0, 1) == 0 ? -1 : 1;
      source = fmt::format("frames=90,misalign_right_deg={}:{}:{}", axis == 0 ? sign : 0, axis == 1 ? sign : 0,
                           axis == 2 ? sign : 0);
      frames = 60;
      stride = 1;
      break;
    }
    case Kind::mover:
      source = fmt::format("scene=lorry,frames=150,world_seed={}", whole(rng, 1, 2));
      break;
    case Kind::water:
      source = fmt::format("scene=water,frames=100,world_seed={}", whole(rng, 1, 2));
      break;
    case Kind::rotation:
      source = fmt::format("course=turn,frames=150,world_seed={}", whole(rng, 1, 2));
      break;
    default:
      break;
  }
  // Drawn only where it is used: what cases of the first family draw stays as it is.
  if (k >= kRough && whole(rng, 0, 1) == 1) {
    static constexpr const char* kRoughCameras[] = {"webcam", "flexing", "vibrating", "action", "sun"};
    source += fmt::format(",camera={}", kRoughCameras[whole(rng, 0, 4)]);
  }
  const Course& from = course(source);
  const int span = (frames - 1) * stride;
  const int first = whole(rng, 0, static_cast<int>(from.pairs.size()) - 1 - span - (out.kind == Kind::gap ? 62 : 0));
  // Driven backwards; not with a rolling shutter, whose rows would come from below.
  const bool back = whole(rng, 0, 1) == 1 && !(from.info.calibration.readout_s > 0.0);
  out.text = fmt::format("{}: {} from {} every {}{}", k, source, first, stride, back ? " backwards" : "");
  out.info = copy_of(from.info);
  for (int i = 0; i < frames; ++i) {
    int at = first + (back ? frames - 1 - i : i) * stride;
    if (out.kind == Kind::gap && (back ? i < frames / 2 : i >= frames / 2)) at += 60;
    out.pairs.push_back(copy_of(from.pairs[static_cast<std::size_t>(at)]));
    out.pairs.back().index = i;
    out.pairs.back().stamp_ns = 1'000'000'000 + i * stride * 33'333'333LL;
  }
  out.solvable.assign(out.pairs.size(), true);
  out.solvable[0] = false;

  const double more_noise = uniform(rng, 0.0, 2.0);
  const double gain = uniform(rng, 0.6, 1.2);
  const int spoilt_first = 2;
  const int spoilt_end = whole(rng, 0, 1) == 0 ? 4 : frames;  // for two frames, or to the end
  const auto spoilt = [&](std::size_t i) {
    return static_cast<int>(i) >= spoilt_first && static_cast<int>(i) < spoilt_end;
  };
  const int cover_side = whole(rng, 0, 3);
  const double glow_x = uniform(rng, 0.2, 0.8), glow_y = uniform(rng, 0.0, 0.4), strength = uniform(rng, 60.0, 220.0);
  const double light = uniform(rng, 0.02, 0.12);
  const int radius = whole(rng, 1, 2);
  Image<std::uint8_t> frozen;
  frozen.copy_from(out.pairs[1].right.cview());
  for (std::size_t i = 0; i < out.pairs.size(); ++i) {
    drivers::StereoPair& pair = out.pairs[i];
    const double width = pair.left.width(), height = pair.left.height();
    const auto both = [&](auto&& f) {
      each_pixel(pair.left, f);
      each_pixel(pair.right, f);
    };
    both([&](int, int, double p) { return gain * p + more_noise * normal(rng); });
    switch (out.kind) {
      case Kind::blank:
        if (spoilt(i)) both([](int, int, double) { return 128.0; });
        if (spoilt(i)) out.solvable[i] = false;
        break;
      case Kind::noise:
        if (spoilt(i)) both([&](int, int, double) { return uniform(rng, 0.0, 255.0); });
        if (spoilt(i)) out.solvable[i] = false;
        break;
      case Kind::frozen:
        if (spoilt(i)) pair.right.copy_from(frozen.cview());
        if (spoilt(i)) out.solvable[i] = false;
        break;
      case Kind::swapped:
        std::swap(pair.left, pair.right);
        out.solvable[i] = false;
        break;
      case Kind::gap:
        if (i == static_cast<std::size_t>(frames) / 2) out.solvable[i] = false;
        if (static_cast<int>(i) >= frames / 2) pair.stamp_ns += 2'000'000'000;
        break;
      case Kind::calibration:
      case Kind::water:
      case Kind::mover:
        out.solvable[i] = false;
        break;
      case Kind::covered:
        if (spoilt(i)) {
          each_pixel(pair.left, [&](int x, int y, double p) {
            const double u = x / width, v = y / height;
            const double open = cover_side == 0   ? u - 0.7
                                : cover_side == 1 ? 0.3 - u
                                : cover_side == 2 ? v - 0.7
                                                  : 0.3 - v;
            return 9.0 + std::clamp(open / 0.05 + 0.5, 0.0, 1.0) * (p - 9.0);
          });
        }
        if (spoilt(i)) out.solvable[i] = false;
        break;
      case Kind::flare:
        if (spoilt(i)) {
          both([&](int x, int y, double p) {
            const double dx = (x / width - glow_x) / 0.3, dy = (y / height - glow_y) / 0.3;
            return 0.7 * p + 30.0 + strength * std::exp(-dx * dx - dy * dy);
          });
        }
        break;
      case Kind::night:
        if (spoilt(i)) both([&](int, int, double p) { return light * p + 6.0 + 1.5 * normal(rng); });
        if (spoilt(i)) out.solvable[i] = false;
        break;
      case Kind::blur:
        if (spoilt(i)) {
          blur(pair.left, radius);
          blur(pair.right, radius);
        }
        if (static_cast<int>(i) == spoilt_first || static_cast<int>(i) == spoilt_end) out.solvable[i] = false;
        if (radius > 1 && spoilt(i)) out.solvable[i] = false;
        break;
      default:
        break;
    }
  }
  if (out.kind == Kind::calibration) out.judged_from = 50;
  return out;
}

}  // namespace cliquevo::test

// SPDX-License-Identifier: BSD-3-Clause
// cliquevo disparity: the dense stereo stage on one rectified pair.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/base/time.h"
#include "drivers/images/image_reader.h"
#include "drivers/images/png_writer.h"
#include "stereo/dense_stereo.h"
#include "tools/commands.h"
#include "tools/exit_code.h"
#include "tools/output_file.h"
#include "tools/picture.h"

namespace cliquevo::tools {

namespace {

constexpr int kFileScale = 256;  // the file's units a px
constexpr int kMostDisparities = 256;

struct DisparityArguments {
  std::string left;
  std::string right;
  std::string out;
  std::string color;
  int max_disparity = 128;
};

struct Pair {
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
};

Result<Pair> read_pair(const DisparityArguments& arguments) {
  Pair pair;
  drivers::ImageReader reader;
  if (auto ok = reader.read(arguments.left, pair.left); !ok) return ok.error();
  if (auto ok = reader.read(arguments.right, pair.right); !ok) return ok.error();
  if (!pair.right.cview().same_size(pair.left.width(), pair.left.height())) {
    return Error{"images of unequal size", arguments.right,
                 fmt::format("it is {}x{}, the left one {}x{}: give a rectified pair", pair.right.width(),
                             pair.right.height(), pair.left.width(), pair.left.height())};
  }
  return pair;
}

struct Matched {
  Image<std::int16_t> disparity;
  double elapsed_ms;  // without the set-up, which a camera needs once
};

Result<Matched> match(const Pair& pair, int max_disparity) {
  stereo::StereoParams params;
  params.min_disparity = 0;
  params.num_disparities = (max_disparity + 15) / 16 * 16;  // the kernels' step
  const int width = pair.left.width();
  const int height = pair.left.height();
  auto dense = stereo::DenseStereo::make(params, width, height);
  if (!dense) return dense.error();
  Image<std::uint8_t> filtered(width, height);
  Matched out{Image<std::int16_t>(width, height), 0.0};
  const std::int64_t begin_ns = monotonic_ns();
  if (auto ok = dense->compute(pair.left.cview(), pair.right.cview(), filtered.view(), out.disparity.view()); !ok) {
    return ok.error();
  }
  out.elapsed_ms = static_cast<double>(monotonic_ns() - begin_ns) * 1e-6;
  return out;
}

// 16 bit, px * 256, 0 = unknown (and nearer than infinity only: d <= 0 is unknown).
Image<std::uint16_t> to_file_units(ImageView<const std::int16_t> disparity, int max_disparity) {
  Image<std::uint16_t> out(disparity.width, disparity.height);
  for (int y = 0; y < disparity.height; ++y) {
    std::uint16_t* row = out.view().row(y);
    for (int x = 0; x < disparity.width; ++x) {
      const int d = disparity(x, y);  // kUnknownDisparity is below zero
      const bool known = d > 0 && d <= (max_disparity - 1) * kDisparityScale;
      row[x] = static_cast<std::uint16_t>(known ? d * (kFileScale / kDisparityScale) : 0);
    }
  }
  return out;
}

// Near is red, far is blue, unknown is black; the colours span what the picture holds.
Picture to_color(ImageView<const std::uint16_t> disparity) {
  unsigned nearest = 1;
  for (int y = 0; y < disparity.height; ++y) {
    for (int x = 0; x < disparity.width; ++x) nearest = std::max<unsigned>(nearest, disparity(x, y));
  }
  Picture out(disparity.width, disparity.height, {});
  for (int y = 0; y < disparity.height; ++y) {
    for (int x = 0; x < disparity.width; ++x) {
      if (disparity(x, y) != 0) out.set(x, y, rainbow(static_cast<double>(disparity(x, y)) / nearest));
    }
  }
  return out;
}

std::int64_t count_known(ImageView<const std::uint16_t> disparity) {
  std::int64_t known = 0;
  for (int y = 0; y < disparity.height; ++y) {
    for (int x = 0; x < disparity.width; ++x) known += disparity(x, y) != 0 ? 1 : 0;
  }
  return known;
}

Result<void> write_png(OutputFile& file, const Result<std::vector<unsigned char>>& png) {
  return png ? file.write(*png) : png.error();
}

int run(const DisparityArguments& arguments) {
  const auto pair = read_pair(arguments);
  if (!pair) return report(pair.error());
  auto out = OutputFile::open(arguments.out, "disparity");
  if (!out) return report(out.error());
  const auto matched = match(*pair, arguments.max_disparity);
  if (!matched) return report(matched.error());

  const Image<std::uint16_t> picture = to_file_units(matched->disparity.cview(), arguments.max_disparity);
  if (auto ok = write_png(*out, drivers::encode_png(picture.cview())); !ok) return report(ok.error());
  if (!arguments.color.empty()) {
    auto color = OutputFile::open(arguments.color, "picture");
    if (!color) return report(color.error());
    if (auto ok = write_png(*color, to_color(picture.cview()).png()); !ok) return report(ok.error());
  }
  const double pixels = static_cast<double>(picture.width()) * picture.height();
  fmt::print("{}x{}, {} disparities, {:.1f} % known, {:.1f} ms\n", picture.width(), picture.height(),
             arguments.max_disparity, 100.0 * static_cast<double>(count_known(picture.cview())) / pixels,
             matched->elapsed_ms);
  return kDone;
}

}  // namespace

void add_disparity_command(CliCommand app, int& exit_code) {
  auto arguments = std::make_shared<DisparityArguments>();
  const CliCommand disparity = app.add_subcommand("disparity", "Dense disparity of one rectified pair of images");
  disparity.add_option("LEFT", arguments->left, "Left image, rectified; colour becomes grey").required();
  disparity.add_option("RIGHT", arguments->right, "Right image of the same size").required();
  disparity.add_option("--out", arguments->out, "Disparity: 16-bit PNG, px * 256, 0 = unknown")
      .required()
      .type_name("FILE.png");
  disparity.add_option("--max-disparity", arguments->max_disparity, "Number of disparities searched, from 0")
      .between(1, kMostDisparities)
      .capture_default_str()
      .type_name("N");
  disparity.add_option("--color", arguments->color, "Also a picture to look at: near red, far blue, unknown black")
      .type_name("FILE.png");
  disparity.footer(
      "Example:\n"
      "  cliquevo disparity left.png right.png --out disparity.png --max-disparity 64 --color look.png");
  disparity.callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace cliquevo::tools

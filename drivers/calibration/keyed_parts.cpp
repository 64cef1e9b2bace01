// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/calibration/keyed_parts.h"

#include <cmath>

#include <fmt/format.h>

#include "drivers/text_file.h"

namespace cliquevo::drivers {

namespace {

// What a reader looks for: the camera's own, else the one for both.
Result<const KeyEntry*> own_or_common(const Keys& keys, Quantity quantity, KeySide side, int index = 0) {
  auto own = keys.find(quantity, side, index);
  if (!own || *own != nullptr || side == KeySide::none) return own;
  return keys.find(quantity, KeySide::none, index);
}

}  // namespace

Result<std::optional<double>> number_of(const Keys& keys, Quantity quantity, KeySide side, int index) {
  const auto entry = own_or_common(keys, quantity, side, index);
  if (!entry) return entry.error();
  if (*entry == nullptr || (*entry)->numbers.size() != 1) return std::optional<double>{};
  return std::optional<double>{(*entry)->numbers.front()};
}

Result<bool> read_focal_lengths(const Keys& keys, KeySide side, CameraCalibration& camera) {
  std::optional<double> values[4];  // fx, fy, cx, cy
  const auto f = number_of(keys, Quantity::focal, side);
  if (!f) return f.error();
  values[0] = values[1] = *f;
  for (const auto& [quantity, at] : {std::pair{Quantity::focals, 0}, {Quantity::centre, 2}}) {
    const auto pair = own_or_common(keys, quantity, side);
    if (!pair) return pair.error();
    if (*pair == nullptr) continue;
    values[at] = (*pair)->numbers[0];
    values[at + 1] = (*pair)->numbers[1];
  }
  int i = 0;
  for (const Quantity q : {Quantity::fx, Quantity::fy, Quantity::cx, Quantity::cy}) {
    const auto value = number_of(keys, q, side);
    if (!value) return value.error();
    if (*value) values[i] = *value;
    ++i;
  }
  for (const auto& value : values) {
    if (!value) return false;
  }
  if (auto ok = set_camera_matrix({*values[0], 0, *values[2], 0, *values[1], *values[3], 0, 0, 1}, "fx", camera); !ok) {
    return ok.error();
  }
  return true;
}

namespace {

Result<void> read_matrix(const KeyEntry& K, CameraParts& parts) {
  if (K.numbers.size() == 4) {  // fx fy cx cy
    const std::vector<double>& v = K.numbers;
    return put_camera_matrix({v[0], 0, v[2], 0, v[1], v[3], 0, 0, 1}, K.where, parts);
  }
  if (K.numbers.size() != 9) {
    return Error{fmt::format("{} has {} numbers instead of 9", printable(K.key), K.numbers.size()), K.where,
                 "copy the calibration again: it is torn"};
  }
  std::vector<double> v = K.numbers;
  parts.open = v[0] > 0.0 && v[4] > 0.0 && v[6] == 0.0 && v[7] == 0.0 && v[8] == 0.0;
  if (parts.open) v[8] = 1.0;
  // MATLAB's matrices are the transposes of those of everybody else.
  parts.transposed = v[2] == 0.0 && v[5] == 0.0 && v[6] > 0.0 && v[7] > 0.0 && v[8] == 1.0;
  if (!parts.transposed) return put_camera_matrix(v, K.where, parts);
  return put_camera_matrix({v[0], v[3], v[6], v[1], v[4], v[7], v[2], v[5], v[8]}, K.where, parts);
}

bool is_fisheye_name(std::string name) {
  for (char& c : name) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return name.find("fish") != std::string::npos || name.find("kannala") != std::string::npos ||
         name.find("equi") != std::string::npos || name.starts_with("kb");
}

// k1 k2 p1 p2 k3 ... as numbers of their own, in the model's order.
Result<void> read_terms(const Keys& keys, KeySide side, CameraParts& parts) {
  double k[7] = {};
  double p[3] = {};
  double s[5] = {};
  int most_k = 0;
  bool any_p = false;
  bool any_s = false;
  const auto take = [&](Quantity q, int index, double& into) -> Result<bool> {
    const auto value = number_of(keys, q, side, index);
    if (!value) return value.error();
    into = value->value_or(0.0);
    return value->has_value();
  };
  for (int i = 1; i <= 6; ++i) {
    const auto there = take(Quantity::k, i, k[i]);
    if (!there) return there.error();
    if (*there) most_k = i;
  }
  for (int i = 1; i <= 2; ++i) {
    const auto there = take(Quantity::p, i, p[i]);
    if (!there) return there.error();
    any_p = any_p || *there;
  }
  for (int i = 1; i <= 4; ++i) {
    const auto there = take(Quantity::s, i, s[i]);
    if (!there) return there.error();
    any_s = any_s || (*there && s[i] != 0.0);
  }
  if (most_k == 0 && !any_p) return {};
  const bool fisheye = is_fisheye_name(parts.lens) || (parts.lens.empty() && most_k == 4 && !any_p);
  if (fisheye) {
    if (parts.lens.empty()) parts.lens = "equidistant";
    parts.D = {k[1], k[2], k[3], k[4]};
    return {};
  }
  parts.D = {k[1], k[2], p[1], p[2], k[3]};
  if (most_k > 3 || any_s) parts.D.insert(parts.D.end(), {k[4], k[5], k[6]});
  if (any_s) parts.D.insert(parts.D.end(), {s[1], s[2], s[3], s[4]});
  return {};
}

// The model's name. Words that name no lens ("type: stereo") count only where the key names distortion, and a rectified
// camera's "perspective" not beside the raw ones' lens.
Result<std::string> lens_name(const Keys& keys, KeySide side) {
  std::string lens;
  for (const KeyEntry* entry : keys.lenses(side)) {
    const std::string& word = entry->word;
    const bool plain = word == "pinhole" || word == "PinHole" || word == "Pinhole" || word == "perspective";
    if (plain || (!is_lens_name(word) && entry->key.find("istort") == std::string::npos)) continue;
    if (!lens.empty() && lens != word) {
      return Error{"calibration names two lens models", entry->where,
                   "leave one of " + printable(lens) + " and " + printable(word.substr(0, 32))};
    }
    lens = word;
  }
  return lens;
}

// Mei's camera with its xi beside the distortion.
Result<void> add_xi(const Keys& keys, KeySide side, CameraParts& parts) {
  const auto xi = number_of(keys, Quantity::xi, side);
  if (!xi) return xi.error();
  CameraCalibration named;
  const bool unified =
      set_distortion(parts.lens, {0.0, 0.0, 0.0}, "", named).ok() && named.distortion == Distortion::unified;
  if (!*xi || !(parts.lens.empty() || unified)) return {};
  if (parts.D.size() == 5 && parts.D[4] == 0.0) parts.D.pop_back();
  if (parts.D.size() > 4) return {};
  parts.D.insert(parts.D.begin(), **xi);
  parts.lens = "omni";
  return {};
}

Result<void> read_lens(const Keys& keys, KeySide side, CameraParts& parts) {
  const auto lens = lens_name(keys, side);
  if (!lens) return lens.error();
  parts.lens = *lens;
  const auto D = own_or_common(keys, Quantity::distortion, side);
  if (!D) return D.error();
  parts.D_where = parts.where;
  if (*D == nullptr) {
    if (auto ok = read_terms(keys, side, parts); !ok) return ok;
    if (auto ok = add_xi(keys, side, parts); !ok) return ok;
    if (parts.lens.empty() && !parts.D.empty()) parts.lens = "pinhole";  // the terms have their names
    return {};
  }
  parts.D = (*D)->numbers;
  parts.D_where = (*D)->where;
  return add_xi(keys, side, parts);
}

Result<void> read_size(const Keys& keys, KeySide side, CameraParts& parts) {
  for (const Quantity q : {Quantity::size, Quantity::shape}) {
    const auto list = own_or_common(keys, q, side);
    if (!list) return list.error();
    if (*list == nullptr) continue;
    const std::vector<double>& v = (*list)->numbers;
    const auto size =
        q == Quantity::size ? size_from(v[0], v[1], (*list)->where) : size_from(v[1], v[0], (*list)->where);
    if (!size) return size.error();
    parts.camera.width = size->first;
    parts.camera.height = size->second;
    return {};
  }
  const auto width = number_of(keys, Quantity::width, side);
  if (!width) return width.error();
  const auto height = number_of(keys, Quantity::height, side);
  if (!height) return height.error();
  if (!*width || !*height) return {};
  const auto size = size_from(**width, **height, parts.where);
  if (!size) return size.error();
  parts.camera.width = size->first;
  parts.camera.height = size->second;
  return {};
}

}  // namespace

Result<CameraParts> read_parts(const Keys& keys, KeySide side, const std::string& path) {
  CameraParts parts;
  parts.where = path;
  const auto K = own_or_common(keys, Quantity::camera_matrix, side);
  if (!K) return K.error();
  if (*K != nullptr) {
    if (auto ok = read_matrix(**K, parts); !ok) return ok.error();
  } else {
    const auto there = read_focal_lengths(keys, side, parts.camera);
    if (!there) return Error{there.error().what, path + " (" + there.error().where + ")", there.error().remedy};
    if (!*there && side == KeySide::right) {  // one camera's numbers for both
      if (const auto left = read_focal_lengths(keys, KeySide::left, parts.camera); !left) return left.error();
    }
  }
  if (auto ok = read_size(keys, side, parts); !ok) return ok.error();
  if (auto ok = read_lens(keys, side, parts); !ok) return ok.error();
  const auto P = keys.find(Quantity::projection, side);
  if (!P) return P.error();
  if (*P != nullptr) parts.P = (*P)->numbers;
  for (const Quantity q : {Quantity::rectification, Quantity::rotation}) {
    const auto R = keys.find(q, side);
    if (!R) return R.error();
    if (*R == nullptr || (*R)->numbers.size() != 9 || parts.R) continue;
    if (auto ok = put_rectification((*R)->numbers, (*R)->where, parts); !ok) return ok.error();
  }
  return parts;
}

}  // namespace cliquevo::drivers

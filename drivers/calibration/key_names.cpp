// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/calibration/key_names.h"

#include <algorithm>
#include <array>

#include "drivers/calibration/key_words.h"

namespace cliquevo::drivers {

namespace {

// A word without meaning for the value.
bool is_filler(const std::string& w) {
  return among(
      w, {"camera",      "cam",     "cameras",   "matrix",      "matrices", "mat",          "mtx",        "parameters",
          "params",      "param",   "parameter", "calibration", "calib",    "coefficients", "coefficent", "coefficents",
          "coefficient", "coeffs",  "coeff",     "coefs",       "coef",     "vector",       "vec",        "the",
          "of",          "between", "stereo",    "value",       "values",   "to",           "raw",        "px",
          "m",           "image",   "img",       "eye",         "data",     "rgb",          "ir",         "nir",
          "color",       "colour",  "gray",      "grey",        "mono",     "infra"});
}

// Words beside which a single "r" is still a rotation.
bool names_camera_or_frame(const std::string& w) {
  return among(w, {"r",           "l",         "left",       "right",  "cam",  "camera",   "stereo", "calib",
                   "calibration", "extrinsic", "extrinsics", "to",     "from", "world",    "imu",    "body",
                   "rig",         "c",         "lr",         "rl",     "extr", "relative", "rel",    "rgb",
                   "ir",          "nir",       "color",      "colour", "gray", "grey",     "mono",   "infra"});
}

struct Words {
  std::vector<std::string> rest;  // without words for cameras and fillers
  bool matrix = false;            // fillers that mean something where nothing else is
  bool coefficients = false;
  bool m = false;
};

// Takes the words for cameras and the cameras' numbers out. `of_a_group`: the key of a map that holds the quantity.
Words sort_words(std::vector<std::string> words, bool of_a_group, KeyMeaning& meaning) {
  split_fused(words);
  Words out;
  // "r" is the right camera beside another word, and a rotation alone.
  std::size_t others = of_a_group ? 1 : 0;
  for (const std::string& w : words) {
    others += is_number(w) || names_camera_or_frame(w) ? 0 : 1;
  }
  bool rotation = false;
  const auto see = [&meaning](KeySide side) {
    meaning.side = meaning.side == KeySide::none || meaning.side == side ? side : KeySide::both;
  };
  for (const std::string& w : words) {
    if (among(w, {"left", "l", "lft", "first", "links", "gauche", "izquierda", "izq", "sinistra", "esquerda"})) {
      see(KeySide::left);
    } else if (among(w, {"right", "rgt", "second", "rechts", "droite", "derecha", "der", "destra", "direita"}) ||
               (w == "r" && (others > 0 || rotation))) {
      see(KeySide::right);
    } else if (among(w, {"lr", "rl"})) {
      meaning.side = KeySide::both;
    } else if (is_number(w)) {
      if (w.size() > 1 || meaning.number) {
        if (w.size() <= 2) meaning.side = KeySide::both;  // "R_12", "T_c1_c2"
      } else {
        meaning.number = w[0] - '0';
      }
    } else {
      rotation = rotation || w == "r";
      out.matrix = out.matrix || among(w, {"matrix", "matrices", "mat", "mtx", "camera", "cam"});
      out.coefficients = out.coefficients || w.starts_with("coef");
      out.m = out.m || w == "m";
      if (!is_filler(w)) out.rest.push_back(w);
    }
  }
  return out;
}

// Frames in a pose's name besides the cameras'.
bool names_body(const std::vector<std::string>& words) {
  return std::any_of(words.begin(), words.end(), [](const std::string& w) {
    return among(w, {"imu", "body", "b", "i", "s", "bs", "sc", "bc", "cb", "ic", "ci", "base"});
  });
}

void read_pose(const std::vector<std::string>& words, KeyMeaning& meaning) {
  const auto at = [&](std::initializer_list<const char*> names) {
    return std::find_if(words.begin(), words.end(), [&](const std::string& w) { return among(w, names); });
  };
  // MC-Calib's: of the camera in the first one.
  constexpr std::array<const char*, 3> kMcCalib{"camera", "pose", "matrix"};
  if (std::search(words.begin(), words.end(), kMcCalib.begin(), kMcCalib.end()) != words.end()) {
    meaning.against_body = meaning.body_first = true;
    return;
  }
  if (!names_body(words)) return;
  meaning.against_body = true;
  const auto body = at({"imu", "body", "b", "i", "base", "bs", "sc", "bc", "ic"});
  const auto camera = at({"cam", "camera", "c", "cb", "ci"});
  meaning.body_first = body != words.end() && (camera == words.end() || body < camera);
}

// "focal_length_x", "c_y", "alpha_u": a length or a coordinate, and its axis.
Quantity along_axis(const std::vector<std::string>& rest) {
  if (rest.size() < 2 || !among(rest.back(), {"x", "y", "u", "v"})) return Quantity::none;
  const bool first = among(rest.back(), {"x", "u"});
  const std::string& what = rest[rest.size() - 2];
  const bool focal = among(what, {"f", "focal", "focallength", "alpha"}) ||
                     (what == "length" && rest.size() > 2 && rest[rest.size() - 3] == "focal");
  if (focal) return first ? Quantity::fx : Quantity::fy;
  const bool centre = among(what, {"c", "cc", "pp", "center", "centre", "principal", "principalpoint"}) ||
                      (what == "point" && rest.size() > 2 && rest[rest.size() - 3] == "principal");
  if (centre) return first ? Quantity::cx : Quantity::cy;
  return Quantity::none;
}

Quantity scalar(std::vector<std::string> rest) {
  while (!rest.empty() && (unit_named(rest.back()) > 0.0 || rest.back() == "in")) rest.pop_back();
  if (rest.size() > 1 && rest.front() == "baseline" && among(rest.back(), {"length", "distance"})) rest.pop_back();
  if (rest.empty()) return Quantity::none;
  if (const Quantity q = along_axis(rest); q != Quantity::none) return q;
  const std::string& w = rest.back();
  if (among(w, {"fx", "fu", "gamma1", "alphax"})) return Quantity::fx;
  if (among(w, {"fy", "fv", "alphay"})) return Quantity::fy;
  if (among(w, {"cx", "cu", "ppx", "u", "u0"})) return Quantity::cx;
  if (among(w, {"cy", "cv", "ppy", "v", "v0"})) return Quantity::cy;
  if (among(w, {"f", "focal", "focallength"}) || (w == "length" && rest.front() == "focal")) return Quantity::focal;
  if (among(w, {"width", "nwidth", "cols", "w"})) return Quantity::width;
  if (among(w, {"height", "nheight", "rows", "h"})) return Quantity::height;
  if (w == "bf" || w == "fb" || (w == "baseline" && rest.front() == "focal")) return Quantity::bf;
  const bool parted = w == "line" && rest.size() > 1 && rest[rest.size() - 2] == "base";
  if (w == "baseline" || w == "b" || parted) return Quantity::baseline;
  if (w == "xi") return Quantity::xi;
  if (w == "offset" && rest.size() == 2 && among(rest.front(), {"vertical", "disparity"})) return Quantity::row_offset;
  if (w == "alpha") return Quantity::alpha;
  if (w == "beta") return Quantity::beta;
  return Quantity::none;
}

bool is_rectified_name(const std::vector<std::string>& rest) {
  return std::any_of(rest.begin(), rest.end(), [](const std::string& w) {
    return among(
        w, {"new",   "optimal",   "rectified",   "undistorted", "undist",      "roi",    "valid", "error",   "rms",
            "std",   "essential", "fundamental", "covariance",  "noise",       "lidar",  "velo",  "depth",   "gps",
            "mocap", "percent",   "expected",    "nominal",     "theoretical", "target", "file",  "files",   "path",
            "topic", "dir",       "folder",      "url",         "angle",       "angles", "euler", "degrees", "deg"});
  });
}

// Sizes of boards, windows and the like are not the images'.
bool is_of_something_else(const std::vector<std::string>& words) {
  return std::any_of(words.begin(), words.end(), [](const std::string& w) {
    return w.starts_with("chess") || w.starts_with("check") || w.starts_with("square") || w.starts_with("board") ||
           among(w, {"pattern", "corner", "corners", "inner", "marker", "tag", "aruco", "charuco", "april", "aprilgrid",
                     "grid", "block", "window", "win", "kernel", "viewer", "tile", "requested", "desired"});
  });
}

// Between wheels or antennas, not between cameras.
bool is_of_vehicle(const std::vector<std::string>& words) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& w = words[i];
    if (w.starts_with("wheel")) return true;
    if (among(w, {"axle", "track", "gnss", "gps", "rtk", "antenna", "antennas", "uwb"})) return true;
    const bool whose = w == "robot" || w.starts_with("odo");  // "visual_odometry.camera.baseline" is a camera's
    if (whose && i + 1 < words.size() && words[i + 1] == "baseline") return true;
  }
  return false;
}

bool is_size(Quantity q) {
  return q == Quantity::size || q == Quantity::shape || q == Quantity::width || q == Quantity::height;
}

bool is_rotation_word(const std::string& w) {
  return w == "r" || w.starts_with("rot") || w.starts_with("quat") ||
         among(w, {"rmat", "om", "rvec", "rodrigues", "orientation"});
}
bool is_translation_word(const std::string& w) {
  return among(w, {"t", "tra", "trans", "trns", "tvec"}) || w.starts_with("transl");
}

Quantity array(const Words& words, std::size_t count) {
  const std::vector<std::string>& rest = words.rest;
  if (rest.empty()) {
    if (count == 9 && (words.matrix || words.m)) return Quantity::camera_matrix;
    return words.coefficients ? Quantity::distortion : Quantity::none;
  }
  const std::string& first = rest.front();
  const auto any = [&](auto test) { return std::any_of(rest.begin(), rest.end(), test); };
  if (any([](const std::string& w) { return w.starts_with("dist") && w != "distance"; })) return Quantity::distortion;
  if (rest.size() == 1 && among(first, {"d", "dc", "kc"})) return Quantity::distortion;
  if (any([](const std::string& w) { return w.starts_with("rect"); })) {
    return count == 9 ? Quantity::rectification : count == 12 ? Quantity::projection : Quantity::none;
  }
  if (any([](const std::string& w) { return w.starts_with("proj"); }) || (rest.size() == 1 && first == "p")) {
    return count == 12 ? Quantity::projection : Quantity::none;
  }
  if (any([](const std::string& w) { return w.starts_with("intr"); }) ||
      (rest.size() == 1 && among(first, {"k", "a", "kk", "cm", "km", "kmat", "kmtx", "int"}))) {
    return Quantity::camera_matrix;
  }
  if (rest.size() == 1 && !words.matrix && first == "rs" && count == 9) return Quantity::rotation;
  if (rest.size() == 1 && !words.matrix && first == "ts" && count == 3) return Quantity::translation;
  if (any(is_rotation_word) && (count == 9 || count == 3 || count == 4)) return Quantity::rotation;
  if (any(is_translation_word) && count == 3) return Quantity::translation;
  const bool pose = any([](const std::string& w) {
    return w == "t" || w == "rt" || w == "tf" || w == "pose" || w.starts_with("transf") || w.starts_with("extr");
  });
  if (pose && (count == 16 || count == 12)) return Quantity::pose;
  if (count == 2) {
    if (any([](const std::string& w) { return w == "fc" || w == "focal" || w.starts_with("focallength"); })) {
      return Quantity::focals;
    }
    if (any([](const std::string& w) { return w == "cc" || w == "principal" || w.starts_with("principalpoint"); })) {
      return Quantity::centre;
    }
    if (any([](const std::string& w) { return w == "shape"; })) return Quantity::shape;
    if (any([](const std::string& w) {
          return among(w, {"size", "resolution", "imsize", "imgsize", "imagesize", "dimension", "dim", "framesize"});
        })) {
      return Quantity::size;
    }
  }
  return Quantity::none;
}

Quantity word_value(const Words& words) {
  const std::vector<std::string>& rest = words.rest;
  const bool model = std::any_of(rest.begin(), rest.end(), [](const std::string& w) {
    return among(w, {"model", "type", "lens"});
  });
  return model ? Quantity::lens : Quantity::none;
}

// "k1", "p2", "k1l": a term and its number, taken out of the words.
bool is_term(std::vector<std::string>& words, KeyMeaning& meaning) {
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    if (!among(words[i], {"k", "p", "s"}) || words[i + 1].size() != 1 || !is_number(words[i + 1])) continue;
    const int index = words[i + 1][0] - '0';
    if (index < 1 || index > 6) continue;
    meaning.index = index;
    meaning.quantity = words[i] == "k" ? Quantity::k : words[i] == "p" ? Quantity::p : Quantity::s;
    const auto at = words.begin() + static_cast<std::ptrdiff_t>(i);
    words.erase(at, at + 2);
    return true;
  }
  return false;
}

// "R_cam_to_world": from the camera to another frame than a camera.
bool leads_outwards(const std::vector<std::string>& words) {
  for (std::size_t i = 1; i + 1 < words.size(); ++i) {
    if (words[i] != "to" && words[i] != "2") continue;
    return among(words[i - 1], {"cam", "camera", "c"}) &&
           among(words[i + 1], {"world", "w", "body", "base", "imu", "rig", "board", "target", "reference", "ref"});
  }
  return false;
}

// What only the whole path of keys decides.
void settle(const std::vector<std::string>& words, KeyMeaning& meaning) {
  const bool in_metres = std::any_of(words.begin(), words.end(), [](const auto& w) { return unit_named(w) > 0.0; });
  if (is_size(meaning.quantity) && (in_metres || is_of_something_else(words) || is_of_vehicle(words))) {
    meaning.quantity = Quantity::none;
  }
  if (meaning.quantity == Quantity::baseline && is_of_vehicle(words)) meaning.quantity = Quantity::none;
  if (meaning.quantity == Quantity::row_offset) {
    meaning.index = std::find(words.begin(), words.end(), "disparity") != words.end() ? 1 : 0;
  }
  const bool rotation = meaning.quantity == Quantity::rotation;
  const bool translation = meaning.quantity == Quantity::translation;
  if (rotation || translation || meaning.quantity == Quantity::pose) read_pose(words, meaning);
  if ((rotation || translation) && leads_outwards(words)) {
    meaning.quantity = rotation ? Quantity::rotation_outwards : Quantity::translation_outwards;
  }
  if (!translation && meaning.quantity != Quantity::pose && meaning.quantity != Quantity::baseline) return;
  for (const std::string& w : words) {
    if (const double unit = unit_named(w); unit > 0.0) meaning.unit_m = unit;
  }
  if (meaning.quantity == Quantity::baseline && meaning.unit_m > 0.0) meaning.quantity = Quantity::baseline_in_unit;
}

// The key of a map with a matrix or terms of each camera, by their names.
bool is_group_of_cameras(const std::string& key, std::size_t count) {
  KeyMeaning whose;
  const std::vector<std::string> words = words_of(key);
  const Words sorted = sort_words(words, false, whose);
  const bool camera_alone = sorted.rest.empty() && std::none_of(words.begin(), words.end(), [](const auto& w) {
                              return among(w, {"matrix", "matrices", "mat", "mtx", "m"}) || w.starts_with("coef");
                            });
  if (camera_alone || whose.side != KeySide::none || whose.number) return false;
  const Quantity q = array(sorted, count);
  return q == Quantity::camera_matrix || q == Quantity::distortion || q == Quantity::projection;
}

}  // namespace

double unit_named(const std::string& word) {
  if (among(word, {"m", "meter", "meters", "metre", "metres"})) return 1.0;
  if (among(word, {"mm", "millimeter", "millimeters", "millimetre", "millimetres"})) return 0.001;
  if (among(word, {"cm", "centimeter", "centimeters", "centimetre", "centimetres"})) return 0.01;
  return among(word, {"inch", "inches"}) ? 0.0254 : 0.0;
}

KeyMeaning meaning_of(const std::vector<std::string>& path, std::size_t count) {
  KeyMeaning meaning;
  bool decided = false;
  std::vector<std::string> all;
  for (std::size_t i = path.size(); i-- > 0;) {
    std::vector<std::string> words = words_of(path[i]);
    all.insert(all.begin(), words.begin(), words.end());
    if (!decided && count == 1 && is_term(words, meaning)) {
      decided = true;
    }
    const Words sorted = sort_words(words, decided, meaning);
    // "cameraR" in a group of camera matrices is the right camera's; alone, R is a rotation.
    if (!decided && i > 0 && meaning.side == KeySide::none && sorted.rest == std::vector<std::string>{"r"} &&
        is_group_of_cameras(path[i - 1], count)) {
      meaning.side = KeySide::right;
      continue;
    }
    if (is_rectified_name(sorted.rest) && count != 0) return {};
    if (decided) continue;
    if (sorted.rest.empty() && meaning.side == KeySide::both && (count == 12 || count == 16)) {
      meaning.quantity = Quantity::pose;  // "left_to_right"
      decided = true;
      continue;
    }
    const bool silent = sorted.rest.empty() && !sorted.matrix && !sorted.coefficients && !sorted.m;
    if (silent) continue;
    meaning.quantity = count == 0 ? word_value(sorted) : count == 1 ? scalar(sorted.rest) : array(sorted, count);
    decided = true;
  }
  settle(all, meaning);
  return meaning;
}

}  // namespace cliquevo::drivers

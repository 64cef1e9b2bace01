// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/report.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "drivers/board_calibration/residual_field.h"

namespace cliquevo::tools {

namespace {

using namespace calibration;

constexpr double kPictureWidth = 460.0;
constexpr double kArrow_px = 40.0;  // on the page, of the longest error

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

double longest_error(const CalibrationResult& r, Side side) {
  double longest = 1e-6;
  for (std::size_t v = 0; v < r.solution.views.size(); ++v) {
    for (const auto& e :
         residuals(r.board, r.solution.rig(), r.solution.adjusted.T_left_board[v], r.solution.views[v], side)) {
      if (e.allFinite()) longest = std::max(longest, e.norm());
    }
  }
  return longest;
}

// Every corner as an arrow from where the calibration puts it to where it was seen; the cells' means in red.
std::string field_picture(const CalibrationResult& r, Side side) {
  const Rig& rig = r.solution.rig();
  const double scale = kPictureWidth / rig.width;
  const double height = scale * rig.height;
  const double longest = longest_error(r, side);
  const double grow = kArrow_px / longest;
  std::string out = fmt::format(R"(<svg viewBox="0 0 {:.0f} {:.0f}" width="{:.0f}" height="{:.0f}" role="img">)"
                                R"(<rect width="100%" height="100%" class="image"/>)",
                                kPictureWidth, height, kPictureWidth, height);
  const auto arrow = [&](const Eigen::Vector2d& at, const Eigen::Vector2d& error, const char* look) {
    out += fmt::format(R"(<line x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}" class="{}"/>)", scale * at.x(),
                       scale * at.y(), scale * at.x() + grow * error.x(), scale * at.y() + grow * error.y(), look);
  };
  for (std::size_t v = 0; v < r.solution.views.size(); ++v) {
    const View& view = r.solution.views[v];
    const auto errors = residuals(r.board, rig, r.solution.adjusted.T_left_board[v], view, side);
    for (std::size_t i = 0; i < errors.size(); ++i) {
      if (errors[i].allFinite()) arrow(view.of(side)[i].px, errors[i], "corner");
    }
  }
  const ResidualField field = residual_field(r.board, r.solution, side);
  for (int row = 0; row < kFieldDown; ++row) {
    for (int column = 0; column < kFieldAcross; ++column) {
      const FieldCell& cell =
          field.cells[static_cast<std::size_t>(row) * kFieldAcross + static_cast<std::size_t>(column)];
      const Eigen::Vector2d middle((column + 0.5) * rig.width / kFieldAcross, (row + 0.5) * rig.height / kFieldDown);
      if (cell.corners == 0) {
        out += fmt::format(R"(<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" class="hole"/>)",
                           kPictureWidth * column / kFieldAcross, height * row / kFieldDown,
                           kPictureWidth / kFieldAcross, height / kFieldDown);
      } else {
        arrow(middle, cell.mean_px, "mean");
      }
    }
  }
  const double noise = r.solution.adjusted.sigma_px;
  const std::string structure =
      field.structure_px > 0.3 * noise
          ? fmt::format("{:.3f} px of structure is left over: another lens model may fit better", field.structure_px)
          : fmt::format("no structure is left over ({:.3f} px beyond noise)", field.structure_px);
  return fmt::format(
      "<figure>{}</svg><figcaption>{} image: errors, the longest arrow is {:.2f} px; {}. Grey: no corner "
      "was seen there.</figcaption></figure>",
      out, side == Side::left ? "Left" : "Right", longest, structure);
}

std::string view_rows(const nlohmann::json& views) {
  std::string out;
  for (const nlohmann::json& view : views) {
    out += fmt::format("<tr><td>{}</td><td>{}</td><td>{:.3f}</td><td>{}</td><td>{:.3f}</td></tr>\n",
                       escaped(view["name"].get<std::string>()), view["left"]["corners"].get<int>(),
                       view["left"]["rms_px"].get<double>(), view["right"]["corners"].get<int>(),
                       view["right"]["rms_px"].get<double>());
  }
  return out;
}

std::string parameter_rows(const nlohmann::json& parameters) {
  std::string out;
  for (const auto& [name, entry] : parameters.items()) {
    out += fmt::format("<tr><td>{}</td><td>{:.6g}</td><td>{:.2g}</td></tr>\n", name, entry["value"].get<double>(),
                       entry["sigma"].get<double>());
  }
  return out;
}

std::string model_rows(const nlohmann::json& models) {
  std::string out;
  for (const nlohmann::json& m : models) {
    out += fmt::format("<tr><td>{}</td><td>{:.4f}</td><td>{:.4f}</td></tr>\n", m["model"].get<std::string>(),
                       m["reprojection_rms_px"].get<double>(), m["row_rms_px"].get<double>());
  }
  return out;
}

constexpr const char* kStyle = R"(<style>
body{font:15px/1.45 system-ui,sans-serif;max-width:1000px;margin:2em auto;padding:0 1em;color:#1a1a1a;background:#fff}
h1{font-size:1.5em}h2{font-size:1.15em;margin-top:2em}pre{background:#f4f4f4;padding:1em;overflow-x:auto}
table{border-collapse:collapse}th,td{padding:.2em .8em;text-align:right;border-bottom:1px solid #ddd}
th:first-child,td:first-child{text-align:left}figure{display:inline-block;margin:0 1em 1em 0;width:460px;vertical-align:top}
figcaption{font-size:.85em;color:#444}svg .image{fill:#fafafa;stroke:#888}svg .corner{stroke:#0072b2;stroke-width:.7}
svg .mean{stroke:#d55e00;stroke-width:2.2}svg .hole{fill:#ccc;fill-opacity:.6}
</style>)";

}  // namespace

std::string calibration_report(const CalibrationResult& r) {
  const nlohmann::json json = to_json(r);
  std::string out =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Stereo calibration</title>\n";
  out += kStyle;
  out += fmt::format("</head><body>\n<h1>Stereo calibration: baseline {:.3f} mm, {:.3f} px RMS</h1>\n",
                     1e3 * json["baseline_m"].get<double>(), json["rms_px"].get<double>());
  out += fmt::format("<pre>{}</pre>\n<h2>Where errors are left</h2>\n", escaped(summary_of(r)));
  out += field_picture(r, Side::left) + field_picture(r, Side::right);
  out +=
      "\n<h2>Lens models, on views held out</h2>\n<table><tr><th>model</th><th>error, px a coordinate</th>"
      "<th>rows, px</th></tr>\n" +
      model_rows(json["models"]) + "</table>\n";
  out +=
      "<h2>Views</h2>\n<table><tr><th>view</th><th>left corners</th><th>left RMS, px</th><th>right corners</th>"
      "<th>right RMS, px</th></tr>\n" +
      view_rows(json["views"]) + "</table>\n";
  out += "<h2>Parameters</h2>\n<table><tr><th>name</th><th>value</th><th>sigma</th></tr>\n" +
         parameter_rows(json["parameters"]) + "</table>\n";
  out += fmt::format("<script type=\"application/json\" id=\"result\">{}</script>\n</body></html>\n", [&] {
    std::string text = json.dump();
    for (std::size_t at = text.find("</"); at != std::string::npos; at = text.find("</", at + 2)) {
      text.replace(at, 2, "<\\/");
    }
    return text;
  }());
  return out;
}

}  // namespace cliquevo::tools

// SPDX-License-Identifier: BSD-3-Clause
// maplab's sensors: of a list the one that is an NCAMERA, whose cameras name their matrices.
#include "drivers/calibration/format.h"

namespace cliquevo::drivers {

namespace {

const DocumentNode* find_ncamera(const CalibrationText& file) {
  const DocumentNode* sensors = file.document ? file.document->root().find("sensors") : nullptr;
  if (sensors == nullptr) return nullptr;
  for (const DocumentNode& sensor : sensors->items) {
    const DocumentNode* type = sensor.find("sensor_type");
    if (type != nullptr && type->scalar == "NCAMERA" && sensor.find("cameras") != nullptr) return &sensor;
  }
  return nullptr;
}

}  // namespace

bool is_maplab(const CalibrationText& file) { return find_ncamera(file) != nullptr; }

Result<StereoCalibration> read_maplab(const CalibrationText& file, const CalibrationRequest& request,
                                      const OtherFile& other) {
  DocumentNode cameras;
  cameras.kind = DocumentNode::Kind::map;
  cameras.entries.push_back({"cameras", *find_ncamera(file)->find("cameras")});
  CalibrationText rig(file.path, "");
  rig.document = Document::of(std::move(cameras), file.path);
  return read_keyed(rig, request, other);
}

}  // namespace cliquevo::drivers

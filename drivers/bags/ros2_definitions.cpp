// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/bags/ros2_definitions.h"

#include <algorithm>
#include <array>
#include <vector>

namespace cliquevo::drivers {

namespace {

struct Part {
  std::string_view type;
  std::string_view fields;  // a line each
};

constexpr std::array kParts{
    Part{"builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"},
    Part{"std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"},
    Part{"geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"},
    Part{"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"},
    Part{"geometry_msgs/Quaternion", "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"},
    Part{"geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"},
    Part{"geometry_msgs/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"},
    Part{"geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n"},
    Part{"geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist twist\nfloat64[36] covariance\n"},
    Part{"geometry_msgs/PoseStamped", "std_msgs/Header header\ngeometry_msgs/Pose pose\n"},
    Part{"geometry_msgs/Transform", "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"},
    Part{"geometry_msgs/TransformStamped",
         "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"},
    Part{"tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"},
    Part{"nav_msgs/Odometry",
         "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
         "geometry_msgs/TwistWithCovariance twist\n"},
    Part{"sensor_msgs/Image",
         "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\n"
         "uint8 is_bigendian\nuint32 step\nuint8[] data\n"},
    Part{"sensor_msgs/CompressedImage", "std_msgs/Header header\nstring format\nuint8[] data\n"},
    Part{"sensor_msgs/RegionOfInterest",
         "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n"},
    Part{"sensor_msgs/CameraInfo",
         "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\nfloat64[9] k\n"
         "float64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\nsensor_msgs/RegionOfInterest roi\n"},
    Part{"sensor_msgs/PointField",
         "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\n"
         "uint8 UINT32=6\nuint8 FLOAT32=7\nuint8 FLOAT64=8\nstring name\nuint32 offset\n"
         "uint8 datatype\nuint32 count\n"},
    Part{"sensor_msgs/PointCloud2",
         "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool is_bigendian\n"
         "uint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n"},
    Part{"diagnostic_msgs/KeyValue", "string key\nstring value\n"},
    Part{"diagnostic_msgs/DiagnosticStatus",
         "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\nstring message\n"
         "string hardware_id\ndiagnostic_msgs/KeyValue[] values\n"},
    Part{"diagnostic_msgs/DiagnosticArray", "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n"},
};

const Part* find(std::string_view type) {
  const auto* found = std::find_if(kParts.begin(), kParts.end(), [&](const Part& p) { return p.type == type; });
  return found == kParts.end() ? nullptr : found;
}

// The types of a definition's fields, one a line.
void collect(const Part& part, std::vector<const Part*>& known) {
  std::string_view rest = part.fields;
  while (!rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(line.size() + 1);
    const Part* inner = find(line.substr(0, line.find_first_of(" [")));
    if (inner == nullptr || std::find(known.begin(), known.end(), inner) != known.end()) continue;
    known.push_back(inner);
    collect(*inner, known);
  }
}

}  // namespace

std::string ros2_definition(std::string_view type) {
  const Part* part = find(type);
  if (part == nullptr) return {};
  std::vector<const Part*> inner;
  collect(*part, inner);
  std::string out(part->fields);
  for (const Part* p : inner) {
    out += std::string(80, '=') + "\nMSG: " + std::string(p->type) + "\n" + std::string(p->fields);
  }
  return out;
}

}  // namespace cliquevo::drivers

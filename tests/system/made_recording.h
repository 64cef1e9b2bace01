// SPDX-License-Identifier: BSD-3-Clause
// A small recording made by the simulator, for tests that damage it.
#pragma once

#include <string>

namespace cliquevo::test {

// A KITTI odometry folder (image_0, image_1, calib.txt, times.txt, poses.txt) with so many pairs of 320 x 240; made
// once a test program and copied, so that each caller may change its own.
std::string made_recording(int pairs = 6);
// One image file of it.
std::string image_of(const std::string& recording, int side, int pair);
// Overwrites both images of a pair with one grey level: nothing to match.
void blank_pair(const std::string& recording, int pair);
// Cuts a file after its first bytes.
void tear(const std::string& path);

}  // namespace cliquevo::test

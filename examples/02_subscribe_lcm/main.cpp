// SPDX-License-Identifier: BSD-3-Clause
// Poses and verdicts of the daemon (or of `cliquevo replay --lcm URL`), as any LCM program gets them.
#include <cstdio>
#include <cstdlib>
#include <string>

#include <cliquevo/pose_t.hpp>
#include <cliquevo/status_t.hpp>
#include <lcm/lcm-cpp.hpp>

namespace {

class Listener {
 public:
  void on_pose(const lcm::ReceiveBuffer*, const std::string&, const cliquevo::pose_t* pose) {
    // Body frame: X forward, Y left, Z up, where it started. Stamps are microseconds.
    std::printf("pose %lld us: %.3f %.3f %.3f m\n", static_cast<long long>(pose->utime), pose->pos[0], pose->pos[1],
                pose->pos[2]);
    ++poses_;
  }
  void on_status(const lcm::ReceiveBuffer*, const std::string&, const cliquevo::status_t* status) {
    std::printf("status %d, quality %d\n", static_cast<int>(status->status), static_cast<int>(status->quality));
  }
  long poses() const { return poses_; }

 private:
  long poses_ = 0;
};

}  // namespace

// subscribe_lcm [URL [COUNT]]: ends after COUNT poses, or at the end of a log (file:///path).
int main(int argc, char** argv) {
  const std::string url = argc > 1 ? argv[1] : "udpm://239.255.76.67:7667?ttl=0";
  const long most = argc > 2 ? std::strtol(argv[2], nullptr, 10) : 0;
  lcm::LCM lcm(url);
  if (!lcm.good()) {
    std::fprintf(stderr, "cannot listen: %s: see that the LCM URL is right\n", url.c_str());
    return 1;
  }
  Listener listener;
  lcm.subscribe("POSE_BODY", &Listener::on_pose, &listener);
  lcm.subscribe("VO_STATUS", &Listener::on_status, &listener);
  while ((most == 0 || listener.poses() < most) && lcm.handle() == 0) {
  }
  std::printf("%ld poses\n", listener.poses());
  return listener.poses() > 0 ? 0 : 1;
}

// SPDX-License-Identifier: BSD-3-Clause
// A machine whose clock begins at the same time at each boot: loaded before the C library, it gives that time, and the
// time since the program's first look at it.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <time.h>

static int (*real_clock_gettime)(clockid_t, struct timespec*);

int clock_gettime(clockid_t clock, struct timespec* out) {
  static struct timespec first;
  if (!real_clock_gettime) real_clock_gettime = (int (*)(clockid_t, struct timespec*))dlsym(RTLD_NEXT, "clock_gettime");
  if (clock != CLOCK_REALTIME) return real_clock_gettime(clock, out);
  struct timespec now;
  real_clock_gettime(CLOCK_MONOTONIC, &now);
  if (first.tv_sec == 0) first = now;
  out->tv_sec = 1700000000 + (now.tv_sec - first.tv_sec);
  out->tv_nsec = now.tv_nsec;
  return 0;
}

// SPDX-License-Identifier: BSD-3-Clause
// A recording that crashes whoever reads it: loaded before the C library, it ends the program at the opening of a file
// whose path has $CRASH_ON_OPEN in it.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void look_at(const char* path) {
  const char* bad = getenv("CRASH_ON_OPEN");
  if (bad && *bad && path && strstr(path, bad)) {
    fputs("about to crash, as intended\n", stderr);
    raise(SIGSEGV);
  }
}

FILE* fopen(const char* path, const char* mode) {
  look_at(path);
  return ((FILE * (*)(const char*, const char*)) dlsym(RTLD_NEXT, "fopen"))(path, mode);
}

FILE* fopen64(const char* path, const char* mode) {
  look_at(path);
  return ((FILE * (*)(const char*, const char*)) dlsym(RTLD_NEXT, "fopen64"))(path, mode);
}

int open(const char* path, int flags, ...) {
  look_at(path);
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) ? va_arg(more, mode_t) : 0;
  va_end(more);
  return ((int (*)(const char*, int, ...))dlsym(RTLD_NEXT, "open"))(path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  look_at(path);
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) ? va_arg(more, mode_t) : 0;
  va_end(more);
  return ((int (*)(const char*, int, ...))dlsym(RTLD_NEXT, "open64"))(path, flags, mode);
}

// SPDX-License-Identifier: BSD-3-Clause
// Preloaded in the virtual machine alone: libcamera 0.0.3 names a UVC camera by the firmware's node above it, and the
// simulated bus has none. $FIRMWARE_PATH is a file that stands for it.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char* stand_in(const char* path) {
  static const char wanted[] = "vhci_hcd.0/firmware_node/path";
  const size_t length = strlen(path);
  const size_t tail = sizeof wanted - 1;
  return length >= tail && strcmp(path + length - tail, wanted) == 0 ? getenv("FIRMWARE_PATH") : path;
}

int stat(const char* restrict path, struct stat* restrict status) {
  int (*real)(const char*, struct stat*) = (int (*)(const char*, struct stat*))dlsym(RTLD_NEXT, "stat");
  return real(stand_in(path), status);
}

int stat64(const char* restrict path, struct stat64* restrict status) {
  int (*real)(const char*, struct stat64*) = (int (*)(const char*, struct stat64*))dlsym(RTLD_NEXT, "stat64");
  return real(stand_in(path), status);
}

FILE* fopen(const char* restrict path, const char* restrict mode) {
  FILE* (*real)(const char*, const char*) = (FILE * (*)(const char*, const char*)) dlsym(RTLD_NEXT, "fopen");
  return real(stand_in(path), mode);
}

FILE* fopen64(const char* restrict path, const char* restrict mode) {
  FILE* (*real)(const char*, const char*) = (FILE * (*)(const char*, const char*)) dlsym(RTLD_NEXT, "fopen64");
  return real(stand_in(path), mode);
}

// SPDX-License-Identifier: BSD-3-Clause
#include "tests/system/interpose/interposer.h"

#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

namespace {

struct Watch {
  bool on = false;
  cliquevo::test::ForbiddenCalls calls;
  rusage begin{};
};
// initial-exec: reading it must not itself allocate.
__attribute__((tls_model("initial-exec"))) thread_local Watch watch;

void count(std::int64_t cliquevo::test::ForbiddenCalls::*what, const char* name) {
  if (!watch.on) return;
  ++(watch.calls.*what);
  if (watch.calls.first == nullptr) watch.calls.first = name;
}

constexpr auto kAllocation = &cliquevo::test::ForbiddenCalls::allocations;
constexpr auto kLock = &cliquevo::test::ForbiddenCalls::locks;
constexpr auto kInputOutput = &cliquevo::test::ForbiddenCalls::input_output;

// The function that this one stands in front of.
template <typename Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

namespace cliquevo::test {

void watch_this_thread() {
  getrusage(RUSAGE_THREAD, &watch.begin);
  watch.calls = {};
  watch.on = true;
}

ForbiddenCalls calls_of_this_thread() {
  rusage now{};
  getrusage(RUSAGE_THREAD, &now);
  ForbiddenCalls out = watch.calls;
  out.minor_faults = now.ru_minflt - watch.begin.ru_minflt;
  out.major_faults = now.ru_majflt - watch.begin.ru_majflt;
  return out;
}

}  // namespace cliquevo::test

// dlsym may allocate, so the allocator's own functions are reached by the names glibc keeps for them.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) {
  count(kAllocation, "malloc");
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) {
  count(kAllocation, "calloc");
  return __libc_calloc(n, size);
}
void* realloc(void* p, std::size_t size) {
  count(kAllocation, "realloc");
  return __libc_realloc(p, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  count(kAllocation, "memalign");
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  count(kAllocation, "aligned_alloc");
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** out, std::size_t alignment, std::size_t size) {
  count(kAllocation, "posix_memalign");
  *out = __libc_memalign(alignment, size);
  return *out != nullptr ? 0 : 12;
}
void free(void* p) {
  count(kAllocation, "free");
  __libc_free(p);
}

// One line a function: its kind, return type, name, parameters, and how it hands them on.
#define STAND_IN_FRONT(kind, type, name, parameters, arguments) \
  type name parameters {                                        \
    count(kind, #name);                                         \
    static auto* const real = next<type parameters>(#name);     \
    return real arguments;                                      \
  }

STAND_IN_FRONT(kLock, int, pthread_mutex_lock, (pthread_mutex_t * m), (m))
STAND_IN_FRONT(kLock, int, pthread_mutex_trylock, (pthread_mutex_t * m), (m))
STAND_IN_FRONT(kLock, int, pthread_mutex_unlock, (pthread_mutex_t * m), (m))
STAND_IN_FRONT(kLock, int, pthread_rwlock_rdlock, (pthread_rwlock_t * l), (l))
STAND_IN_FRONT(kLock, int, pthread_rwlock_wrlock, (pthread_rwlock_t * l), (l))
STAND_IN_FRONT(kLock, int, pthread_cond_wait, (pthread_cond_t * c, pthread_mutex_t* m), (c, m))
STAND_IN_FRONT(kLock, int, pthread_cond_timedwait, (pthread_cond_t * c, pthread_mutex_t* m, const timespec* t),
               (c, m, t))
STAND_IN_FRONT(kLock, int, pthread_cond_signal, (pthread_cond_t * c), (c))
STAND_IN_FRONT(kLock, int, pthread_cond_broadcast, (pthread_cond_t * c), (c))
STAND_IN_FRONT(kLock, int, sem_wait, (sem_t * s), (s))
STAND_IN_FRONT(kLock, int, sem_post, (sem_t * s), (s))

STAND_IN_FRONT(kInputOutput, ssize_t, read, (int fd, void* to, std::size_t n), (fd, to, n))
STAND_IN_FRONT(kInputOutput, ssize_t, pread, (int fd, void* to, std::size_t n, off_t at), (fd, to, n, at))
STAND_IN_FRONT(kInputOutput, ssize_t, readv, (int fd, const iovec* v, int n), (fd, v, n))
STAND_IN_FRONT(kInputOutput, ssize_t, write, (int fd, const void* from, std::size_t n), (fd, from, n))
STAND_IN_FRONT(kInputOutput, ssize_t, pwrite, (int fd, const void* from, std::size_t n, off_t at), (fd, from, n, at))
STAND_IN_FRONT(kInputOutput, ssize_t, writev, (int fd, const iovec* v, int n), (fd, v, n))
STAND_IN_FRONT(kInputOutput, int, close, (int fd), (fd))
STAND_IN_FRONT(kInputOutput, int, stat, (const char* path, struct stat* out), (path, out))
STAND_IN_FRONT(kInputOutput, int, lstat, (const char* path, struct stat* out), (path, out))
STAND_IN_FRONT(kInputOutput, int, fstat, (int fd, struct stat* out), (fd, out))
STAND_IN_FRONT(kInputOutput, int, access, (const char* path, int mode), (path, mode))
STAND_IN_FRONT(kInputOutput, int, fsync, (int fd), (fd))
STAND_IN_FRONT(kInputOutput, int, fdatasync, (int fd), (fd))
STAND_IN_FRONT(kInputOutput, std::FILE*, fopen, (const char* path, const char* mode), (path, mode))
STAND_IN_FRONT(kInputOutput, std::size_t, fwrite, (const void* p, std::size_t s, std::size_t n, std::FILE* f),
               (p, s, n, f))
STAND_IN_FRONT(kInputOutput, int, fflush, (std::FILE * f), (f))

int open(const char* path, int flags, ...) {
  count(kInputOutput, "open");
  static auto* const real = next<int(const char*, int, mode_t)>("open");
  va_list more;
  va_start(more, flags);
  const mode_t mode = va_arg(more, mode_t);
  va_end(more);
  return real(path, flags, mode);
}
int openat(int dir, const char* path, int flags, ...) {
  count(kInputOutput, "openat");
  static auto* const real = next<int(int, const char*, int, mode_t)>("openat");
  va_list more;
  va_start(more, flags);
  const mode_t mode = va_arg(more, mode_t);
  va_end(more);
  return real(dir, path, flags, mode);
}
}

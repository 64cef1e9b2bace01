// SPDX-License-Identifier: BSD-3-Clause
// Vectors of megabytes that are read all over: on huge pages where the system has them, which spares the look-up of
// a page for nearly every texel.
#pragma once

#include <cstddef>
#include <new>
#include <sys/mman.h>
#include <vector>

namespace cliquevo::drivers::sim {

template <typename T>
struct LargePages {
  using value_type = T;
  static constexpr std::size_t kHuge = std::size_t{2} << 20;

  LargePages() = default;
  template <typename U>
  LargePages(const LargePages<U>&) {}  // NOLINT(google-explicit-constructor)

  T* allocate(std::size_t n) {
    const std::size_t bytes = n * sizeof(T);
    void* p = ::operator new (bytes, std::align_val_t{bytes >= kHuge ? kHuge : 64});
#ifdef MADV_HUGEPAGE
    if (bytes >= kHuge) (void)::madvise(p, bytes, MADV_HUGEPAGE);  // a hint: refusal costs speed only
#endif
    return static_cast<T*>(p);
  }
  void deallocate(T* p, std::size_t n) { ::operator delete (p, std::align_val_t{n * sizeof(T) >= kHuge ? kHuge : 64}); }
  friend bool operator==(const LargePages&, const LargePages&) { return true; }
};

template <typename T>
using LargeArray = std::vector<T, LargePages<T>>;

}  // namespace cliquevo::drivers::sim

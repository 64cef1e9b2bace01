// SPDX-License-Identifier: BSD-3-Clause
// Image views and storage: the one pixel container that every room shares.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <type_traits>

namespace cliquevo {

// A view of pixels somebody else owns. `stride` is in elements, not bytes, and may exceed `width`.
template <typename T>
struct ImageView {
  T* data = nullptr;          // first pixel
  int width = 0;              // px
  int height = 0;             // px
  std::ptrdiff_t stride = 0;  // elements from row to row

  ImageView() = default;
  // width x height pixels from data_ on; stride_ in elements, >= width_.
  ImageView(T* data_, int width_, int height_, std::ptrdiff_t stride_)
      : data(data_), width(width_), height(height_), stride(stride_) {}
  // A view of mutable pixels is also one of constant pixels.
  template <typename U, typename = std::enable_if_t<std::is_const_v<T> && std::is_same_v<U, std::remove_const_t<T>>>>
  ImageView(const ImageView<U>& other)  // NOLINT(google-explicit-constructor)
      : data(other.data), width(other.width), height(other.height), stride(other.stride) {}

  // Whether it has no pixels.
  bool empty() const { return data == nullptr || width <= 0 || height <= 0; }
  // First pixel of a row, 0 <= y < height.
  T* row(int y) const { return data + y * stride; }
  // One pixel; not checked.
  T& operator()(int x, int y) const { return row(y)[x]; }
  // Whether the place is within.
  bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
  // Whether it has this size.
  bool same_size(int w, int h) const { return width == w && height == h; }
};

// Owning image: rows start on 64-byte boundaries. resize() keeps the memory when it suffices, so that a buffer
// that has seen its largest image allocates no more. Copies are explicit (copy_from).
template <typename T>
class Image {
 public:
  // Bytes.
  static constexpr std::size_t kAlignment = 64;

  Image() = default;
  // Its pixels are not set.
  Image(int width, int height) { resize(width, height); }

  // Pixels are not kept.
  void resize(int width, int height) {
    const std::size_t per_line = kAlignment / sizeof(T);
    const std::size_t stride = (static_cast<std::size_t>(width) + per_line - 1) / per_line * per_line;
    const std::size_t needed = stride * static_cast<std::size_t>(height);
    if (needed > capacity_) {
      data_.reset(static_cast<T*>(::operator new (needed * sizeof(T), std::align_val_t{kAlignment})));
      capacity_ = needed;
    }
    width_ = width;
    height_ = height;
    stride_ = static_cast<std::ptrdiff_t>(stride);
  }

  // Every pixel.
  void fill(T value) {
    for (int y = 0; y < height_; ++y) {
      T* r = data_.get() + y * stride_;
      for (int x = 0; x < width_; ++x) r[x] = value;
    }
  }

  // Takes size and pixels of another one.
  void copy_from(ImageView<const T> source) {
    resize(source.width, source.height);
    for (int y = 0; y < height_; ++y) {
      std::memcpy(data_.get() + y * stride_, source.row(y), static_cast<std::size_t>(width_) * sizeof(T));
    }
  }

  // Valid until the next resize() or copy_from().
  ImageView<T> view() { return {data_.get(), width_, height_, stride_}; }
  // Valid until the next resize() or copy_from().
  ImageView<const T> view() const { return {data_.get(), width_, height_, stride_}; }
  // Valid until the next resize() or copy_from().
  ImageView<const T> cview() const { return {data_.get(), width_, height_, stride_}; }
  // px
  int width() const { return width_; }
  // px
  int height() const { return height_; }
  // Whether it has no pixels.
  bool empty() const { return width_ <= 0 || height_ <= 0; }

 private:
  static_assert(std::is_trivially_copyable_v<T>);
  struct Free {
    void operator()(T* p) const { ::operator delete (p, std::align_val_t{kAlignment}); }
  };
  std::unique_ptr<T, Free> data_;
  std::size_t capacity_ = 0;
  int width_ = 0;
  int height_ = 0;
  std::ptrdiff_t stride_ = 0;
};

// Disparity inside the program: int16, px × 16; this value means "unknown".
inline constexpr std::int16_t kUnknownDisparity = -32768;
inline constexpr int kDisparityScale = 16;  // a px

}  // namespace cliquevo

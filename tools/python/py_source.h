// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "drivers/frame_source.h"
#include "tools/python/arguments.h"

namespace cliquevo::python {

// A source of pairs, which any thread may use, one at a time.
class PySource {
 public:
  explicit PySource(std::unique_ptr<drivers::FrameSource> source) : source_(std::move(source)) {}
  ~PySource() {
    // Closing may wait for the thread that reads ahead.
    const py::gil_scoped_release release;
    source_.reset();
  }
  PySource(const PySource&) = delete;
  PySource& operator=(const PySource&) = delete;

  // Null at the end. An Error is of one pair: the next call goes on behind it.
  std::unique_ptr<drivers::StereoPair> next() {
    auto pair = std::make_unique<drivers::StereoPair>();
    const bool more = value_of(without_gil(mutex_, [&]() -> Result<bool> {
      if (closed_) return false;
      return source_->next(*pair);
    }));
    return more ? std::move(pair) : nullptr;
  }
  // Another thread's next() ends soon.
  void close() {
    closed_ = true;
    source_->interrupt();
  }
  const drivers::SourceInfo& info() const { return source_->info(); }
  std::string finding() const { return source_->finding(); }

 private:
  std::mutex mutex_;
  std::atomic<bool> closed_{false};
  std::unique_ptr<drivers::FrameSource> source_;
};

}  // namespace cliquevo::python

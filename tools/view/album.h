// SPDX-License-Identifier: BSD-3-Clause
// What a report shows of a run's frames: a record of each, a few small pictures, and the worst ones as they were seen.
#pragma once

#include <string>
#include <vector>

#include "tools/view/pictures.h"
#include "tools/view/pipeline_feed.h"

namespace cliquevo::view {

class Album {
 public:
  // After each frame that the pipeline has processed.
  void add(const daemon::FramePipeline& pipeline, const drivers::StereoPair& pair);

  // JSON arrays.
  std::string records() const;
  std::string thumbnails() const;
  std::string worst() const;

 private:
  struct Kept {
    std::int64_t number = 0;
    double badness = 0.0;
    Bytes jpeg;
    Bytes features;
  };
  void keep_small(const daemon::FramePipeline& pipeline, std::int64_t number);
  void keep_if_bad(const daemon::FramePipeline& pipeline, const FrameFacts& facts, std::int64_t number);

  FactsMaker facts_;
  JpegEncoder jpeg_;
  std::vector<std::string> records_;
  std::vector<Kept> small_;
  std::int64_t every_ = 1;  // frames between small pictures; doubles when there are many
  std::vector<Kept> worst_;
};

// The report with this data (tools/view/page/report.js has its members): one file that needs nothing beside it.
std::string report_page(const std::string& data_json);

}  // namespace cliquevo::view

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>

#include "common/datasets/dataset.h"
#include "tracker/sources/frame_source.h"

namespace sheen {

/// Replays a data set's images with their given poses, in the order of the file, each exactly as `read_capture` gives
/// it. `next` throws FileError for an image that cannot be read.
class DatasetSource : public FrameSource {
 public:
  explicit DatasetSource(const std::filesystem::path& folder);

  std::optional<Frame> next(std::chrono::milliseconds timeout) override;
  SourceState state() const override;
  std::string message() const override;
  SourceStats stats() const override { return {.frames = next_view_}; }
  bool live() const override { return false; }
  std::string session() const override { return session_; }
  std::uint64_t session_size() const override { return dataset_.views.size(); }
  std::string warning() const override { return dataset_.warning; }

 private:
  const Dataset dataset_;
  std::string session_;
  std::atomic<std::size_t> next_view_ = 0;
};

}  // namespace sheen

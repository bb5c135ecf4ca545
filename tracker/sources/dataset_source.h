// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>

#include "common/datasets/stored_images.h"
#include "tracker/sources/frame_source.h"

namespace sheen {

/// Replays the images of a data set, or of a list of lights (.lp), with their given poses and lights, in the order of
/// the file, each exactly as `StoredImages::read` gives it. `next` throws FileError for an image that cannot be read.
class DatasetSource : public FrameSource {
 public:
  explicit DatasetSource(const std::filesystem::path& path) : images_(open_stored_images(path)) {}

  std::optional<Frame> next(std::chrono::milliseconds timeout) override;
  SourceState state() const override;
  std::string message() const override;
  SourceStats stats() const override { return {.frames = next_image_}; }
  bool live() const override { return false; }
  std::string session() const override { return images_.session; }
  std::uint64_t session_size() const override { return images_.size; }
  RigMotion motion() const override { return images_.motion; }
  std::string remarks() const override {
    return images_.summary + (images_.warning.empty() ? "" : "\n") + images_.warning;
  }

 private:
  const StoredImages images_;
  std::atomic<std::size_t> next_image_ = 0;
};

}  // namespace sheen

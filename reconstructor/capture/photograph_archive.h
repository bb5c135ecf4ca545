// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/datasets/dataset.h"
#include "common/geometry/mesh.h"
#include "reconstructor/capture/capture_set.h"
#include "reconstructor/models/model_settings.h"
#include "reconstructor/models/photograph_coding.h"

namespace sheen {

/// Photographs of an object as a small data set: each is cut to what it shows of the mesh, brought to the exposure of
/// the first where the exposures are known, and coded as WebP, all at one quality. A model is built of it as of the
/// photographs themselves, and how much its pictures lose is measured by doing so.
class PhotographArchive {
 public:
  /// Captures without a pose, and those that show nothing of the mesh, are left out; `every` Nth is held out where the
  /// captures do not say so themselves. All cut-outs are kept, uncompressed.
  PhotographArchive(const CaptureSet& captures, std::shared_ptr<const Mesh> mesh, int every);

  std::size_t size() const { return frames_.size(); }
  std::size_t left_out() const { return captures_.size - frames_.size(); }
  bool holds_out_any() const;

  /// Writes transforms.json, `images` and, where any capture has a mask, `masks` into a folder, which is made; what it
  /// has of the same names is replaced. Returns their bytes. Throws FileError.
  std::uintmax_t write(const std::filesystem::path& folder, int quality) const;
  /// The best quality at which that takes no more than so many bytes; nothing takes less than quality 0 does.
  int quality_within(std::uintmax_t bytes) const;

  /// Of the model of the captures themselves: PSNR in dB on the held-out ones, of which there must be some.
  double psnr_db(const ModelSettings& settings) const;
  /// Of the model of what `write` wrote, on the same views, whose photographs are not coded for that.
  double psnr_db(const ModelSettings& settings, const std::filesystem::path& archive) const;

 private:
  struct Frame {
    std::size_t capture;  ///< number in the set
    std::string source;   ///< its session
    DatasetView view;     ///< of the cut-out; names its files
    std::string mask;     ///< WebP, of the cut-out; empty without one
    float gain = 1;       ///< how much brighter it is than the first, by what the camera reports
  };
  double psnr_db(const ModelSettings& settings, const std::function<Capture(std::size_t)>& read) const;
  /// The capture, and whether it is held out.
  Capture read(std::size_t frame) const;
  std::vector<DatasetView> views(const std::filesystem::path& folder) const;

  CaptureSet captures_;
  std::shared_ptr<const Mesh> mesh_;
  std::vector<Frame> frames_;
  PhotographCoding coding_;
};

}  // namespace sheen

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/parallel/for_each.h"
#include "reconstructor/coding/chunk_file.h"
#include "reconstructor/light_field_file/file_layout.h"

namespace sheen {

/// A model on its way out of a file: whole numbers still, of which maps and coefficients are to be made.
struct QuantisedModel {
  CompactModel model;  ///< but for the maps and coefficients of its patches
  FileLayout layout;
  std::vector<QuantisedPatch> patches;

  /// The model, whose maps take many times the room. Triangles with a common edge take the mean of both along it.
  CompactModel dequantised(const ForEach& for_each) &&;
};

/// Decodes a file (docs/model_format.md) chunk by chunk, as far as it has arrived: chunks with checksums, the most
/// important first. Throws FileError that names the file and the chunk, and is of no use behind that.
class LightFieldReader {
 public:
  LightFieldReader(std::string file, ForEach for_each);

  /// Decodes the next chunk where `bytes`, the beginning of the file, holds all of it; its name. Empty where it does
  /// not, and where it was the last one. `bytes` may stand elsewhere at each call, and be longer.
  std::optional<std::string> read_next(std::string_view bytes);
  /// As far as it was read.
  const QuantisedModel& read() const { return quantised_; }
  /// What is missing leaves the model coarser (`CompactModel::missing_layers`), but all up to the first layer of the
  /// means must have been read.
  QuantisedModel finish() &&;

 private:
  struct Description {
    float step = 0;
    int layers = 0;
    std::size_t patch_triangles = 0;
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< of the mesh
    std::vector<double> layer_squares;  ///< what each layer adds to pictures: mean square, in grey levels
  };

  void decode(std::string_view name, std::string_view bytes);
  std::string next_chunk() const;
  [[noreturn]] void fail(const std::string& what) const;
  void begin_patches(std::string_view steps);
  void check_samples(const std::vector<std::uint8_t>& resolutions);
  void read_description(std::string_view bytes);
  void note_missing();

  std::string file_;
  ForEach for_each_;
  std::size_t position_ = 0;  ///< of the next chunk in the file
  std::size_t chunks_read_ = 0;
  std::size_t file_bytes_ = 0;  ///< that have arrived
  Description description_;
  QuantisedModel quantised_;
  LayerModels layer_models_;
};

}  // namespace sheen

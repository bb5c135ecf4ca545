// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "reconstructor/models/surface_light_field/gl/range_allocator.h"
#include "reconstructor/models/surface_light_field/light_field_snapshot.h"
#include "reconstructor/render/gl/gl_objects.h"

namespace sheen {

/// Where the surface maps of one patch stand on the GPU. The texel of sample s and term r is `first` + s * `rank` + r
/// of buffer `buffer`: (R, G, B) in half floats; the fourth value is its SampleState.
struct BasisSlot {
  std::uint32_t first = 0;
  std::uint16_t rank = 0;  ///< terms stored; 0 = nothing is
  std::uint8_t buffer = 0;
  std::uint32_t texels = 0;
};

/// Surface maps of many patches in a few texture buffers, which grow as patches and ranks do.
class BasisStore {
 public:
  static constexpr int kMaxBuffers = 4;
  static constexpr std::size_t kTexelBytes = 8;

  /// `max_buffer_texels` = 0: what the driver allows.
  explicit BasisStore(std::size_t max_buffer_texels = 0);

  /// Grows for `texels` more in one step, as far as that is possible: growing copies what is there.
  void reserve(std::size_t texels);
  /// Uploads a patch's surface maps. Where memory is short only the first terms are kept: `BasisSlot::rank` says how
  /// many.
  BasisSlot store(const SurfacePatch& patch);
  void release(const BasisSlot& slot);

  int buffers() const { return static_cast<int>(buffers_.size()); }  ///< in use
  std::size_t texels_used() const;
  std::size_t texels_reserved() const;
  /// Binds `kMaxBuffers` units from `first_unit` on; buffers not in use repeat the first.
  void bind(int first_unit) const;

 private:
  struct Buffer {
    BufferTexture texture;
    RangeAllocator ranges;
  };
  bool grow(std::size_t texels);
  BasisSlot place(std::size_t texels);

  std::size_t max_buffer_texels_;
  bool exhausted_ = false;  ///< the GPU has refused to give more
  std::vector<Buffer> buffers_;
  std::vector<std::uint16_t> staging_;
};

}  // namespace sheen

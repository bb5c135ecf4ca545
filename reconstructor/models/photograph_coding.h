// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "reconstructor/models/photographs.h"

namespace sheen {

/// Photographs as lossy pictures (WebP), all of one quality, cut to the object; what is not of the object is smooth and
/// costs next to nothing.
class PhotographCoding {
 public:
  static constexpr int kBest = 100;

  void add(const Photograph& photograph);
  /// Files, in the order in which the photographs came. Quality: 0..kBest.
  std::vector<std::string> coded(int quality) const;
  /// The best quality that takes no more than `bytes` in all; 0 where none does.
  int quality_within(std::size_t bytes) const;

 private:
  std::vector<ImageU8> pictures_;
};

struct CodedPhotographs {
  std::shared_ptr<const PhotographSet> photographs;  ///< as they are decoded again
  std::size_t bytes = 0;                             ///< of their files
};
/// At the best quality that takes no more than `bytes` in all, else the worst.
CodedPhotographs code_photographs(const PhotographSet& photographs, std::size_t bytes);

}  // namespace sheen

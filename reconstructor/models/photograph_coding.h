// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>

#include "reconstructor/models/photographs.h"

namespace sheen {

struct CodedPhotographs {
  std::shared_ptr<const PhotographSet> photographs;  ///< as they are decoded again
  std::size_t bytes = 0;                             ///< of their files
};
/// The photographs as lossy pictures, all of one quality: the best that takes no more than `bytes` in all, else the
/// worst. WebP, cut to the object; what is not of the object is smooth and costs next to nothing.
CodedPhotographs code_photographs(const PhotographSet& photographs, std::size_t bytes);

}  // namespace sheen

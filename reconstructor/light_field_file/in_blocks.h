// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>

#include "common/parallel/for_each.h"

namespace sheen {

/// So many at a time: one is too little for a task.
inline void in_blocks(std::size_t count, std::size_t block, const ForEach& for_each,
                      const std::function<void(std::size_t)>& work) {
  for_each((count + block - 1) / block, [&](std::size_t b) {
    for (std::size_t i = b * block; i < std::min(count, (b + 1) * block); ++i) work(i);
  });
}

}  // namespace sheen

// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include "common/parallel/for_each.h"

namespace sheen {

void in_parallel(std::size_t count, const std::function<void(std::size_t)>& work) {
  tbb::parallel_for(std::size_t{0}, count, work);
}

}  // namespace sheen

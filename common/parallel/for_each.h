// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>

namespace sheen {

/// Calls work(i) for each i below `count`, in any order. Injected: what is given one neither knows of threads nor has
/// any.
using ForEach = std::function<void(std::size_t count, const std::function<void(std::size_t)>& work)>;

/// On the caller's thread, in order.
inline void one_after_the_other(std::size_t count, const std::function<void(std::size_t)>& work) {
  for (std::size_t i = 0; i < count; ++i) work(i);
}

/// On all threads that parallel work of this program may take.
void in_parallel(std::size_t count, const std::function<void(std::size_t)>& work);

}  // namespace sheen

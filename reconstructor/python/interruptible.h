// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

namespace sheen {

/// Runs long work on a thread of its own, without Python's lock, which the caller holds. Ctrl-C ends it where it next
/// asks `stop_requested()` and becomes KeyboardInterrupt; work that ends by itself meanwhile does, too. Throws what the
/// work throws.
void interruptible(const std::function<void()>& work);

}  // namespace sheen

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/capture/capture.h"

namespace sheen::testing {

/// Fails the running test for every field that is not the same to the last bit.
void expect_same_bits(const Capture& a, const Capture& b);

}  // namespace sheen::testing

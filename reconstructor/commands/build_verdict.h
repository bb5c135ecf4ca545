// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "reconstructor/capture/reconstruction.h"

namespace sheen {

/// Why a model is worth nothing: it predicts the held-out views worse than its constant colour does, by more
/// than chance, and badly. A clause with the figures; empty where it is not so, or no view was held out. An object that
/// looks alike from everywhere is predicted well by either.
std::string worthless(const Reconstruction::Judgement& judged);

/// Why a model is doubtful: most of the images could not be used. A clause with the numbers and the commonest reason;
/// empty where it is not so. Held-out and withdrawn images do not count.
std::string mostly_unused(const FrameCounts& counts);

}  // namespace sheen

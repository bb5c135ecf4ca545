// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "reconstructor/commands/build.h"
#include "reconstructor/commands/evaluate.h"
#include "reconstructor/python/open_model.h"

namespace sheen {

// What commands do, for a script: their reports as text (JSON), nothing on standard output. Python's lock is held by
// the caller and let go meanwhile (`interruptible`). They throw what the commands throw.

std::string evaluated(const OpenModel& model, EvaluateRequest request);
/// `form`: "gltf", "ply", "obj", "usdz", "splats", "relight", "page" or "single", as the options of `export`; empty: by
/// the path's ending. What is written is told on standard output, too. Throws ConfigError for another form.
std::string exported(const OpenModel& model, const std::filesystem::path& out, const std::string& form);
std::string built(const BuildRequest& request);

}  // namespace sheen

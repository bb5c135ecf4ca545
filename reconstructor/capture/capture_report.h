// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "common/datasets/image_account.h"
#include "reconstructor/capture/capture_loop.h"
#include "reconstructor/capture/reconstruction.h"
#include "reconstructor/capture/saved_model.h"

namespace sheen {

/// The part of a report that `build` and `serve` share: frames, rates, stages, ranks, bytes, held-out scores beside
/// those of the constant-colour model. `judged`: by `Reconstruction::judge`.
nlohmann::json reconstruction_report(const Reconstruction& reconstruction, const Reconstruction::Judgement& judged);
/// The same of a live capture, with what only its loop knows: what waits, what was lost, how long it took to be
/// durable.
nlohmann::json live_report(const Reconstruction& reconstruction, const Reconstruction::Judgement& judged,
                           const LoopStatus& status);

/// What became of the image files of a data set.
nlohmann::json files_report(const ImageAccount& account);

/// Of a model that was saved as one small file.
nlohmann::json file_report(const std::filesystem::path& path, const SmallFile& file);

/// Some lines for a person: held-out figures beside the constant colour's, and what a small file lost.
void print_summary(const nlohmann::json& report);

}  // namespace sheen

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "reconstructor/capture/saved_model.h"

namespace sheen {

/// What a saved model is measured on.
struct EvaluateRequest {
  std::string dataset;     ///< the images that it was built from, and the held-out ones; or a list of lights (.lp)
  std::string truth;       ///< folder of NAME.exr to score against, not against the images; empty: none
  std::string object;      ///< mesh whose pixels count; empty: the model's
  bool baselines = false;  ///< also of what stores photographs
  bool told = true;        ///< in lines on standard output, too
};

/// PSNR and SSIM of a saved model, in messages called `name`, on views that it never saw: the report of `evaluate`.
/// Throws ConfigError, FileError, also where there is no such view.
nlohmann::json evaluate(const SavedModel& model, const std::string& name, const EvaluateRequest& request);

}  // namespace sheen

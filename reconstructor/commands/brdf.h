// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "reconstructor/numerics/light_search.h"

namespace sheen {

/// A reflectance that a person names.
struct Brdf {
  std::vector<std::shared_ptr<const Reflectance>> channels;  ///< one, or red, green and blue
  std::optional<ExposureBounds> closed_form;                 ///< where there is one
};

/// "lambertian", "lafortune:K" (one lobe round any direction), "lafortune:B:K,B:K..." (several, with weights), or a
/// file: JSON as docs/user_guide.md describes, or the MERL database's binary tables. Throws ConfigError and FileError.
Brdf parse_brdf(const std::string& words);

}  // namespace sheen

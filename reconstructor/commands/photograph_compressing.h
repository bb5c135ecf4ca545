// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "reconstructor/commands/size_options.h"

namespace sheen {

/// Makes the photographs of a session or data set small, tells what a model of them loses, and returns the same for a
/// report. `out`: a new folder.
nlohmann::json compress_photographs(const std::string& source, const std::string& mesh, const std::string& out,
                                    const SizeArguments& size);

}  // namespace sheen

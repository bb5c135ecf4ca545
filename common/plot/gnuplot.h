// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "common/plot/plot.h"

namespace sheen {

/// A gnuplot string: nothing but the quote has a meaning inside single quotes.
std::string gnuplot_string(const std::string& text);

/// Runs gnuplot on a script, in its folder. Throws FileError when it could not draw it.
PlotFiles run_gnuplot(const std::filesystem::path& script);

}  // namespace sheen

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sheen {

/// For each view's name (`file_path`) where its picture goes below an output folder, without an extension; all differ.
/// The folder that all views share is left away ("images/0001.png" becomes "0001"), folders that tell views apart stay
/// ("left/0001", "right/0001"), and none leads out of the output folder.
std::vector<std::filesystem::path> picture_names(const std::vector<std::string>& views);

}  // namespace sheen

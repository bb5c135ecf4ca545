// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace sheen {

/// Writes a page that shows a model in a browser, as a folder for any host of files. Files of an older page are
/// replaced. Throws ConfigError where the page does not draw such models, FileError else.
void write_page(const std::filesystem::path& model, const std::filesystem::path& folder);
/// The same as one file, which holds the model and opens from anywhere.
void write_single_page(const std::filesystem::path& model, const std::filesystem::path& file);

}  // namespace sheen

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace sheen {

/// What a page says beside its model.
struct PageText {
  std::string title;         ///< plain text
  std::string about = "{}";  ///< JSON: title, text, notes, up, eye, target, light
};
/// Of a model of this name, without more.
PageText page_text(const std::filesystem::path& model);
/// As a file (JSON) says: "title" and "text"; "notes", each with "at" (x, y, z in the frame of the mesh), "title" and
/// "text"; "up", "eye" and "target" of the first view; "light", the first one of an irradiance field. Throws FileError
/// that names what is wrong.
PageText read_page_text(const std::filesystem::path& file, const std::filesystem::path& model);

/// Writes a page that shows a model in a browser, as a folder for any host of files. Files of an older page are
/// replaced. Throws ConfigError where the page does not draw such models, or has no use for what it is to say;
/// FileError else.
void write_page(const std::filesystem::path& model, const std::filesystem::path& folder, const PageText& text);
/// The same as one file, which holds the model and opens from anywhere.
void write_single_page(const std::filesystem::path& model, const std::filesystem::path& file, const PageText& text);

}  // namespace sheen

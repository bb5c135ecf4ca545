// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/page_export.h"

#include <array>
#include <string>
#include <string_view>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "reconstructor/light_field_file/light_field_file.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPageFile = "index.html", kStyleFile = "sheen.css", kScriptFile = "sheen.js",
                           kWorkerFile = "worker.js", kDecoderFile = "sheen.wasm", kModelFile = "model.slf";

/// Where the build or the installation put the page: beside the program's own folder.
fs::path page_folder() {
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path();
  for (const char* place : {"../page", "../share/sheen/page"})
    if (fs::exists(program / place / kDecoderFile)) return (program / place).lexically_normal();
  throw Error(
      "this build of the program has no page for browsers: install what it is made with (deploy/install "
      "packages-wasm.txt) and build again (deploy/build)");
}

/// The bytes of a model that the page draws.
std::string model_bytes(const fs::path& model) {
  if (fs::is_directory(model))
    throw ConfigError(model.string() +
                      ": a page takes a model that is one file: sheen-reconstructor compress makes it");
  std::string bytes = read_file(model);
  if (!is_light_field_file(bytes))
    throw ConfigError(model.string() + ": a page shows surface light fields (.slf), and this is none");
  return bytes;
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  return out;
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::array<std::uint32_t, 3> three{};
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < count; ++k) three[k] = static_cast<std::uint8_t>(bytes[i + k]);
    const std::uint32_t bits = three[0] << 16 | three[1] << 8 | three[2];
    for (std::size_t k = 0; k < 4; ++k) out += k <= count ? kLetters[bits >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

/// The one place in the page's text that is to be something else.
void put(std::string& page, std::string_view place, const std::string& what) {
  const std::size_t at = page.find(place);
  if (at == std::string::npos) throw Error("the page of this build has no \"" + std::string(place) + "\"");
  page.replace(at, place.size(), what);
}

std::string titled_page(const fs::path& from, const fs::path& model) {
  std::string page = read_file(from / kPageFile);
  const std::string title = escaped(model.stem().string());
  put(page, "<title>Sheen</title>", "<title>" + title + "</title>");
  put(page, "<h1 id=\"title\">Sheen</h1>", "<h1 id=\"title\">" + title + "</h1>");
  return page;
}

/// Data that a script of the page finds by its name.
std::string inside(std::string_view id, const std::string& text) {
  return "<script type=\"text/plain\" id=\"" + std::string(id) + "\">" + text + "</script>\n";
}

}  // namespace

void write_page(const fs::path& model, const fs::path& folder) {
  const std::string bytes = model_bytes(model);
  const fs::path from = page_folder();
  make_folder(folder);
  for (const std::string_view file : {kStyleFile, kScriptFile, kWorkerFile, kDecoderFile})
    write_file(folder / file, read_file(from / file));
  write_file(folder / kModelFile, bytes);
  write_file(folder / kPageFile, titled_page(from, model));
}

void write_single_page(const fs::path& model, const fs::path& file) {
  const std::string bytes = model_bytes(model);
  const fs::path from = page_folder();
  std::string page = titled_page(from, model);
  put(page, "<link rel=\"stylesheet\" href=\"sheen.css\">", "<style>\n" + read_file(from / kStyleFile) + "</style>");
  put(page, "<script src=\"sheen.js\" defer></script>",
      inside("sheen-worker", read_file(from / kWorkerFile)) +
          inside("sheen-wasm", base64(read_file(from / kDecoderFile))) + inside("sheen-model", base64(bytes)) +
          "<script>\n" + read_file(from / kScriptFile) + "</script>");
  write_file(file, page);
}

}  // namespace sheen

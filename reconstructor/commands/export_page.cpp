// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/export_page.h"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "reconstructor/irradiance_field_file/field_reader.h"
#include "reconstructor/light_field_file/light_field_file.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::string_view kPageFile = "index.html", kStyleFile = "sheen.css", kScriptFile = "sheen.js",
                           kWorkerFile = "worker.js", kDecoderFile = "sheen.wasm";

/// What a page takes for models of a kind. Its script knows them by how the model's file is called.
struct PageKind {
  bool (*reads)(std::string_view start);
  std::string_view model, worker, decoder;  ///< the model's file in a page; of the build, its worker and its decoder
  std::string_view name;
  std::vector<std::string_view> without;  ///< fields of `PageText::about` that such a page has no use for
};
const std::array<PageKind, 2> kKinds{{
    {is_light_field_file, "model.slf", "light_field_worker.js", "light_field.wasm", "a surface light field", {"light"}},
    {is_field_file,
     "model.rif",
     "relit_worker.js",
     "relit.wasm",
     "an irradiance field",
     {"notes", "up", "eye", "target"}},
}};

/// Where the build or the installation put the page: beside the program's own folder.
fs::path page_folder() {
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path();
  for (const char* place : {"../page", "../share/sheen/page"})
    if (fs::exists(program / place / kScriptFile)) return (program / place).lexically_normal();
  throw Error(
      "this build of the program has no page for browsers: install what it is made with (deploy/install "
      "packages-wasm.txt) and build again (deploy/build)");
}

struct PageModelFile {
  const PageKind* kind;
  std::string bytes;
};

void require_use_of(const PageText& text, const PageKind& kind) {
  const Json about = Json::parse(text.about);
  for (const std::string_view field : kind.without)
    if (about.contains(field))
      throw ConfigError("--about: the page of " + std::string(kind.name) + " has no \"" + std::string(field) + "\"");
}

/// A model that a page draws, and says this of.
PageModelFile model_for_page(const fs::path& model, const PageText& text) {
  if (fs::is_directory(model))
    throw ConfigError(model.string() +
                      ": a page takes a model that is one file: sheen-reconstructor compress makes it");
  std::string bytes = read_file(model);
  for (const PageKind& kind : kKinds)
    if (kind.reads(bytes)) {
      require_use_of(text, kind);
      return {&kind, std::move(bytes)};
    }
  throw ConfigError(model.string() +
                    ": a page shows surface light fields (.slf) and irradiance fields (.rif), and this is neither");
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
  constexpr int kVariant = sodium_base64_VARIANT_ORIGINAL;
  std::string out(sodium_base64_encoded_len(bytes.size(), kVariant), '\0');
  sodium_bin2base64(out.data(), out.size(), reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(),
                    kVariant);
  out.pop_back();  // the end of a C string
  return out;
}

/// The one place in the page's text that is to be something else.
void put(std::string& page, std::string_view place, const std::string& what) {
  const std::size_t at = page.find(place);
  if (at == std::string::npos) throw Error("the page of this build has no \"" + std::string(place) + "\"");
  page.replace(at, place.size(), what);
}

std::string titled_page(const fs::path& from, const PageKind& kind, const PageText& text) {
  std::string page = read_file(from / kPageFile);
  const std::string title = escaped(text.title);
  put(page, "<title>Sheen</title>", "<title>" + title + "</title>");
  put(page, "<h1 id=\"title\">Sheen</h1>", "<h1 id=\"title\">" + title + "</h1>");
  put(page, "id=\"about\">{}<", "id=\"about\">" + text.about + "<");
  put(page, "data-model=\"model.slf\"", "data-model=\"" + std::string(kind.model) + "\"");
  return page;
}

/// Data that a script of the page finds by its name.
std::string inside(std::string_view id, const std::string& text) {
  return "<script type=\"text/plain\" id=\"" + std::string(id) + "\">" + text + "</script>\n";
}

/// Three numbers, where the field is there or must be.
void check_point(const Json& object, const char* field, bool required, const std::string& where) {
  if (!required && !object.contains(field)) return;
  const Json point = object.value(field, Json());
  const auto is_number = [](const Json& number) { return number.is_number(); };
  if (!point.is_array() || point.size() != 3 || !std::all_of(point.begin(), point.end(), is_number))
    throw std::runtime_error(where + "\"" + field + "\" is not three numbers");
}

void check_string(const Json& object, const char* field, bool required, const std::string& where) {
  if (!required && !object.contains(field)) return;
  if (!object.value(field, Json()).is_string()) throw std::runtime_error(where + "\"" + field + "\" is not a text");
}

void check_fields(const Json& object, std::initializer_list<std::string_view> known, const std::string& where) {
  if (!object.is_object()) throw std::runtime_error(where + "is not an object { ... }");
  for (const auto& [field, value] : object.items())
    if (std::find(known.begin(), known.end(), field) == known.end())
      throw std::runtime_error(where + "\"" + field + "\" is none of its fields");
}

void check_about(const Json& about) {
  check_fields(about, {"title", "text", "notes", "up", "eye", "target", "light"}, "");
  for (const char* field : {"title", "text"}) check_string(about, field, false, "");
  for (const char* field : {"up", "eye", "target", "light"}) check_point(about, field, false, "");
  const Json notes = about.value("notes", Json::array());
  if (!notes.is_array()) throw std::runtime_error("\"notes\" is not a list [ ... ]");
  for (std::size_t i = 0; i < notes.size(); ++i) {
    const std::string where = "note " + std::to_string(i + 1) + ": ";
    check_fields(notes[i], {"at", "title", "text"}, where);
    check_point(notes[i], "at", true, where);
    check_string(notes[i], "title", true, where);
    check_string(notes[i], "text", false, where);
  }
}

/// JSON that can stand in HTML.
std::string in_html(const Json& json) {
  std::string out;
  for (const char c : json.dump()) out += c == '<' ? "\\u003c" : std::string(1, c);
  return out;
}

}  // namespace

PageText page_text(const fs::path& model) {
  return {.title = model.stem().string()};
}

PageText read_page_text(const fs::path& file, const fs::path& model) {
  try {
    const Json about = Json::parse(read_file(file));
    check_about(about);
    return {about.value("title", page_text(model).title), in_html(about)};
  } catch (const Json::exception& error) {
    throw FileError(file.string(), std::string("is not valid JSON: ") + error.what());
  } catch (const FileError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw FileError(file.string(), error.what());
  }
}

void write_page(const fs::path& model, const fs::path& folder, const PageText& text) {
  const auto [kind, bytes] = model_for_page(model, text);
  const fs::path from = page_folder();
  make_folder(folder);
  for (const std::string_view file : {kStyleFile, kScriptFile}) write_file(folder / file, read_file(from / file));
  write_file(folder / kWorkerFile, read_file(from / kind->worker));
  write_file(folder / kDecoderFile, read_file(from / kind->decoder));
  write_file(folder / kind->model, bytes);
  write_file(folder / kPageFile, titled_page(from, *kind, text));
}

void write_single_page(const fs::path& model, const fs::path& file, const PageText& text) {
  const auto [kind, bytes] = model_for_page(model, text);
  const fs::path from = page_folder();
  std::string page = titled_page(from, *kind, text);
  put(page, "<link rel=\"stylesheet\" href=\"sheen.css\">", "<style>\n" + read_file(from / kStyleFile) + "</style>");
  put(page, "<script src=\"sheen.js\" defer></script>",
      inside("sheen-worker", read_file(from / kind->worker)) +
          inside("sheen-wasm", base64(read_file(from / kind->decoder))) + inside("sheen-model", base64(bytes)) +
          "<script>\n" + read_file(from / kScriptFile) + "</script>");
  write_file(file, page);
}

}  // namespace sheen

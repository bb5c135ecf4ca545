// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/scene/scene_config.h"

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "reconstructor/models/model_registry.h"

namespace sheen {
namespace {

std::string place(const std::filesystem::path& file, const toml::source_region& source) {
  return file.string() + ":" + std::to_string(source.begin.line) + ": ";
}

SettingValue value_of(const toml::node& node) {
  if (const auto whole = node.value_exact<std::int64_t>()) return *whole;
  if (const auto number = node.value_exact<double>()) return *number;
  if (const auto text = node.value_exact<std::string>()) return *text;
  return {};
}

std::string text_of(const SettingValue& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return std::to_string(*whole);
  if (const auto* word = std::get_if<std::string>(&value)) return '"' + *word + '"';
  return format("%.9g", std::get<double>(value));
}

std::string header_of(SettingTable table, const std::string& model) {
  switch (table) {
    case SettingTable::kImages:
      return "images";
    case SettingTable::kModel:
      return model;
    case SettingTable::kAdvanced:
      return model + ".advanced";
    case SettingTable::kStudy:
      break;
  }
  return model + ".study";
}

constexpr SettingTable kTables[] = {SettingTable::kImages, SettingTable::kModel, SettingTable::kAdvanced,
                                    SettingTable::kStudy};

/// Null where the file does not have it.
const toml::table* table_in(const toml::table& document, SettingTable table, const std::string& model) {
  return document.at_path(header_of(table, model)).as_table();
}

/// Where the key stands that a broken rule ("NAME: KEY must be ...") begins with.
std::string place_of_rule(const std::filesystem::path& file, const toml::table& document, const std::string& model,
                          const std::string& rule) {
  for (const SettingTable table : kTables)
    if (const toml::table* keys = table_in(document, table, model))
      for (const auto& [key, value] : *keys)
        if (rule.find(": " + std::string(key.str()) + " ") != std::string::npos) return place(file, value.source());
  return file.string() + ": ";
}

/// Where else the key would be right: engineers' keys and those of images have tables of their own.
std::string remedy(const std::vector<SettingKey>& keys, SettingTable table, const std::string& key,
                   const std::string& model) {
  std::string list;
  for (const SettingKey& known : keys) {
    if (known.name == key) return key + " stands in [" + header_of(known.table, model) + "]";
    if (known.table == table) list += (list.empty() ? "" : ", ") + known.name;
  }
  return "unknown key " + key + "; [" + header_of(table, model) + "] has " + list;
}

void read_table(const toml::table& values, SettingTable table, const std::vector<SettingKey>& keys,
                const std::string& model, const std::filesystem::path& file) {
  for (const auto& [name, value] : values) {
    if (table == SettingTable::kModel && value.is_table() && (name == "advanced" || name == "study")) continue;
    const std::string key(name.str());
    const auto known =
        std::find_if(keys.begin(), keys.end(), [&](const SettingKey& k) { return k.table == table && k.name == key; });
    if (known == keys.end()) throw ConfigError(place(file, value.source()) + remedy(keys, table, key, model));
    if (const std::string demand = known->set(value_of(value)); !demand.empty())
      throw ConfigError(place(file, value.source()) + key + " " + demand);
  }
}

/// Null where no kind has the name.
const ModelKind* kind_named(std::string_view name) {
  for (const ModelKind* kind : model_kinds())
    if (name == kind->name()) return kind;
  return nullptr;
}

constexpr const char* kAuto = "auto";

std::string names_of_kinds() {
  std::string list;
  for (const ModelKind* kind : model_kinds()) list += (list.empty() ? "\"" : ", \"") + std::string(kind->name()) + '"';
  return list;
}

toml::table parse_document(std::string_view text, const std::filesystem::path& file) {
  try {
    return toml::parse(text, file.string());
  } catch (const toml::parse_error& error) {
    throw ConfigError(place(file, error.source()) + std::string(error.description()));
  }
}

bool is_auto(const toml::table& document) {
  return document["model"].value_or(std::string()) == kAuto;
}

/// The kind that the file names, or leaves to be chosen, else the first one.
const ModelKind& kind_in(const toml::table& document, const std::filesystem::path& file, const ModelKind* chosen) {
  const toml::node* named = document.get("model");
  if (!named) return *model_kinds().front();
  if (is_auto(document) && chosen) return *chosen;
  if (is_auto(document))
    throw ConfigError(place(file, named->source()) +
                      "model: only `build` and `serve` choose it (\"auto\"); for this command name one of " +
                      names_of_kinds());
  if (const ModelKind* kind = kind_named(named->value_or(std::string()))) return *kind;
  throw ConfigError(place(file, named->source()) + "model must be one of " + names_of_kinds() + ", or \"auto\"");
}

/// All effort levels, as `tradeoff` measured them.
MeasuredLevels levels_of(const toml::node& entries, std::size_t levels, const std::filesystem::path& file) {
  const auto fail = [&](const toml::node& at) {
    throw ConfigError(place(file, at.source()) + "[[effort_level]]: takes image_ms above 0 and psnr_db, " +
                      std::to_string(levels) + " times; `tradeoff --out` writes them");
  };
  MeasuredLevels measured;
  const toml::array* list = entries.as_array();
  if (!list || list->size() != levels) fail(entries);
  for (const toml::node& entry : *list) {
    const toml::table* table = entry.as_table();
    if (!table || table->size() != 2) fail(entry);
    const auto ms = (*table)["image_ms"].value<double>(), db = (*table)["psnr_db"].value<double>();
    if (!ms || !db || !(*ms > 0) || !std::isfinite(*ms) || !std::isfinite(*db)) fail(entry);
    measured.push_back({*ms, *db});
  }
  return measured;
}

}  // namespace

SceneConfig default_scene(const std::string& model) {
  SceneConfig scene{.kind = model_kinds().front()};
  if (!model.empty()) {
    std::string name = model;
    std::replace(name.begin(), name.end(), '-', '_');
    scene.kind = kind_named(name);
    if (!scene.kind) throw ConfigError("--model must be one of " + names_of_kinds() + ", or \"auto\", not " + model);
  }
  scene.settings = scene.kind->default_settings();
  return scene;
}

SceneConfig load_scene_config(const std::filesystem::path& file) {
  return parse_scene_config(read_file(file), file);
}

bool scene_chooses_model(std::string_view text, const std::filesystem::path& file) {
  return is_auto(parse_document(text, file));
}

SceneConfig parse_scene_config(std::string_view text, const std::filesystem::path& file, const ModelKind* chosen) {
  const toml::table document = parse_document(text, file);
  SceneConfig scene{.kind = &kind_in(document, file, chosen)};
  scene.settings = scene.kind->default_settings();
  const std::string model = scene.kind->name();
  const std::vector<SettingKey> keys = scene.settings->keys();
  for (const auto& [name, content] : document) {
    if (name == "model") continue;
    if (is_auto(document) && content.is_table() && kind_named(name.str())) continue;
    if (name == "effort_level" && is_auto(document))
      throw ConfigError(place(file, content.source()) +
                        "[[effort_level]] is of one model: name it in place of \"auto\"");
    if (name == "effort_level") {
      scene.measured = levels_of(content, static_cast<std::size_t>(scene.settings->effort_levels()), file);
      continue;
    }
    if ((name != "images" && name != model) || !content.is_table())
      throw ConfigError(place(file, content.source()) + "unknown section [" + std::string(name.str()) +
                        "]; a scene has model, [images], [" + model + "] and, from `tradeoff`, [[effort_level]]");
  }
  for (const SettingTable table : kTables)
    if (const toml::table* values = table_in(document, table, model)) read_table(*values, table, keys, model, file);
  try {
    scene.settings->require_valid();
  } catch (const ConfigError& error) {
    throw ConfigError(place_of_rule(file, document, model, error.what()) + error.what());
  }
  return scene;
}

std::string to_toml(const ModelSettings& settings) {
  const std::unique_ptr<ModelSettings> copy = settings.clone();
  const std::vector<SettingKey> keys = copy->keys();
  std::string text = "model = \"" + std::string(settings.kind()) + "\"\n";
  for (const SettingTable table : kTables) {
    std::string lines;
    for (const SettingKey& key : keys)
      if (key.table == table) lines += key.name + " = " + text_of(key.get()) + '\n';
    if (!lines.empty()) text += "\n[" + header_of(table, settings.kind()) + "]\n" + lines;
  }
  return text;
}

std::string levels_to_toml(const MeasuredLevels& measured) {
  std::string text;
  for (const MeasuredLevel& level : measured)
    text += format("[[effort_level]]\nimage_ms = %.9g\npsnr_db = %.9g\n", level.image_ms, level.psnr_db);
  return text;
}

}  // namespace sheen

// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/saved_model.h"

#include <nlohmann/json.hpp>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "reconstructor/models/model_registry.h"
#include "reconstructor/scene/scene_config.h"

namespace sheen {
namespace {

using nlohmann::json;

constexpr const char* kSceneKey = "scene";        // the settings as a scene file
constexpr const char* kCapturesKey = "captures";  // a JSON list: source_session, sequence, part, exposure_gain
constexpr const char* kCalibrationKey = "error_calibration";  // JSON: views, offset_db, half_width_db
constexpr const char *kHeldOut = "held_out", *kFolded = "folded", *kRepeated = "repeated";

json read_description(const std::filesystem::path& model_folder) {
  if (!std::filesystem::exists(model_folder)) throw FileError(model_folder.string(), "no such folder");
  const std::filesystem::path file = model_folder / kModelJsonFile;
  try {
    return json::parse(read_file(file));
  } catch (const json::exception& error) {
    throw FileError(file.string(), std::string("is no valid JSON: ") + error.what());
  }
}

}  // namespace

void save_reconstruction(Reconstruction& reconstruction, const std::filesystem::path& folder, const std::string& source,
                         const StepsDone& progress) {
  json captures = json::array();
  for (const KnownCapture& c : reconstruction.captures()) {
    if (c.status == IngestStatus::kRefused) continue;
    captures.push_back({{"source_session", c.source_session},
                        {"sequence", c.sequence},
                        {"part", c.status == IngestStatus::kHeldOut ? kHeldOut : (c.repeated ? kRepeated : kFolded)},
                        {"exposure_gain", c.exposure_gain}});
  }
  const ModelMetadata metadata{{"source", source},
                               {"images", std::to_string(reconstruction.counts().accepted)},
                               {kSceneKey, to_toml(reconstruction.model().settings())},
                               {kCapturesKey, captures.dump(-1, ' ', false, json::error_handler_t::replace)}};
  reconstruction.snapshot()->filled()->save(folder, metadata, progress);
}

void note_calibration(const ErrorCalibration& calibration, const std::filesystem::path& model_folder) {
  if (!calibration.known()) return;
  const std::filesystem::path file = model_folder / kModelJsonFile;
  json description = read_description(model_folder);
  description["metadata"][kCalibrationKey] = json{
      {"views", calibration.views},
      {"offset_db", calibration.offset_db},
      {"half_width_db",
       calibration.half_width_db}}.dump();
  write_file(file, description.dump() + "\n");
}

ErrorCalibration calibration_of(const SavedModel& model, const std::filesystem::path& folder) {
  const auto noted = model.metadata.find(kCalibrationKey);
  if (noted == model.metadata.end()) return {};
  try {
    const json calibration = json::parse(noted->second);
    return {.views = calibration.at("views"),
            .offset_db = calibration.at("offset_db"),
            .half_width_db = calibration.at("half_width_db")};
  } catch (const json::exception& error) {
    throw FileError((folder / kModelJsonFile).string(),
                    std::string("metadata.") + kCalibrationKey + ": " + error.what());
  }
}

const KnownCapture* ModelOrigin::find(const Capture& capture) const {
  const auto found = captures.find({capture.source_session, capture.sequence});
  return found == captures.end() ? nullptr : &found->second;
}

SavedModel open_model(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / kModelJsonFile;
  const json description = read_description(folder);
  const auto format = description.is_object() ? description.find("format") : description.end();
  for (const ModelKind* kind : model_kinds()) {
    if (format == description.end() || *format != kind->file_format()) continue;
    SavedModel model{.kind = kind, .snapshot = kind->load(folder)};
    if (const auto metadata = description.find("metadata"); metadata != description.end()) {
      if (!metadata->is_object()) throw FileError(file.string(), "metadata: must be an object");
      for (const auto& [key, value] : metadata->items()) {
        if (!value.is_string()) throw FileError(file.string(), "metadata." + key + ": must be a text");
        model.metadata[key] = value.get<std::string>();
      }
    }
    return model;
  }
  throw FileError(file.string(), "describes no model that this program knows");
}

ModelOrigin origin_of(const SavedModel& model, const std::filesystem::path& folder) {
  const ModelMetadata& metadata = model.metadata;
  if (!metadata.contains(kSceneKey) || !metadata.contains(kCapturesKey))
    throw FileError(folder.string(),
                    "does not say which images it was built from, as models of an older Sheen do not; build it again");
  const std::filesystem::path file = folder / kModelJsonFile;
  ModelOrigin origin;
  try {
    origin.settings = parse_scene_config(metadata.at(kSceneKey), file).settings;
  } catch (const ConfigError& error) {
    throw FileError(folder.string(),
                    std::string("was saved by another version of Sheen; build it again: ") + error.what());
  }
  try {
    for (const json& entry : json::parse(metadata.at(kCapturesKey))) {
      const auto part = entry.at("part").get<std::string>();
      KnownCapture known{.source_session = entry.at("source_session"),
                         .sequence = entry.at("sequence"),
                         .status = part == kHeldOut ? IngestStatus::kHeldOut : IngestStatus::kAccepted,
                         .repeated = part == kRepeated,
                         .exposure_gain = entry.at("exposure_gain")};
      if (!(known.exposure_gain > 0))
        throw FileError(file.string(), "metadata.captures: exposure_gain must be positive");
      origin.captures.insert_or_assign({known.source_session, known.sequence}, std::move(known));
    }
  } catch (const json::exception& error) {
    throw FileError(file.string(), std::string("metadata.captures: ") + error.what());
  }
  return origin;
}

}  // namespace sheen

// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/saved_model.h"

#include <cmath>
#include <cstdlib>
#include <limits>
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
constexpr const char* kHeldOutPsnrKey = "held_out_psnr_db";
constexpr const char *kHeldOut = "held_out", *kFolded = "folded", *kRepeated = "repeated";

json read_description(const std::filesystem::path& model_folder) {
  const std::filesystem::path file = model_folder / kModelJsonFile;
  try {
    return json::parse(read_file(file));
  } catch (const json::exception& error) {
    throw FileError(file.string(), std::string("is no valid JSON: ") + error.what());
  }
}

/// The file of a model that says what was noted of it: itself, or the one in its folder.
std::filesystem::path notes_file(const std::filesystem::path& model) {
  return std::filesystem::is_directory(model) ? model / kModelJsonFile : model;
}

/// Of a model that is one file. Throws FileError.
const ModelKind& kind_of_file(const std::filesystem::path& file) {
  constexpr std::size_t kStart = 64;
  const std::string start = read_file_start(file, kStart);
  for (const ModelKind* kind : model_kinds())
    if (kind->reads_file(start)) return *kind;
  throw FileError(file.string(), "is no model that this program knows");
}

ModelMetadata metadata_in(const json& description, const std::filesystem::path& file) {
  ModelMetadata notes;
  const auto metadata = description.find("metadata");
  if (metadata == description.end()) return notes;
  if (!metadata->is_object()) throw FileError(file.string(), "metadata: must be an object");
  for (const auto& [key, value] : metadata->items()) {
    if (!value.is_string()) throw FileError(file.string(), "metadata." + key + ": must be a text");
    notes[key] = value.get<std::string>();
  }
  return notes;
}

/// What is noted of how a model came to be.
ModelMetadata metadata_of(const Reconstruction& reconstruction, const std::string& source) {
  json captures = json::array();
  for (const KnownCapture& c : reconstruction.account().captures()) {
    if (c.status == IngestStatus::kRefused) continue;
    captures.push_back({{"source_session", c.source_session},
                        {"sequence", c.sequence},
                        {"part", c.status == IngestStatus::kHeldOut ? kHeldOut : (c.repeated ? kRepeated : kFolded)},
                        {"exposure_gain", c.exposure_gain}});
  }
  return {{"source", source},
          {"images", std::to_string(reconstruction.account().counts().accepted)},
          {kSceneKey, to_toml(reconstruction.model().settings())},
          {kCapturesKey, captures.dump(-1, ' ', false, json::error_handler_t::replace)}};
}

}  // namespace

void save_reconstruction(Reconstruction& reconstruction, const std::filesystem::path& folder, const std::string& source,
                         const StepsDone& progress) {
  reconstruction.snapshot()->filled()->save(folder, metadata_of(reconstruction, source), progress);
}

CompressedModel save_compressed(Reconstruction& reconstruction, const std::filesystem::path& file,
                                const std::string& source, CompressionTarget target) {
  const std::vector<HeldOutView>& views = reconstruction.held_out();
  if (!views.empty())
    target.judge = [&views](const ModelSnapshot& model) {
      const RayPainter painter(model.mesh());
      double sum = 0;
      for (const HeldOutView& view : views) sum += score_object(view, model, painter).psnr_db;
      return sum / static_cast<double>(views.size());
    };
  CompressedModel small = reconstruction.snapshot()->filled()->compressed(target);
  small.snapshot->save(file, metadata_of(reconstruction, source), {});
  note_judgement(score(views, *small.snapshot, RayPainter(small.snapshot->mesh())), file);
  return small;
}

void note_judgement(const Scores& scores, const std::filesystem::path& model) {
  ModelMetadata notes;
  if (std::isfinite(scores.psnr_db)) notes[kHeldOutPsnrKey] = std::to_string(scores.psnr_db);
  if (const ErrorCalibration calibration = calibrate(scores); calibration.known())
    notes[kCalibrationKey] = json{{"views", calibration.views},
                                  {"offset_db", calibration.offset_db},
                                  {"half_width_db", calibration.half_width_db}}
                                 .dump();
  if (notes.empty()) return;
  if (std::filesystem::is_directory(model)) {
    json description = read_description(model);
    for (const auto& [key, note] : notes) description["metadata"][key] = note;
    write_file(notes_file(model), description.dump() + "\n");
  } else {
    const ModelKind& kind = kind_of_file(model);
    notes.merge(kind.file_metadata(model));
    kind.set_file_metadata(model, notes);
  }
}

double held_out_psnr_db(const SavedModel& model) {
  const auto noted = model.metadata.find(kHeldOutPsnrKey);
  if (noted == model.metadata.end()) return std::numeric_limits<double>::quiet_NaN();
  return std::strtod(noted->second.c_str(), nullptr);
}

ErrorCalibration calibration_of(const SavedModel& model, const std::filesystem::path& path) {
  const auto noted = model.metadata.find(kCalibrationKey);
  if (noted == model.metadata.end()) return {};
  try {
    const json calibration = json::parse(noted->second);
    return {.views = calibration.at("views"),
            .offset_db = calibration.at("offset_db"),
            .half_width_db = calibration.at("half_width_db")};
  } catch (const json::exception& error) {
    throw FileError(notes_file(path).string(), std::string("metadata.") + kCalibrationKey + ": " + error.what());
  }
}

const KnownCapture* ModelOrigin::find(const Capture& capture) const {
  const auto found = captures.find({capture.source_session, capture.sequence});
  return found == captures.end() ? nullptr : &found->second;
}

SavedModel open_model(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) throw FileError(path.string(), "no such model");
  if (!std::filesystem::is_directory(path)) {
    const ModelKind& kind = kind_of_file(path);
    return {.kind = &kind, .snapshot = kind.load(path), .metadata = kind.file_metadata(path)};
  }
  const json description = read_description(path);
  const auto format = description.is_object() ? description.find("format") : description.end();
  for (const ModelKind* kind : model_kinds())
    if (format != description.end() && *format == kind->file_format())
      return {.kind = kind, .snapshot = kind->load(path), .metadata = metadata_in(description, notes_file(path))};
  throw FileError(notes_file(path).string(), "describes no model that this program knows");
}

ModelOrigin origin_of(const SavedModel& model, const std::filesystem::path& path) {
  const ModelMetadata& metadata = model.metadata;
  if (!metadata.contains(kSceneKey) || !metadata.contains(kCapturesKey))
    throw FileError(path.string(),
                    "does not say which images it was built from, as models of an older Sheen do not; build it again");
  const std::filesystem::path file = notes_file(path);
  ModelOrigin origin;
  try {
    origin.settings = parse_scene_config(metadata.at(kSceneKey), file).settings;
  } catch (const ConfigError& error) {
    throw FileError(path.string(),
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

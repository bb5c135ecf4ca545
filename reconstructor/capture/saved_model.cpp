// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/saved_model.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/base/errors.h"
#include "reconstructor/effort/memory_need.h"
#include "reconstructor/models/surface_light_field/files/model_files.h"
#include "reconstructor/models/surface_light_field/fill_unseen.h"
#include "reconstructor/scene/scene_config.h"

namespace sheen {
namespace {

using nlohmann::json;

constexpr const char* kSceneKey = "scene";        // the settings as a scene file
constexpr const char* kCapturesKey = "captures";  // a JSON list: source_session, sequence, part, exposure_gain
constexpr const char* kCalibrationKey = "error_calibration";  // JSON: views, offset_db, half_width_db
constexpr const char *kHeldOut = "held_out", *kFolded = "folded", *kRepeated = "repeated";

}  // namespace

Mesh load_mesh_and_warn(const std::filesystem::path& path, const SurfaceLightFieldOptions& options,
                        std::span<const PosedCamera> cameras) {
  LoadedMesh loaded = load_mesh(path);
  const MeshDiagnosis& found = loaded.diagnosis;
  std::fprintf(stderr, "%s: %zu triangles, %s\n", path.c_str(), found.triangles, size_text(loaded.mesh).c_str());
  for (const std::string& warning : found.warnings()) std::fprintf(stderr, "%s: %s\n", path.c_str(), warning.c_str());
  const std::string memory = memory_warning(path, found.vertices, found.triangles, options, machine_memory());
  if (!memory.empty()) std::fprintf(stderr, "%s\n", memory.c_str());
  check_scale(path, loaded.mesh, cameras);
  return std::move(loaded.mesh);
}

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
  save_model(*fill_unseen(*reconstruction.snapshot()), folder,
             {{"source", source},
              {"images", std::to_string(reconstruction.counts().accepted)},
              {kSceneKey, to_toml(reconstruction.model().options())},
              {kCapturesKey, captures.dump(-1, ' ', false, json::error_handler_t::replace)}},
             {.progress = progress});
}

void note_calibration(const ErrorCalibration& calibration, const std::filesystem::path& model_folder) {
  if (!calibration.known()) return;
  note_in_model(model_folder, kCalibrationKey,
                json{{"views", calibration.views},
                     {"offset_db", calibration.offset_db},
                     {"half_width_db", calibration.half_width_db}}
                    .dump());
}

ErrorCalibration load_calibration(const std::filesystem::path& model_folder) {
  const ModelMetadata metadata = load_model_metadata(model_folder);
  const auto noted = metadata.find(kCalibrationKey);
  if (noted == metadata.end()) return {};
  try {
    const json calibration = json::parse(noted->second);
    return {.views = calibration.at("views"),
            .offset_db = calibration.at("offset_db"),
            .half_width_db = calibration.at("half_width_db")};
  } catch (const json::exception& error) {
    throw FileError((model_folder / "model.json").string(),
                    std::string("metadata.") + kCalibrationKey + ": " + error.what());
  }
}

const KnownCapture* ModelOrigin::find(const Capture& capture) const {
  const auto found = captures.find({capture.source_session, capture.sequence});
  return found == captures.end() ? nullptr : &found->second;
}

ModelOrigin load_origin(const std::filesystem::path& model_folder) {
  const ModelMetadata metadata = load_model_metadata(model_folder);
  if (!metadata.contains(kSceneKey) || !metadata.contains(kCapturesKey))
    throw FileError(model_folder.string(),
                    "does not say which images it was built from, as models of an older Sheen do not; build it anew");
  const std::filesystem::path file = model_folder / "model.json";
  ModelOrigin origin{.options = parse_scene_config(metadata.at(kSceneKey), file).surface_light_field};
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
